/* SPDX-License-Identifier: Apache-2.0 */
/* Judges batches one by one, in execution order: gives their accesses and synchronization to the
 * hazard check, and reports what it finds. One thread at a time, without a lock. */
#ifndef ASSAY_LAYER_EXECUTION_HAZARDS_JUDGE_H
#define ASSAY_LAYER_EXECUTION_HAZARDS_JUDGE_H

#include "layer/execution/hazards/batches.h"
#include "layer/execution/hazards/shaders.h"
#include "layer/layer.h"

enum { HAZARD_KINDS_REPORTED = 8 }; /* in one command; each is reported once */

/* Hazards of one kind in the command that is being judged. */
struct kind_of_hazard {
    struct hazard first;
    uint32_t count;
};

struct hazard_judge {
    struct layer_device *device;
    struct hazards *hazards;
    struct shader_judge shaders;
    bool lost; /* memory ran out: what is known proves nothing */
    /* Batches that later ones are compared with are kept: in execution order, and so in ascending
     * order of their accesses' numbers, up to `last`; NULL: none. */
    struct batch_list *batches;
    struct order_batch *last;
    uint32_t judged_count; /* that are kept */
    uint64_t batch_count;  /* that were judged */
    /* Accesses of the current batch may be missing: a structure may have been written unseen. */
    bool lacks_accesses;
    struct handle_table written; /* see overwritten.c */
    struct hazard_batch_record *current;
    struct kind_of_hazard kinds[HAZARD_KINDS_REPORTED];
    uint32_t kind_count;
};

/* `judge` is zero-initialized. Returns false if memory runs out. */
bool hazard_judge_begin(struct hazard_judge *judge, struct layer_device *device);
void hazard_judge_end(struct hazard_judge *judge);
/* Takes over the batch, whose references are all known, and lets go of it later. */
void hazard_judge_batch(struct hazard_judge *judge, struct hazard_batch_record *batch);
/* Drops the record of an object. No batch that is yet to be judged uses it. */
void hazard_judge_end_object(struct hazard_judge *judge, const struct ended_object *ended);

/* ---- for the files of the check */

/* Describes an access by its number. Returns false if it is not known any more. */
bool hazard_judge_find_side(const struct hazard_judge *judge, uint64_t number,
                            struct hazard_access_text *side);
/* The current command has a hazard. `user`: a struct hazard_judge. */
void hazard_judge_found(void *user, const struct hazard *hazard);

#endif
