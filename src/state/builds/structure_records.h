/* SPDX-License-Identifier: Apache-2.0 */
/* The members of a table of structures. Only structure_records.c includes this header. */
#ifndef ASSAY_STATE_BUILDS_STRUCTURE_RECORDS_H
#define ASSAY_STATE_BUILDS_STRUCTURE_RECORDS_H

#include <stdlib.h>

#include "src/base/unknown.h"
#include "src/platform/threads.h"
#include "src/state/builds/structures.h"

/* Guarded by the table's lock. */
struct structure_more {
    /* Instances may disable micromaps, or not, since the write with serial `since` at `written`:
     * every later write had the same flag. `since` 0: unknown. */
    bool allows_disabling;
    uint64_t since;
    struct timestamp written;
    void *input; /* of the latest build that was read; NULL: unknown */
    /* While `input` is unknown: the id of the structure that this one was copied from, or 0. */
    uint64_t copy_of;
    void *notes; /* see structures_lock_notes(); owned */
};

/* A record before commands that may fail. */
struct structure_before {
    uint64_t id;
    bool had_record; /* false: the members below are unused */
    struct built built;
    struct timestamp written;
};

struct structures_shared {
    struct structure_before *undo; /* only the writer uses these three */
    uint32_t undo_count, undo_capacity;
    enum structures_keeping keeping;       /* keeping and inputs never change */
    const struct structure_inputs *inputs; /* or NULL */
    pthread_mutex_t lock;                  /* guards the members below */
    struct unknown unknown;                /* all records were removed */
    uint64_t serial;                       /* number of writes; if serials are kept */
    struct handle_table other_inputs; /* by id, of structures without a record: executions that were
                                       * not read yet may have used them */
    struct destroyed_ids {
        uint64_t first_id;
        uint32_t count;
    } * destroyed;
    uint32_t destroyed_count, destroyed_capacity;
};

static inline void lock_shared(const struct structures *structures)
{
    if (structures->shared)
        pthread_mutex_lock(&structures->shared->lock);
}

static inline void unlock_shared(const struct structures *structures)
{
    if (structures->shared)
        pthread_mutex_unlock(&structures->shared->lock);
}

/* Returns NULL if there is no memory. */
static inline struct structure_more *more_of(struct structure *structure)
{
    if (!structure->more)
        structure->more = calloc(1, sizeof(*structure->more));
    return structure->more;
}

#endif
