/* SPDX-License-Identifier: Apache-2.0 */
/* A batch, from the call that submits it until its last user lets go. The execution order makes it,
 * and all consumers (order.h) read from it what was submitted, and hang on it what they know of it.
 *
 * | state           | since                                       | what may change
 * | BATCH_COLLECTED | it was added to its submission              | all; the submitting thread's
 * | BATCH_PREPARED  | its call is about to go down                | the second group
 * | BATCH_HELD      | its call has succeeded; a signal is missing | the second group
 * | BATCH_SUBMITTED | its call has succeeded                      | the second group
 * | BATCH_ORDERED   | all batches that precede it have run        | nothing
 * | BATCH_FAILED    | its call has failed or was skipped          | nothing
 *
 * It is complete once a clock of the host has its timestamp, judged once its slot says so, and
 * retired once its last user has let go: its memory then serves other batches.
 *
 * Whoever has a reference may read the first group on any thread from BATCH_PREPARED on, and the
 * second group, with what the order has found for semaphore operations, from BATCH_ORDERED on.
 * Before that, the second group belongs to the order, which shows it to the consumer's functions.
 *
 * The batches of a submission share one reference count, and so retire together. */
#ifndef ASSAY_STATE_ORDER_BATCH_H
#define ASSAY_STATE_ORDER_BATCH_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/platform/threads.h"
#include "src/state/commands/label_stack.h"
#include "src/state/order/clock.h"

struct execution;
struct submission;

/* Why a consumer keeps a batch, and its slot. */
enum batch_use {
    USES_PENDING_BUILDS, /* layer/execution/submitted_builds.c */
    USES_EXECUTIONS,     /* layer/snapshots/executions.c */
    USES_INPUTS,         /* layer/execution/input_checks.c */
    USES_HAZARDS,        /* layer/hazards/executed/checks.c */
    USES_HOST_WRITES,    /* layer/hazards/executed/host_writes.c */
    BATCH_USES,
};

struct submitted_commands {
    VkCommandBuffer handle; /* VK_NULL_HANDLE: other work */
    void *captured;
    /* The execution of its recording, from its submission until the batch has run, for
     * USES_EXECUTIONS. Whoever takes it out owns it. NULL: none. */
    struct execution *_Atomic execution;
    bool is_used[BATCH_USES]; /* whether a use of the batch concerns it; guarded by the lock of the
                                 list once the batch is kept */
};

/* The phase of host work that a batch stands for. */
enum work_phase {
    WORK_OF_QUEUE, /* the batch is work of a queue */
    WORK_BEGINS,
    WORK_ENDS,
    WORK_FAILS, /* the work ends, and its effects are unknown */
    WORK_SYNC,  /* no work: semaphore operations of the host (execution_hooks.follows_host) */
};

/* The work that a semaphore operation orders, besides other semaphore operations. */
enum semaphore_scope {
    SCOPE_NOTHING, /* no work on acceleration structures */
    SCOPE_BUILDS,  /* work on acceleration structures */
    SCOPE_ALL,     /* all commands */
};

struct semaphore_operation {
    VkSemaphore handle;
    uint64_t id;        /* of the semaphore, never reused; 0: not tracked */
    uint64_t value;     /* binary semaphore: see `signal`; 0: no signal is outstanding */
    uint64_t last_wait; /* binary semaphore: its last_wait before this wait */
    enum semaphore_scope scope;
    bool is_signal;
    VkPipelineStageFlags2 stages; /* see submission_set_stages() */

    /* The second group. Signals have numbers, unique within the device; 0: unknown. */
    bool is_met;     /* a wait for what the host had observed at the submission, or for a value that
                        the timeline had from the start: it orders nothing */
    uint64_t signal; /* the signal; or the one with which the wait ends */
    uint64_t previous; /* of a signal: the semaphore's signal with the next smaller value; 0: none
                          that the host had not observed at the submission */
};

enum order_batch_state {
    BATCH_COLLECTED,
    BATCH_PREPARED,
    BATCH_HELD,
    BATCH_SUBMITTED,
    BATCH_ORDERED,
    BATCH_FAILED,
};

/* The lists of all batches that are not retired. */
enum batch_sequence { IN_SUBMISSION_ORDER, IN_EXECUTION_ORDER, BATCH_SEQUENCES };

struct order_batch {
    /* The first group. */
    struct submission_origin origin;
    uint64_t destroy_count; /* see submission_set_origin(): objects may have been destroyed since
                               the submission */
    const struct execution_clock *host; /* all work that the host had observed to be complete */
    uint64_t timed_out_waits; /* number of waits of the host that had returned VK_TIMEOUT */
    struct submitted_commands *commands;
    uint32_t command_count;
    struct semaphore_operation *operations; /* its waits and signals; NULL: none */
    uint32_t operation_count;
    bool signals_fence; /* it is the last batch of a submission with a fence */
    /* With follows_host: the submission signals an object that others may signal or wait for, so
     * the application may observe its completion without the layer. */
    bool signals_foreign_object;
    bool is_checked; /* the consumers have checked it */
    bool skips_call; /* set by `submit` or `check`: the call is to be skipped */

    /* The second group. */
    enum work_phase work;
    struct timestamp timestamp;   /* host work: set at WORK_ENDS and WORK_FAILS only */
    struct execution_clock clock; /* all work that certainly executes before the batch */
    /* Work of queues: the batch, and all work of which the host may know that it is complete if it
     * knows that of a command of the batch. Barriers continue the scopes of semaphores, so this is
     * more than what `clock` and the signals of the batch certainly have. */
    struct execution_clock behind;
    /* False: batches that have not been submitted yet may execute before this one, so nothing about
     * it may be reported. Its effects still count. */
    bool predecessors_known;
    bool is_replayed; /* its effects on structures are known (layer/execution/submissions.c) */

    _Atomic(enum order_batch_state) state;
    /* The number of the last object (src/state/resources/destroyed.h) that was destroyed while the
     * batch was certainly not complete; 0: none. */
    _Atomic uint64_t last_destroyed;
    /* What each consumer knows of the batch. The consumer says what guards its slot. */
    void *slots[BATCH_USES];

    /* Guarded by the lock of the list. */
    unsigned uses;      /* 1 << enum batch_use */
    unsigned sequences; /* 1 << enum batch_sequence */
    struct order_batch *following[BATCH_SEQUENCES], *preceding[BATCH_SEQUENCES];

    /* Private to src/state/order/. */
    struct submission *submission;
    struct order_batch *next; /* in the queue's held list, or in the run list */
    uint32_t first_operation, first_commands;
    bool is_open; /* the is_open hook returned true for one of its command buffers */
};

/* The lock guards the list and the members of batches that say so. While it is held, no batch
 * retires. It comes after the lock of the order, and no lock of src/state/order/ is taken under it.
 * A signal handler may try to take it. */
struct batch_list {
    pthread_mutex_t lock;
    struct order_batch *first[BATCH_SEQUENCES], *last[BATCH_SEQUENCES];
};

static inline bool order_batch_is_kept(const struct order_batch *batch, enum batch_use use)
{
    return batch->uses & 1u << use;
}

/* Returns the next batch behind `after`, or the first one if that is NULL, that is kept for the
 * use. Call with the lock of the list. */
struct order_batch *batch_list_next(const struct batch_list *list, enum batch_sequence sequence,
                                    const struct order_batch *after, enum batch_use use);

/* A walk over the command buffers that a use concerns, of the batches that are kept for it. */
struct batch_cursor {
    struct batch_list *list;
    enum batch_sequence sequence;
    enum batch_use use;
    struct order_batch *batch; /* NULL: none yet */
    uint32_t command;
};
/* Goes on to the next command buffer. Returns false at the end. Call with the lock of the list. */
bool batch_cursor_next(struct batch_cursor *at);
/* Does the same, but takes the lock, and has a reference to `batch` until the end. */
bool batch_cursor_step(struct batch_cursor *at);

/* Each use has one reference. order_batch_keep() is called by a consumer's function, the others on
 * any thread. The function that releases the last reference calls `retire` of each consumer, and
 * the hook `release`: call it without a lock. `slot` may be NULL. */
void order_batch_keep(struct order_batch *batch, enum batch_use use, void *slot);
/* Ends the use, and releases its reference. Does nothing if the batch is not kept for the use. */
void order_batch_let_go(struct order_batch *batch, enum batch_use use);
/* Ends the use. Returns false if the batch was not kept for the use; else the caller releases its
 * reference. */
bool order_batch_end_use(struct order_batch *batch, enum batch_use use);
/* Ends the use of the first batch for which `ends`, called with the lock, returns true; NULL: of
 * the first batch. The caller releases the reference. Returns NULL if there is none. */
struct order_batch *batch_list_take(struct batch_list *list, enum batch_sequence sequence,
                                    enum batch_use use,
                                    bool (*ends)(const void *user, const struct order_batch *batch),
                                    const void *user);
void order_batch_release(struct order_batch *batch); /* accepts NULL */

/* Whether its execution point is reached. */
static inline bool order_batch_has_run(const struct order_batch *batch)
{
    return atomic_load(&batch->state) == BATCH_ORDERED;
}

#endif
