/* SPDX-License-Identifier: Apache-2.0 */
/* The state of the hazard check, and the reports of what it finds. One thread at a time, without a
 * lock. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_REPORTS_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_REPORTS_H

#include "layer/hazards/executed/batches.h"
#include "layer/hazards/executed/shaders.h"
#include "layer/layer.h"
#include "src/base/unknown.h"

enum { HAZARD_KINDS_REPORTED = 8 }; /* in one command; each is reported once */

/* Hazards of one kind in the command that is being judged. */
struct kind_of_hazard {
    struct hazard first;
    uint32_t count;
    uint64_t last_earlier; /* number of the last one's earlier access */
    /* READ_AFTER_WRITE: the kind of access with which the command also writes what it reads, if
     * the same dependency is missing for that; else ACCESS_KINDS. */
    enum access_kind write;
    bool earlier_is_known; /* `earlier` describes the earlier access: its batch may be forgotten */
    struct hazard_access_text earlier;
};

struct hazard_search {
    struct layer_device *device;
    struct hazards *hazards;
    struct trace_search shaders;
    struct unknown unknown; /* what is known of earlier batches proves nothing */
    /* Batches that later ones are compared with are kept: in execution order, and so in ascending
     * order of their accesses' numbers, up to `last`; NULL: none. */
    struct batch_list *batches;
    struct order_batch *last;
    uint32_t judged_count;                       /* that are kept */
    uint64_t batch_count;                        /* that were judged */
    struct handle_table written, written_places; /* see overwritten.c */
    struct hazard_batch_record *current;
    /* Whose accesses follow; `first` and `journal` stay when it has ended and `item` is NULL. */
    struct hazard_command command;
    struct kind_of_hazard kinds[HAZARD_KINDS_REPORTED];
    uint32_t kind_count;
};

/* Returns the judged batch behind `after`, or the first one if that is NULL. */
struct order_batch *hazard_search_next(const struct hazard_search *search,
                                       const struct order_batch *after);
/* Returns the batch that has the access of a number, the current one included; NULL if it is not
 * known any more. */
const struct order_batch *hazard_search_find_batch(const struct hazard_search *search,
                                                   uint64_t number);
/* Describes an access by its number. Returns false if it is not known any more. */
bool hazard_search_find_side(const struct hazard_search *search, uint64_t number,
                             struct hazard_access_text *side);
/* Fills `barrier` if the accesses are of one queue, and if a barrier between them lacks a stage or
 * an access on one side; the last one, if there are several. In barriers.c. */
void hazard_search_find_barrier(const struct hazard_search *search, const struct hazard *hazard,
                                struct hazard_barrier_text *barrier);
/* The current command has a hazard. `user`: a struct hazard_search. */
void hazard_search_found(void *user, const struct hazard *hazard);
/* The same, with a description of the earlier access. */
void hazard_search_found_after(struct hazard_search *search, const struct hazard *hazard,
                               const struct hazard_access_text *earlier);
/* Sends what the current command has, and ends it. */
void hazard_search_report(struct hazard_search *search);

#endif
