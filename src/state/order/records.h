/* SPDX-License-Identifier: Apache-2.0 */
/* The records behind execution_order.h; private to execution_*.c and submission.c. Guarded by the
 * lock of struct execution_order, save for a submission that is being collected. */
#ifndef ASSAY_STATE_ORDER_RECORDS_H
#define ASSAY_STATE_ORDER_RECORDS_H

#include <pthread.h>

#include "src/base/handle_table.h"
#include "src/state/order/order.h"
#include "src/state/order/semaphore_clock.h"

enum { EXECUTION_HELD_BATCHES = 4096 }; /* that may be held back before the order is lost */

struct semaphore_operation {
    VkSemaphore handle;
    uint64_t id;        /* of the semaphore_clock; 0: not known */
    uint64_t value;     /* or number, of a binary semaphore */
    uint64_t last_wait; /* of a binary semaphore, before this wait */
    enum semaphore_scope scope;
    bool is_signal;
};

struct order_batch {
    struct submission *submission;
    struct order_batch *next; /* held back on its queue, or in the run list */
    uint32_t first_operation, operation_count;
    uint32_t first_commands, command_count;
    struct timestamp timestamp;
    struct execution_clock clock;
    bool is_open; /* its commands are */
    bool predecessors_known;
};

/* What the next batch of a queue builds on. */
struct queue_clocks {
    uint64_t count;                   /* of batches so far */
    uint64_t bindings;                /* of those of sparse bindings, which have moments apart */
    struct execution_clock builds;    /* what its work on acceleration structures follows */
    struct execution_clock all;       /* what the last of its signals covers */
    struct execution_clock signalled; /* what the signals so far cover */
    /* The first and the last batch, since the host last saw all of them complete, that waited for
     * what the layer doesn't see; 0: none. */
    uint64_t first_open, last_open;
};

struct order_queue {
    VkQueue handle;
    uint32_t index;
    uint32_t bindings_index; /* of the moments of sparse bindings; 0: none yet */
    bool in_flight;          /* a call that submits to it is under way */
    struct queue_clocks clocks;
    struct order_batch *held, **held_end;
    uint32_t held_bindings; /* of those */
    uint64_t idle_serial;   /* the host has seen it idle after the calls up to this one */
};

struct order_fence {
    bool foreign;
    bool seen;       /* the host has seen it signalled before its clock was known */
    uint64_t serial; /* of the submission that will signal it; 0: none is known */
    bool has_clock;
    struct execution_clock clock;
};

enum submission_state {
    SUBMISSION_COLLECTING,
    SUBMISSION_PREPARED, /* the call is under way */
    SUBMISSION_MADE,
    SUBMISSION_FAILED,
};

struct submission {
    struct execution_order *order;
    struct submission *next; /* spare */
    enum submission_kind kind;
    enum submission_state state;
    VkQueue queue;
    VkFence fence;
    struct order_queue *queue_record; /* NULL: the host */
    uint64_t serial;                  /* of the calls that succeeded; 0: not yet */
    uint32_t references; /* of the caller until it is finished, and one a batch held or to run */
    bool out_of_memory;
    bool checked, skip;
    bool uncertain;              /* see start_submission */
    uint32_t ready_count;        /* batches, from the first, that nothing held back when prepared */
    struct execution_clock host; /* when prepared */
    struct queue_clocks clocks;  /* of the queue, after the ready batches */

    struct order_batch *batches;
    uint32_t batch_count, batch_capacity;
    struct semaphore_operation *operations; /* batch after batch, as they were added */
    uint32_t operation_count, operation_capacity;
    struct submitted_commands *commands;
    uint32_t command_count, command_capacity;
};

struct execution_order {
    struct execution_hooks hooks; /* never change */
    pthread_mutex_t lock;
    struct handle_table semaphores, fences;
    struct order_queue queues[EXECUTION_QUEUES]; /* [EXECUTION_HOST] stands for the host */
    uint32_t queue_count;
    struct execution_clock host; /* what the host has seen complete */
    uint64_t host_count;         /* of host work that has ended */
    uint64_t last_serial, last_semaphore;
    uint32_t in_flight;  /* calls under way that may release held batches */
    uint32_t waiting;    /* calls under way with batches that will be held */
    uint32_t held_count; /* batches */
    struct order_batch *run_list, **run_end;
    bool busy; /* a thread is in a hook that is not to be called by two at once */
    bool order_unknown, unknown_reported;
    enum order_unknown_reason unknown_reason; /* while it is lost */
    bool has_open;                            /* any queue has an open batch */
    struct submission *spare;
};

/* All of these want the lock, and those of execution_run.c may give it up and take it again. */

/* NULL if there is none. */
struct semaphore_clock *execution_order_semaphore(const struct execution_order *order,
                                                  VkSemaphore handle);
struct order_fence *execution_order_fence(const struct execution_order *order, VkFence handle);

/* execution_resolve.c: from semaphores to moments and clocks. */

/* Gives the submission's semaphore operations their values and announces its signals. */
void submission_announce(struct submission *submission);
bool order_batch_is_last(const struct order_batch *batch);
/* Joins what the waits bring: to `all` in any case, to `builds` by their scopes. Returns whether
 * one of them was open. */
bool order_batch_follow_waits(const struct order_batch *batch, struct execution_clock *builds,
                              struct execution_clock *all);
void order_batch_set_signal(struct order_batch *batch, const struct semaphore_operation *operation,
                            const struct execution_clock *carried);
/* Resolves batches, from the first, as long as nothing holds them back. */
void submission_resolve_ready(struct submission *submission);
/* The call has succeeded: others see what it signals, and its other batches are held. */
void submission_publish(struct submission *submission);
/* The call has failed: as if it had not been announced. */
void submission_retract(struct submission *submission);
/* Drops signals that no batch will have to wait for. */
void execution_order_prune(const struct execution_order *order, struct semaphore_clock *semaphore);
/* Resolves held batches until there are none that could be. */
void execution_order_release_held(struct execution_order *order);

/* execution_bindings.c */
void order_batch_resolve_bindings(struct order_batch *batch, struct queue_clocks *clocks);
/* Joins what has executed when a queue is idle. */
void execution_order_join_all(struct execution_clock *clock, const struct order_queue *queue);

/* execution_run.c */
void execution_order_append_run(struct execution_order *order, struct order_batch *batch);
void execution_order_set_unknown_locked(struct execution_order *order,
                                        enum order_unknown_reason why);
void execution_order_drain(struct execution_order *order);
/* Calls `check` for the ready batches if it is their turn. Returns whether to skip the call. */
bool submission_check(struct submission *submission);
/* Takes the prepared batches out of the run list, after `drop` if they were checked. */
void submission_withdraw(struct submission *submission);
void submission_unreference(struct submission *submission);

void submission_free(struct submission *submission);

/* NULL: the batch has none. */
static inline struct semaphore_operation *order_batch_operations(const struct order_batch *batch)
{
    return batch->operation_count ? &batch->submission->operations[batch->first_operation] : NULL;
}

#endif
