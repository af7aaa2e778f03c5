/* SPDX-License-Identifier: Apache-2.0 */
/* The clocks that the signals of one semaphore carry, sorted by value. Guarded by the lock of the
 * struct execution_order that owns it.
 *
 * A binary semaphore is treated as a timeline semaphore: the values of its signals are their
 * numbers, and a wait waits for the last one. If no signal is outstanding, what the wait follows is
 * unknown.
 *
 * A signal is announced before the call that submits it goes down. It gets its clock when all work
 * before it is resolved. It is published when the call has succeeded; before that, only its own
 * submission uses the clock. A signal is dropped when the host has observed it, because every later
 * submission follows it anyway. The oldest signals are also dropped if there are too many: what a
 * wait for such an old value follows is unknown. */
#ifndef ASSAY_STATE_ORDER_RECORDS_H
#define ASSAY_STATE_ORDER_RECORDS_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/drain.h"
#include "src/base/handle_table.h"
#include "src/base/unknown.h"
#include "src/platform/threads.h"
#include "src/state/order/clock.h"
#include "src/state/order/order.h"

enum { SEMAPHORE_SIGNALS = 64 }; /* kept signals; unpublished ones may exceed this limit */

struct semaphore_signal {
    uint64_t value, number; /* see struct semaphore_operation */
    const void *owner;      /* the submission that announced it; NULL: published */
    bool has_clock;
    struct execution_clock clock;
    struct execution_clock behind; /* as in struct order_batch */
    struct timestamp timestamp;    /* of its batch */
};

struct semaphore_clock {
    uint64_t id; /* unique within the device, though the handle may be reused */
    bool timeline;
    bool foreign;     /* operations that the layer does not intercept may signal it */
    uint64_t initial; /* timeline: its value from the start */
    uint64_t reached; /* signals of this value or less were dropped, if there were any; */
    uint64_t met;     /* of this value or less, because the host had observed them */

    uint64_t seen; /* the host has observed this value or a larger one */

    uint64_t last_wait; /* binary semaphore: the last signal that was waited for */

    struct semaphore_signal *signals; /* sorted by value */
    uint32_t count, capacity;
};

enum semaphore_wait_status {
    SEMAPHORE_MET,     /* the wait orders nothing: see struct semaphore_operation */
    SEMAPHORE_REACHED, /* the wait follows the signal; NULL: it is unknown */
    SEMAPHORE_NOT_YET, /* the signal that ends the wait is not announced or not published */
    SEMAPHORE_OPEN,    /* an untracked signal may end the wait: work before it is unknown */
};

/* Returns the status of a wait for `value` by the submission `owner`, whose own unpublished signals
 * count. `signal` is the one with which the wait ends, or NULL; it lives until the signals change.
 */
enum semaphore_wait_status semaphore_clock_wait(const struct semaphore_clock *semaphore,
                                                uint64_t value, const void *owner,
                                                const struct semaphore_signal **signal);

/* Returns false if memory runs out. */
bool semaphore_clock_announce(struct semaphore_clock *semaphore, uint64_t value, uint64_t number,
                              const void *owner);
/* Gives a signal its clocks. Returns the number of the one before, see struct semaphore_operation.
 */
uint64_t semaphore_clock_set(struct semaphore_clock *semaphore, uint64_t value, const void *owner,
                             const struct execution_clock *clock,
                             const struct execution_clock *behind, struct timestamp timestamp);
void semaphore_clock_publish(struct semaphore_clock *semaphore, uint64_t value, const void *owner);
void semaphore_clock_retract(struct semaphore_clock *semaphore, uint64_t value, const void *owner);

/* The largest value that was announced, and not retracted. */
static inline uint64_t semaphore_clock_last(const struct semaphore_clock *semaphore)
{
    return semaphore->count ? semaphore->signals[semaphore->count - 1].value : semaphore->reached;
}

/* The host has observed that the semaphore's value is `value` (`exact`), or at least `value`. Call
 * semaphore_clock_catch_up next. If no announced signal explains the value, the semaphore becomes
 * foreign. */
void semaphore_clock_observe(struct semaphore_clock *semaphore, uint64_t value, bool exact);

/* Joins `host` with the clocks of the published signals that the host has observed, and `maybe`
 * with what these are behind. Returns false if one of the observed signals is not published. */
bool semaphore_clock_catch_up(struct semaphore_clock *semaphore, struct execution_clock *host,
                              struct execution_clock *maybe);

/* Drops leading signals if the host has observed their values or their batches. `host` covers what
 * the host has observed. */
void semaphore_clock_prune(struct semaphore_clock *semaphore, const struct execution_clock *host);

void semaphore_clock_release(struct semaphore_clock *semaphore);

/* ---- The records behind order.h, private to src/state/order. The lock of struct execution_order
 * guards them, except for a submission that is being collected: that belongs to its thread. */

enum { EXECUTION_HELD_BATCHES = 4096 }; /* with more held batches the order becomes unknown */

/* Clocks of a queue after its resolved batches; the next batch continues from them. */
struct queue_clocks {
    uint64_t count;                   /* batches of commands so far */
    uint64_t bindings;                /* batches of sparse bindings so far, counted separately */
    struct execution_clock builds;    /* covers what the next batch's builds follow */
    struct execution_clock all;       /* covers what a signal of scope SCOPE_ALL carries */
    struct execution_clock signalled; /* covers what the signals so far carry */
    struct execution_clock behind;    /* as in struct order_batch, of the last batch */
    /* The first and the last open batch since the host last observed the completion of all open
     * batches; 0: none. A batch is open if an untracked operation may end one of its waits. */
    uint64_t first_open, last_open;
};

struct order_queue {
    VkQueue handle;
    uint32_t index;
    uint32_t bindings_index;      /* index of its sparse bindings in clocks; 0: none yet */
    struct submission *under_way; /* the call that submits to the queue now; NULL: none */
    struct queue_clocks clocks;
    struct order_batch *held, **held_end;
    uint32_t held_bindings; /* held batches that are sparse bindings */
    uint64_t idle_serial;   /* the host has observed that calls up to this serial are complete */
};

struct order_fence {
    bool foreign;     /* others may signal it, too */
    bool is_imported; /* it may have another payload, whose signal shows anything */
    bool seen;        /* the host has observed the signaled fence; its clock may be set later */
    uint64_t serial;  /* of the submission that will signal the fence; 0: none is tracked */
    bool has_clock;
    struct execution_clock clock;
    struct execution_clock behind; /* as in struct order_batch */
};

struct submission {
    struct execution_order *order;
    struct submission *next; /* in the order's spare list */
    enum submission_kind kind;
    bool is_under_way; /* the call is prepared, and has not returned */
    VkFence fence;
    struct submission_origin origin;
    uint64_t destroy_count;
    struct order_queue *queue_record; /* NULL: the host */
    uint64_t serial;                  /* number among the calls that succeeded */
    /* One of the caller until it finishes, one per held or runnable batch, one per use of a batch.
     */
    atomic_uint references;
    bool out_of_memory;
    bool skip;
    bool signals_foreign_object; /* see struct order_batch */
    bool may_follow_held;        /* see start() in queues.c */
    uint32_t ready_count;        /* leading batches that were not held when prepared */
    struct execution_clock host; /* the order's host clock when prepared */
    uint64_t timed_out_waits;    /* as the order had then */
    struct queue_clocks clocks;  /* of the queue, after the ready batches */

    struct order_batch *batches;
    uint32_t batch_count, batch_capacity;
    struct semaphore_operation *operations; /* of all batches, in the order of the batches */
    uint32_t operation_count, operation_capacity;
    struct submitted_commands *commands;
    uint32_t command_count, command_capacity;
};

enum { ORDER_TIMEOUTS = 16 };

struct execution_order {
    struct execution_hooks hooks;     /* constant */
    struct batch_consumer *consumers; /* constant once the device is published */
    uint32_t consumer_count, consumer_capacity;
    struct batch_list batches; /* has its own lock */
    pthread_mutex_t lock;
    struct handle_table semaphores, fences;
    struct order_queue queues[EXECUTION_QUEUES]; /* [EXECUTION_HOST] stands for the host */
    uint32_t queue_count;
    struct execution_clock host;       /* covers all work whose completion the host has observed */
    struct execution_clock maybe;      /* and all work whose completion it may have observed */
    uint64_t untracked;                /* see execution_order_find_observed() */
    uint64_t timed_out_waits;          /* number of waits of the host that returned VK_TIMEOUT */
    uint64_t timeouts[ORDER_TIMEOUTS]; /* in ns, of the last ones: a ring */
    uint64_t host_count;               /* host work that has ended */
    uint64_t last_serial, last_semaphore, last_signal;
    uint32_t in_flight;  /* calls under way that may release held batches */
    uint32_t waiting;    /* calls under way with batches that will be held */
    uint32_t held_count; /* held batches */
    struct order_batch *run_list, **run_end;
    struct drain drain;          /* of the run list: one thread is in the consumers' functions */
    pthread_t runner;            /* that thread */
    struct order_batch *running; /* the batch that it runs; NULL: none */
    pthread_cond_t ran;          /* a batch has run */
    struct unknown unknown;
    bool unknown_reported;
    enum order_unknown_reason unknown_reason; /* if unknown */
    bool has_open;                            /* a queue has had an open batch */
    struct submission *spare;
};

/* Hold the lock for all functions below. Functions of batches.c may release and reacquire it. */

/* Both return NULL if the handle is unknown. */
struct semaphore_clock *execution_order_semaphore(const struct execution_order *order,
                                                  VkSemaphore handle);
struct order_fence *execution_order_fence(const struct execution_order *order, VkFence handle);

/* resolve.c: timestamps and clocks from semaphores. */

/* Gives the submission's semaphore operations their values and announces its signals. */
void submission_announce(struct submission *submission);
bool order_batch_is_last(const struct order_batch *batch);
/* Finds the signals of the batch's waits, and joins their clocks to `all`, and to `builds` if the
 * waits' scope includes builds. Returns whether one of the waits is open. */
bool order_batch_follow_waits(const struct order_batch *batch, struct execution_clock *builds,
                              struct execution_clock *all, struct execution_clock *behind);
void order_batch_set_signal(struct order_batch *batch, struct semaphore_operation *operation,
                            const struct execution_clock *carried,
                            const struct execution_clock *behind);
/* Resolves batches, from the first, up to the first one that is held. */
void submission_resolve_ready(struct submission *submission);
/* The call has succeeded: publishes its signals, and holds its batches that are not ready. */
void submission_publish(struct submission *submission);
/* The call has failed: undoes submission_announce. */
void submission_retract(struct submission *submission);
/* Resolves held batches until all that remain must be held. */
void execution_order_release_held(struct execution_order *order);

/* batches.c */
void execution_order_append_run(struct execution_order *order, struct order_batch *batch);
void execution_order_set_unknown_locked(struct execution_order *order,
                                        enum order_unknown_reason why);
void execution_order_drain(struct execution_order *order);
/* Calls `submit` for all batches. */
void submission_submit(struct submission *submission);
/* Calls `check` for the ready batches if they are first in the run list and no thread runs batches.
 */
void submission_check(struct submission *submission);
/* Removes the prepared batches from the run list. Calls `undo` first if they were checked. */
void submission_withdraw(struct submission *submission);
/* Calls `fail` for all batches. */
void submission_report_failure(struct submission *submission);
void submission_reference(struct submission *submission);
/* Retires the batches of the submission, without the lock, if it was the last reference. */
void submission_unreference(struct submission *submission);
/* These two take the lock of the list. */
void batch_list_append_submission(struct batch_list *list, struct submission *submission);

/* submission.c. Returns NULL if memory runs out; the order is unknown then. */
struct submission *submission_create(struct execution_order *order, enum submission_kind kind,
                                     VkQueue queue);
void submission_free(struct submission *submission);
/* Sets the members of the batches that are constant from now on. */
void submission_describe(struct submission *submission);
void order_batch_resolve_bindings(struct order_batch *batch, struct queue_clocks *clocks);
/* Joins all work that has executed when the queue is idle. */
void execution_order_join_all(struct execution_clock *clock, const struct order_queue *queue);
/* The host has observed that all batches of the queue which have clocks are complete, or that the
 * fence is signaled. */
void execution_order_join_idle(struct execution_order *order, const struct order_queue *queue);
void execution_order_join_fence(struct execution_order *order, const struct order_fence *fence);

/* queues.c: the batch of the host ends, so all work that begins from now on follows it: the host's
 * own, and submissions, because the host makes them. */
void order_batch_end_on_host(struct order_batch *batch);
/* host.c: with hooks.follows_host, submits a wait of the host that has ended. Null: it may have
 * been for anything. */
void execution_order_add_host_wait(struct execution_order *order, VkSemaphore handle,
                                   uint64_t value);

/* Returns NULL if the batch has none. */
static inline struct semaphore_operation *order_batch_operations(const struct order_batch *batch)
{
    return batch->operation_count ? &batch->submission->operations[batch->first_operation] : NULL;
}

/* Calls a function of each consumer that has it, with `user` and the argument. */
#define CALL_CONSUMERS(order, function, argument)                                                  \
    for (uint32_t c = 0; c < (order)->consumer_count; c++)                                         \
        if ((order)->consumers[c].function) {                                                      \
            (order)->consumers[c].function((order)->consumers[c].user, argument);                  \
        }

static inline void submission_set_states(struct submission *submission,
                                         enum order_batch_state state)
{
    for (uint32_t i = 0; i < submission->batch_count; i++)
        atomic_store_explicit(&submission->batches[i].state, state, memory_order_release);
}

#endif
