/* SPDX-License-Identifier: Apache-2.0 */
/* What the commands of a command buffer do to acceleration structures on backend cpu, in recorded
 * order.
 *
 * Nothing of it is done when the commands execute: the device only copies what builds read into
 * chunks of memory. Each submission makes an execution of the recording, and when its turn has come
 * (backend.h) the items tell what structures hold from then on. Only its command buffer, whose use
 * the application synchronizes, adds to a recording. */
#ifndef ASSAY_CPU_RECORDING_H
#define ASSAY_CPU_RECORDING_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "cpu/recorded_build.h"
#include "cpu/ticket.h"

/* Memory that the device copies to. Part of a larger structure of who allocates it. */
struct cpu_chunk {
    unsigned char *bytes; /* mapped, coherent */
    uint64_t size, used;
};

enum cpu_item_kind {
    CPU_ITEM_BUILD,
    CPU_ITEM_UPDATE,
    CPU_ITEM_CLONE,
    CPU_ITEM_COMPACT,
    CPU_ITEM_SERIALIZE,
    CPU_ITEM_DESERIALIZE,
    CPU_ITEM_WRITE_QUERIES,
    CPU_ITEM_RESET_QUERIES,
    CPU_ITEM_COPY_QUERIES,
    CPU_ITEM_EXECUTE, /* a secondary command buffer */
};

/* Where a result goes when the submission is complete. */
struct cpu_target {
    VkBuffer buffer;
    VkDeviceSize offset, size; /* bytes from the offset to the buffer's end */
};

struct cpu_item {
    struct cpu_item *next;
    enum cpu_item_kind kind;
    uint64_t dst, src;        /* structures */
    uint64_t pool;            /* of queries, */
    uint32_t first, count;    /* which */
    VkDeviceSize stride;      /* of copied queries */
    VkQueryResultFlags flags; /* likewise */
    uint64_t *structures;     /* whose properties are written: `count` */
    VkQueryType query_type;
    struct cpu_recorded_build *build; /* of builds and updates */
    struct cpu_snapshot serialized;   /* a structure's serialized form */
    struct cpu_target target;         /* of SERIALIZE and COPY_QUERIES */
    struct cpu_recording *secondary;
};

enum { CPU_CONSTANT_WORDS = 64 };

/* What the application has bound and pushed last, which dispatches of the backend's own disturb.
 * Null handles: nothing. */
struct cpu_compute_state {
    VkPipeline pipeline;
    VkShaderEXT shader;
    VkPipelineLayout layout; /* of the constants */
    uint32_t constants[CPU_CONSTANT_WORDS];
    VkShaderStageFlags stages[CPU_CONSTANT_WORDS]; /* that each was pushed for; 0: it was not */
};

struct cpu_recording {
    atomic_uint references;
    struct cpu_compute_state compute;
    struct cpu_item *first, **last;
    struct cpu_chunk **chunks;
    uint32_t chunk_count, chunk_capacity;
    void (*free_chunk)(void *user, struct cpu_chunk *chunk);
    void *user;
    uint32_t secondary_count;
    bool has_targets; /* it or a secondary has results to deliver */
    pthread_mutex_t lock;
    struct cpu_execution *latest; /* the last one made, while it lives; guarded by the lock */
};

/* One execution of a recording: where its snapshots are, and when they can be read. */
struct cpu_execution {
    atomic_uint references;     /* the last one goes under the recording's lock */
    struct cpu_execution *next; /* of those whose turn has not come (playback.h) */
    struct cpu_recording *recording;
    struct cpu_ticket *ticket;
    /* Guards what follows; read while trees are made of the snapshots, which may ask for others of
     * the same execution: readers are never kept waiting for a writer that waits (the kind that
     * pthread_rwlock_init makes). */
    pthread_rwlock_t lock;
    unsigned char **bases; /* of the chunks; */
    bool detached;         /* of copies of them, for the recording executes again; */
    bool is_lost;          /* there was no memory for copies, or the device was lost */
    /* Of the secondaries' works, in the order of their items. */
    struct cpu_execution **children;
    uint32_t child_count;
};

/* NULL without memory. */
struct cpu_recording *cpu_recording_create(void (*free_chunk)(void *user, struct cpu_chunk *chunk),
                                           void *user);
struct cpu_recording *cpu_recording_share(struct cpu_recording *recording);
void cpu_recording_release(struct cpu_recording *recording);

/* Takes over what the item points to, also where it fails for lack of memory. */
bool cpu_recording_add(struct cpu_recording *recording, const struct cpu_item *item);
/* Takes over the chunk. */
bool cpu_recording_add_chunk(struct cpu_recording *recording, struct cpu_chunk *chunk);

struct cpu_execution *cpu_execution_create(struct cpu_recording *recording,
                                           struct cpu_ticket *ticket);
struct cpu_execution *cpu_execution_share(struct cpu_execution *execution);
void cpu_execution_release(struct cpu_execution *execution);

/* Before the recording is submitted again: waits for the end of the last execution and copies its
 * snapshots, if anything still needs them; likewise for secondaries. Of several executions in the
 * submission that is to come, whose ticket is `next`, the last one's snapshots serve all. */
void cpu_recording_detach(struct cpu_recording *recording, const struct cpu_ticket *next);

#endif
