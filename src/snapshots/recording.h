/* SPDX-License-Identifier: Apache-2.0 */
/* What the commands of a command buffer do to acceleration structures, in recorded
 * order.
 *
 * Nothing of it is done when the commands execute: the device only copies what builds read into
 * chunks of memory. Each submission makes an execution of the recording, and when its turn has come
 * (execution_order.h) the items tell what structures hold from then on. Only its command buffer,
 * whose use the application synchronizes, adds to a recording.
 *
 * An application may by mistake record further after a submission, so an execution has counts of
 * its own and reads nothing that was recorded later. It may also submit a command buffer again that
 * it began with ONE_TIME_SUBMIT, whose chunks are given back when no execution is left: executions
 * made after that have no snapshots. */
#ifndef ASSAY_SNAPSHOTS_RECORDING_H
#define ASSAY_SNAPSHOTS_RECORDING_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "src/snapshots/buffer_target.h"
#include "src/snapshots/recorded_build.h"
#include "src/snapshots/ticket.h"

/* Memory that the device copies to. Part of a larger structure of who allocates it. */
struct snapshot_chunk {
    unsigned char *bytes; /* mapped, coherent */
    uint64_t size, used;
};

enum item_kind {
    ITEM_BUILD,
    ITEM_UPDATE,
    ITEM_CLONE,
    ITEM_COMPACT,
    ITEM_SERIALIZE,
    ITEM_DESERIALIZE,
    ITEM_WRITE_QUERIES,
    ITEM_RESET_QUERIES,
    ITEM_COPY_QUERIES,
    ITEM_EXECUTE, /* a secondary command buffer */
};

struct recorded_item {
    struct recorded_item *next;
    enum item_kind kind;
    uint64_t dst, src;        /* structures */
    uint64_t pool;            /* of queries, */
    uint32_t first, count;    /* which */
    VkDeviceSize stride;      /* of copied queries */
    VkQueryResultFlags flags; /* likewise */
    uint64_t *structures;     /* whose properties are written: `count` */
    VkQueryType query_type;
    struct recorded_build *build; /* of builds and updates */
    struct snapshot serialized;   /* a structure's serialized form */
    struct buffer_target target;  /* of COPY_QUERIES: where results go */
    VkDeviceAddress address;      /* of SERIALIZE: likewise, at whatever has it by then */
    struct recording *secondary;
};

enum { CONSTANT_WORDS = 64, LEFT_OUT_NAMED = 8 };

/* Conditional rendering that the command buffer has begun. */
enum condition_kind { CONDITION_NONE, CONDITION_IN_BUFFER, CONDITION_AT_ADDRESS };
struct condition {
    enum condition_kind kind;
    VkConditionalRenderingFlagsEXT flags;
    VkBuffer buffer;
    VkDeviceSize offset;
    VkDeviceAddressRangeKHR range;
    VkAddressCommandFlagsKHR address_flags;
};

/* What the application has bound and pushed last, which dispatches of the layer's own disturb.
 * Null handles: nothing. */
struct compute_state {
    VkPipeline pipeline;
    VkShaderEXT shader;
    VkPipelineLayout layout; /* of the constants */
    uint32_t constants[CONSTANT_WORDS];
    VkShaderStageFlags stages[CONSTANT_WORDS]; /* that each was pushed for; 0: it was not */
    bool is_partial;                           /* more was set than can be restored */
    uint32_t queries;                          /* that are active, and count what dispatches do */
    struct condition condition;                /* on which dispatches depend */
};

/* Copy orders in one chunk, of which the first `used` are taken. */
struct copy_block {
    struct copy_orders orders;
    uint32_t used;
};

/* A word that the device reads before it executes what the layer recorded: while it is 0, nothing
 * of the recording's chunks is read or written. NULL: there is none yet. */
struct recording_gate {
    _Atomic uint32_t *is_open;
    uint64_t address; /* for the device */
};

/* Where a recording's memory goes in the end. */
struct recording_memory {
    void (*free_chunk)(void *user, struct snapshot_chunk *chunk);
    void (*free_gate)(void *user, const struct recording_gate *gate);
    void *user;
};

struct recording {
    atomic_uint references;
    struct compute_state compute;
    struct recorded_item *first, *last;
    struct snapshot_chunk **chunks; /* NULL: given back */
    uint32_t chunk_count, chunk_capacity;
    struct copy_block *copy_blocks; /* orders are taken of the last one */
    uint32_t copy_block_count, copy_block_capacity;
    bool executes_once; /* then nothing needs the chunks after its execution */
    struct recording_memory memory;
    struct recording_gate gate; /* closed once chunks were given back */
    uint32_t secondary_count;
    bool has_gatherings;
    /* Builds of which not all could be copied: how many, and the first ones. */
    uint32_t left_out_count;
    struct left_out_build {
        uint32_t position;
        enum left_out reason;
    } left_out[LEFT_OUT_NAMED];
    bool left_out_reported;
    atomic_bool
        is_invalidated;   /* an execution was not kept, so that the others can't be told apart */
    pthread_mutex_t lock; /* guards the rest, and what is added to items and chunks */
    struct execution *latest; /* the last one made, while it lives */
    uint32_t execution_count; /* that live */
    bool keeps_chunks; /* until it is released: an execution was cut short, commands that no gate
                          stops name chunks, or more was recorded after a submission */
    bool is_spent;     /* chunks were given back after an execution */
};

/* One execution of a recording: where its snapshots are, and when they can be read. */
struct execution {
    atomic_uint references; /* the last one goes under the recording's lock */
    struct execution *next; /* of those whose turn has not come */
    struct recording *recording;
    const struct recorded_item *last; /* of the items that it has; NULL: none */
    uint32_t chunk_count;             /* that it has */
    bool is_repeated;                 /* the recording was spent before: it has no snapshots */
    struct ticket *ticket;
    uint64_t destroy_count;     /* resources_destroy_count when it was submitted */
    atomic_bool is_overwritten; /* another of the same submission copied to the same chunks */
    atomic_bool is_reached;     /* nothing that it waits for is still to be submitted */
    /* Guards what follows; read while trees are made of the snapshots, which may ask for others of
     * the same execution: readers are never kept waiting for a writer that waits (the kind that
     * pthread_rwlock_init makes). */
    pthread_rwlock_t lock;
    unsigned char **bases; /* of the chunks; */
    uint64_t *sizes;       /* used of each; in the same block */
    bool detached;         /* bases are of copies, for the recording executes again; */
    bool has_no_snapshots; /* there was no memory for copies, it wasn't complete by then, or the
                     device was lost */
    /* Of the secondaries' works, in the order of their items. */
    struct execution **children;
    uint32_t child_count;
};

/* NULL without memory. */
struct recording *recording_create(const struct recording_memory *memory);
struct recording *recording_share(struct recording *recording);
void recording_release(struct recording *recording);

/* Takes over what the item points to, also where it fails for lack of memory. */
bool recording_add(struct recording *recording, const struct recorded_item *item);
/* Notes that not all of a build is in snapshots. */
void recording_leave_out(struct recording *recording, uint32_t position, enum left_out reason);
/* Takes over the chunk. */
bool recording_add_chunk(struct recording *recording, struct snapshot_chunk *chunk);

/* Whether it is, or executes, the other: which may not execute it, then. */
bool recording_contains(const struct recording *recording, const struct recording *other);

/* False without memory. */
bool recording_add_copy_block(struct recording *recording, const struct copy_block *block);
/* Before more is recorded: if it was submitted by mistake before that, its chunks stay, so that
 * none is given back while a command is recorded. */
void recording_go_on(struct recording *recording);
/* From now on its chunks stay until it is released: commands name them that no gate stops. */
void recording_keep_chunks(struct recording *recording);
/* Before a submission: opens the gate, unless chunks were given back. Returns false then. */
bool recording_open_gate(struct recording *recording);
/* Whether an execution of another ticket than `next` may still be reading the chunks. */
bool recording_is_pending(struct recording *recording, const struct ticket *next);

/* NULL without memory. */
struct execution *execution_create(struct recording *recording, struct ticket *ticket);
struct execution *execution_share(struct execution *execution);
void execution_release(struct execution *execution);

/* The item after this one, or the first after NULL; NULL behind the last that the execution has. */
static inline const struct recorded_item *execution_next(const struct execution *execution,
                                                         const struct recorded_item *item)
{
    if (!item)
        return execution->last ? execution->recording->first : NULL;
    return item == execution->last ? NULL : item->next;
}

/* From now on it has no snapshots. */
void execution_drop_snapshots(struct execution *execution);

/* How many of it and its secondaries have no snapshots because the recording was spent before. */
uint32_t execution_count_repeated(const struct execution *execution);

/* Its turn has come, and that of the secondaries'. */
void execution_mark_reached(struct execution *execution);

/* Before the recording is submitted again: copies the snapshots of the last execution, if anything
 * still needs them; likewise for secondaries. For its end it waits `nanoseconds` at most where its
 * turn has come, for the rest may wait for what the application does after this call. Returns how
 * many were lost. Of several executions in the submission that is to come, whose ticket is `next`,
 * the last one's snapshots serve all. */
uint32_t recording_detach(struct recording *recording, const struct ticket *next,
                          uint64_t nanoseconds);

#endif
