/* SPDX-License-Identifier: Apache-2.0 */
/* What the hazard check knows of a batch: which accesses of its commands the journal lacks, and
 * how the number of an access leads back to its command. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_BATCHES_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_BATCHES_H

#include "layer/hazards/executed/shaders.h"
#include "src/base/unknown.h"
#include "src/hazards/hazards.h"
#include "src/report/hazard_message.h"
#include "src/state/commands/hazard_entries.h"
#include "src/state/order/order.h"
#include "src/state/resources/destroyed.h"

struct layer_device;
struct structures;

enum hazard_input_kind {
    INPUT_REFERENCE, /* a structure that an instance refers to */
    INPUT_INDICES,   /* the indices of a geometry of triangles */
    INPUT_DATA,      /* the vertices, boxes or instances of a geometry */
    COPIED_BYTES,    /* what a copy writes of its dst; `position`: see hazard_batch_copied() */
    INPUT_ACCESS,    /* any access of a build at addresses; `position`: its number in the journal */
};

/* A build, and a geometry. */
struct hazard_place {
    const struct journal *journal;
    uint32_t position;      /* of the build in its command buffer */
    uint32_t kind : 3;      /* enum hazard_input_kind */
    uint32_t geometry : 29; /* of a reference: 0 */
};

/* What a build reads, or an INPUT_ACCESS writes, besides what the journal says. */
struct hazard_input {
    struct hazard_place place;
    union {
        struct {
            uint64_t structure;
            struct hazard_bytes bytes;
            /* An INPUT_ACCESS has it, and a reference to a structure without a handle: then
             * `structure` is the VkBuffer. */
            bool is_placed;
            enum access_kind access;
            enum hazard_role role;
        };
        struct {
            uint32_t smallest, largest;
        };
        struct data_read data;
    };
};
enum { HAZARD_INDEXED_READS = 2 }; /* of each HAZARD_INDEXED entry */

/* A command, and the number of its first access; the other accesses follow it. */
struct hazard_command {
    uint64_t first;
    const struct journal *journal;
    const struct hazard_entry *item;
    struct chunk_place place; /* behind the item */
};

/* The end of an object of which the hazard check has a record. */
enum hazard_end { MEMORY_FREED, EVENT_DESTROYED, STRUCTURE_DESTROYED };

struct ended_object {
    struct ended_object *next;
    enum hazard_end ended;
    uint64_t id;                    /* of memory; of others the handle */
    uint64_t after;                 /* the number of batches before */
    char name[DESTROYED_NAME_SIZE]; /* STRUCTURE_DESTROYED: its debug name */
    /* But for events: what the host had observed to be complete, see
     * execution_order_find_observed(). */
    bool observed_clock_is_known;
    uint64_t untracked;
    struct execution_clock observed;
};

/* The slot of a batch, from its execution point on. Until it is judged, the lock of the list guards
 * the members up to `inputs_unknown`; then they and the others belong to the thread that judges.
 */
struct hazard_batch_record {
    struct order_batch *batch;
    bool is_taken;      /* it is being judged, or was */
    bool awaits_inputs; /* a command buffer has accesses that instances or indices decide */
    bool has_run;       /* no more instances will be expected */
    uint32_t awaited;   /* command buffers whose instances are not yet known */
    struct hazard_input *inputs;
    uint32_t input_count, input_capacity;
    struct unknown inputs_unknown; /* memory ran out */
    uint64_t untracked;            /* see execution_order_find_observed(), before the submission */

    /* In ascending order, once the batch is judged. */
    struct hazard_command *commands;
    uint32_t command_count, command_capacity;
};

/* Returns NULL if memory runs out. */
struct hazard_batch_record *hazard_batch_create(struct order_batch *batch);
void hazard_batch_free(struct hazard_batch_record *batch);
/* Adds a reference or indices. Sets inputs_unknown if memory runs out. */
void hazard_batch_add(struct hazard_batch_record *batch, const struct hazard_input *input);
/* Call once all references and indices are known, before the functions below. */
void hazard_batch_sort(struct hazard_batch_record *batch);
/* Returns the references of a command, or what a build at addresses accesses besides. */
const struct hazard_input *hazard_batch_references(const struct hazard_batch_record *batch,
                                                   const struct hazard_command *command,
                                                   uint32_t *count);
/* Returns the bytes of the vertices that a HAZARD_INDEXED entry reads; no bytes if unknown. */
void hazard_batch_vertices(const struct hazard_batch_record *batch,
                           const struct hazard_command *command, const struct hazard_entry *item,
                           struct hazard_bytes vertices[HAZARD_INDEXED_READS]);
/* Returns the data that the access of an entry reads; NULL if they are unknown. */
const struct data_read *hazard_batch_data(const struct hazard_batch_record *batch,
                                          const struct hazard_command *command,
                                          const struct hazard_entry *item);
/* Finds what the copies of the batch write, as far as the host has read the size of their src. Call
 * once the batch was replayed, on the thread that runs batches. */
void hazard_batch_add_copies(struct hazard_batch_record *batch,
                             const struct structures *structures);
/* Returns the bytes that a copy of the journal writes of the structure whose first byte is given,
 * or this byte if they are unknown. */
struct hazard_bytes hazard_batch_copied(const struct hazard_batch_record *batch,
                                        const struct journal *journal, uint64_t structure,
                                        const struct hazard_bytes *first);
/* Notes a command. Returns false if memory runs out: its accesses can't be found then. */
bool hazard_batch_note(struct hazard_batch_record *batch, const struct hazard_command *command);

/* Describes an access of the batch by its number. Returns false if it is unknown. */
bool hazard_batch_find(const struct layer_device *device, const struct hazard_batch_record *batch,
                       uint64_t number, struct hazard_access_text *side);

#endif
