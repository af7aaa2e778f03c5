/* SPDX-License-Identifier: Apache-2.0 */
/* What belongs to the journal of a command buffer (src/state/commands/journal.h) if inputs of its
 * builds are copied, for level content and backend cpu: memory, copies and executions.
 *
 * When the commands execute, the device only copies the inputs of builds into chunks of memory.
 * Each submission makes an execution of the journal. At the execution's point in execution order
 * (src/state/order/order.h) the journal's entries determine the contents of structures. Only the
 * command buffer, whose use the application synchronizes, adds to a recording. An execution shares
 * the journal, and so the recording.
 *
 * An application may by mistake record further after a submission, so an execution has an end and
 * counts of its own and ignores what was recorded later. It may also by mistake resubmit a command
 * buffer that it began with ONE_TIME_SUBMIT. The chunks of such a recording are given back with its
 * last execution; executions made after that have no snapshots. */
#ifndef ASSAY_SNAPSHOTS_RECORDING_H
#define ASSAY_SNAPSHOTS_RECORDING_H

#include <stdatomic.h>
#include <stdbool.h>

#include "src/platform/threads.h"
#include "src/snapshots/memory.h"
#include "src/snapshots/recorded_build.h"
#include "src/snapshots/ticket.h"
#include "src/state/commands/journal.h"

/* Memory to which the device copies. The allocator makes it part of a larger structure. */
struct snapshot_chunk {
    unsigned char *bytes; /* mapped, coherent */
    uint64_t size, used;
};

/* A command that only backend cpu executes: an entry of the journal. */
struct recorded_command {
    unsigned char kind;       /* enum journal_kind */
    unsigned char size;       /* as in struct journal_entry */
    VkQueryResultFlags flags; /* of CPU_COPY_QUERIES */
    uint32_t first, count;    /* first query, and number of queries */
    uint64_t pool;            /* of queries */
    uint64_t structure;       /* that is written, or serialized, or queried */
    union {
        struct { /* of CPU_COPY */
            uint64_t src;
            bool compacts;
        };
        VkDeviceAddress address;    /* of CPU_SERIALIZE: where the result is written, in the buffer
                                     * that    has the address by then */
        struct snapshot serialized; /* of CPU_DESERIALIZE */
        struct {
            VkDeviceSize stride; /* of CPU_COPY_QUERIES */
            struct buffer_target target;
        };
    };
};
_Static_assert(sizeof(struct recorded_command) <= JOURNAL_ENTRY_MAX, "it is an entry");

enum { CONSTANT_WORDS = 64, CONSTANT_LAYOUTS = 8, LEFT_OUT_NAMED = 8 };

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

/* The application's current bindings and push constants, which dispatches of the layer's own
 * disturb. A null handle means that nothing is bound. */
struct compute_state {
    VkPipeline pipeline;
    VkShaderEXT shader;
    uint32_t constants[CONSTANT_WORDS];
    VkShaderStageFlags stages[CONSTANT_WORDS]; /* of each word; 0: it was not pushed */
    VkPipelineLayout layouts[CONSTANT_WORDS];  /* that each word was pushed with */
    /* These layouts, in the order of the last push with each: a push leaves the words that a
     * compatible layout pushed, and makes all others undefined. */
    VkPipelineLayout pushed[CONSTANT_LAYOUTS];
    uint32_t pushed_count;
    bool is_partial;            /* some state that was set cannot be restored */
    uint32_t queries;           /* number of active queries that count dispatches */
    struct condition condition; /* conditional rendering, which applies to dispatches */
};

/* Copy orders in one chunk. The first `used` are taken. */
struct copy_block {
    struct copy_orders orders;
    uint32_t used;
};

/* Words in memory that is mapped and coherent, and timestamp queries whose results they can hold.
 * The host can read the words even after the device was lost. `words` is NULL until they are
 * needed. */
enum { MAPPED_WORDS = 4, MAPPED_QUERIES = 2 };
struct mapped_words {
    _Atomic uint32_t *words;
    VkBuffer buffer;
    uint64_t offset;  /* in the buffer */
    uint64_t address; /* for the device; 0 without bufferDeviceAddress */
    VkQueryPool queries;
    uint32_t first_query;
};

/* The words that the device writes around the builds of one call. */
struct build_mark {
    struct mapped_words words; /* MARK_REACHED and MARK_FINISHED: 0: not yet */
};
enum { MARK_REACHED = 1, MARK_FINISHED = 3 }; /* a timestamp lies in front of each */

/* The marks of a recording, in the order of the calls. */
struct build_marks {
    struct build_mark *items;
    uint32_t count, capacity;
    bool is_open; /* the builds behind the last mark are being recorded */
    /* The number of the ticket whose submission the marks are about. 0: none, or several. */
    _Atomic uint64_t ticket;
};

/* Pools of queries of the layer's own, each with SIZE_QUERIES queries of compacted sizes. */
enum { SIZE_QUERIES = 64 };
struct size_pools {
    VkQueryPool *items;
    uint32_t count, capacity;
    uint32_t used; /* queries of all pools */
};

/* Frees a recording's memory. */
struct recording_memory {
    void (*free_chunk)(void *user, struct snapshot_chunk *chunk);
    void (*free_guarded)(void *user, struct snapshot_chunk *guarded);
    void (*free_words)(void *user, const struct mapped_words *words);
    void (*free_queries)(void *user, VkQueryPool pool);
    void *user;
};

struct recording {
    struct journal *journal; /* whose `work` it is */
    bool has_commands;       /* something is to be done when it executes */
    struct compute_state compute;
    struct recorded_build *builds;  /* all copies of the journal's builds, without order */
    struct snapshot_chunk **chunks; /* a chunk that was given back is NULL */
    uint32_t chunk_count, chunk_capacity;
    struct copy_block *copy_blocks; /* new orders come from the last one */
    uint32_t copy_block_count, copy_block_capacity;
    /* Something was reported about a command of the command buffer, or when it executed. */
    atomic_bool has_findings;
    bool executes_once; /* ONE_TIME_SUBMIT: the chunks are free after the execution */
    struct recording_memory memory;
    /* The device reads the first word before it executes what the layer recorded. While that word
     * is 0, the gate is closed: the chunks are neither read nor written. */
    struct mapped_words gate; /* closed when chunks are given back */
    /* Memory of the device that guarded builds read, as a list that the allocator links. It stays
     * until the recording is released, because its builds read it whenever they execute. */
    struct snapshot_chunk *guarded;
    bool has_guards, executes_at_once; /* SIMULTANEOUS_USE */
    struct build_marks marks;
    struct size_pools size_pools;
    bool has_gatherings;
    /* Builds whose inputs were not all copied: their number, and the first ones. */
    uint32_t left_out_count;
    struct left_out_build {
        uint32_t position;
        enum left_out reason;
    } left_out[LEFT_OUT_NAMED];
    bool left_out_reported;
    /* Memory ran out, and the device executes the commands without an execution. So nothing says
     * which execution wrote the snapshots, or when the device has completed it. */
    atomic_bool is_invalidated;
    pthread_mutex_t lock;     /* guards the members below, and additions to chunks */
    struct execution *latest; /* the executions that exist: the one made last, then the others */
    uint32_t execution_count; /* their number */
    /* Chunks stay until the recording is released: an execution did not complete, commands without
     * a gate name the chunks, or more was recorded after a submission. */
    bool keeps_chunks;
    bool is_spent; /* chunks were given back after an execution */
};

/* One execution of a recording: where its snapshots are, and when they can be read. */
struct execution {
    atomic_uint references; /* the last reference is dropped under the recording's lock */
    /* The executions of the recording that were made before and after this one; guarded by the
     * recording's lock. */
    struct execution *older, *newer;
    struct recording *recording; /* its journal is shared */
    struct chunk_place end;      /* of the journal's entries */
    uint32_t chunk_count;        /* chunks of this execution */
    bool is_repeated;            /* the chunks were given back before: there are no snapshots */
    struct ticket *ticket;
    uint64_t destroy_count;     /* resources_destroy_count() at the submission */
    uint64_t submissions;       /* destroyed_objects_submissions() at the submission */
    atomic_uint judged_end;     /* builds before this position were validated before completion */
    atomic_bool is_overwritten; /* by another execution of the same submission */
    atomic_bool is_reached;     /* all work on which it depends has been submitted */
    /* Guards the members below. Held for reading while BVHs are built from the snapshots, which may
     * take it for reading again for the same execution. */
    struct shared_lock lock;
    unsigned char **bases; /* start of each chunk, or of its copy */
    uint64_t *sizes;       /* used bytes of each chunk; in the block of `bases` */
    bool detached;         /* `bases` are copies, because the recording executes again */
    bool has_no_snapshots; /* out of memory for copies, not complete when resubmitted, or the device
                              was lost */
    /* Executions of secondaries, in the order of their entries; NULL: it has no commands. */
    struct execution **children;
    uint32_t child_count;
};

/* Creates the recording of a journal, which owns it. Returns NULL without memory. */
struct recording *recording_create(struct journal *journal, const struct recording_memory *memory);

/* The recording of a journal that has commands; NULL: the journal has none. */
static inline struct recording *recording_with_commands(const struct journal *journal)
{
    struct recording *recording = journal->work;
    return recording && recording->has_commands ? recording : NULL;
}

/* Adds the copies of a build, and takes ownership. */
void recording_add_build(struct recording *recording, struct recorded_build *build);
/* Notes that the snapshots lack inputs of a build. */
void recording_leave_out(struct recording *recording, uint32_t position, enum left_out reason);
/* Adds a chunk. Takes ownership of the chunk, also if it fails. Returns false without memory. */
bool recording_add_chunk(struct recording *recording, struct snapshot_chunk *chunk);

/* Adds a block of copy orders. Returns false without memory. */
bool recording_add_copy_block(struct recording *recording, const struct copy_block *block);
/* Called before more is recorded. If the recording has executions, because it was submitted too
 * early, its chunks stay, so that no chunk is given back while a command is recorded. */
void recording_continue(struct recording *recording);
/* From now on the chunks stay until the recording is released, because commands without a gate name
 * them. */
void recording_keep_chunks(struct recording *recording);
/* Called before a submission: opens the gate. Returns false and leaves the gate closed if the
 * chunks were given back. */
bool recording_open_gate(struct recording *recording);
/* From now on all its executions, and those of its secondaries, have no snapshots. */
void recording_invalidate(struct recording *recording);
/* Whether the device may still execute the recording, apart from submission `next`. An execution
 * counts from its creation on. If two threads may submit the recording, a lock of the caller must
 * be held from this call until execution_create() has returned. */
bool recording_is_pending(struct recording *recording, const struct ticket *next);

/* The execution made last, with a reference for the caller. Returns NULL if none exists. */
struct execution *recording_share_latest(struct recording *recording);

/* Creates an execution of the current entries, with executions of secondaries. Returns NULL without
 * memory. */
struct execution *execution_create(struct recording *recording, struct ticket *ticket);
struct execution *execution_share(struct execution *execution);
void execution_release(struct execution *execution);

/* Walks the execution's entries. */
static inline void execution_walk(const struct execution *execution,
                                  const struct journal_events *events, void *user)
{
    struct journal_walk walk = journal_start(execution->recording->journal, events, user);
    walk.end = execution->end;
    journal_go_on(&walk);
}

/* The functions below accept NULL. */

/* Drops the snapshots of the execution, and of those of its secondaries, whose recording is
 * invalidated. */
void execution_drop_invalidated(struct execution *execution);

/* Drops the snapshots of the execution, and of those of its secondaries, if another queue may
 * overwrite them: the device may still execute the recording there. Returns the number of
 * executions whose snapshots were dropped. */
uint32_t execution_drop_contested(struct execution *execution);

/* Counts the execution and those of its secondaries that have no snapshots because the chunks were
 * given back before. */
uint32_t execution_count_repeated(const struct execution *execution);

/* The execution and those of its secondaries have been reached in execution order. */
void execution_mark_reached(struct execution *execution);

/* Called before the recording is resubmitted: copies the snapshots of its latest execution, apart
 * from those of submission `next`, if there is one; likewise for secondaries. Waits up to
 * `nanoseconds` for that execution if it has been reached in execution order, and not at all
 * otherwise, because it may depend on later calls of the application. Returns the number of
 * executions whose snapshots were dropped. Executions of the coming submission are not copied: the
 * snapshots of the last one serve all of them. */
uint32_t recording_detach(struct recording *recording, const struct ticket *next,
                          uint64_t nanoseconds);

#endif
