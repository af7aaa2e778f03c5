/* SPDX-License-Identifier: Apache-2.0 */
/* The order in which the batches of one device execute, over all queues, as far as it is certain.
 *
 * A submitting call takes three steps: its batches are collected (submission_begin and
 * submission_add_*), prepared before the call goes down, and finished after it. Semaphores, fences
 * and the completions that the host has observed give each batch a timestamp, and a clock of all
 * work that certainly executes before the batch. A batch is held if it waits for a timeline value
 * whose signal has not been submitted. Later batches of its queue that must follow it are also
 * held.
 *
 * The consumers (batch_consumer) get a batch after all batches that certainly precede it. A batch
 * that is not held enters the run list when it is prepared, so batches run in the order in which
 * their submissions began. The batch at the head of the list blocks the list while its call is
 * under way: between its check and its run or undo, no other batch runs.
 *
 * Host work (a host command that works on structures) may take long and does not block the list.
 * It runs twice: when it has begun, and when it has ended. Its timestamp is that of its end; its
 * clock is taken when it begins. A check of host work must not change anything, because no undo
 * follows it.
 *
 * One lock guards the order; it is released while a call goes down and while a consumer's function
 * runs. `check`, `undo`, `run`, `ran` and `order_unknown` are called by one thread at a time: if
 * one thread is at it, it also runs the batches of the others. So the thread that runs a batch may
 * differ from the one that submitted it, and the submission may have completed by then. Therefore
 * `capture` takes at submission all that a batch needs of its command buffers.
 *
 * The order can become unknown (enum order_unknown_reason), and stays unknown for the rest of the
 * device's life: no batch runs any more. All functions accept NULL as an unknown or missing order.
 */
#ifndef ASSAY_STATE_ORDER_ORDER_H
#define ASSAY_STATE_ORDER_ORDER_H

#include "src/state/order/batch.h"

struct execution_order;

/* Why the order is unknown: the cause, and which submissions of devices the summary counts as
 * unchecked then. */
#define ORDER_UNKNOWN_REASONS(REASON)                                                              \
    REASON(DEVICE_LOST, "the device is lost", "from when they were lost")                          \
    REASON(OUT_OF_MEMORY, "the layer ran out of memory", "from when the layer ran out of memory")  \
    REASON(TOO_MANY_QUEUES, "there are more queues than the layer supports",                       \
           "that use more queues than the layer tracks")                                           \
    REASON(RACING_THREADS, "two threads submitted to one queue at once",                           \
           "after two threads submitted to one queue at once")                                     \
    REASON(TOO_MANY_WAITS, "too many submissions wait for signals that have not been submitted",   \
           "after too many waited for signals not yet submitted")                                  \
    REASON(UNTRACKED_SIGNAL, "a submission completed although nothing known ended its wait",       \
           "after a wait ended by a signal that the layer does not track")

#define REASON(reason, cause, unchecked) ORDER_UNKNOWN_##reason,
enum order_unknown_reason { ORDER_UNKNOWN_REASONS(REASON) ORDER_UNKNOWN_REASON_COUNT };
#undef REASON
extern const struct order_unknown_words {
    const char *cause, *unchecked;
} order_unknown_words[ORDER_UNKNOWN_REASON_COUNT];

/* How the order gets what command buffers recorded. Each function may be NULL. */
struct execution_hooks {
    void *user;
    /* Consumers also get batches of the host of phase WORK_SYNC: a signal, or a wait that has
     * ended. A wait without operation and with predecessors unknown may have been for anything. */
    bool follows_host;
    /* Returns what consumers will need of a command buffer that is being submitted: a reference to
     * its journal, which `release` gives back. Called on the submitting thread before the call goes
     * down; `release` may be called on any thread. */
    void *(*capture)(void *user, VkCommandBuffer command_buffer);
    void (*release)(void *user, void *captured);
    /* Whether the command buffer waits for something that only the host may do after the
     * submission, such as vkSetEvent. Work before the rest of the queue is unknown then. Called
     * right after `capture`. */
    bool (*is_open)(void *user, VkQueue queue, const void *captured);
};

/* A consumer of batches. Each function may be NULL. No lock is held while a function runs. */
struct batch_consumer {
    void *user; /* passed to each function; lives as long as the order */

    /* Called on the submitting thread before the call goes down, for each batch of commands, even
     * if it is held: for what depends on the time of the submission, but not on the order. Several
     * threads may be in this function. May set skips_call. */
    void (*submit)(void *user, struct order_batch *batch);
    /* Called before the call goes down, if all earlier batches have run, or belong to the same call
     * and were checked just before. May set skips_call. */
    void (*check)(void *user, struct order_batch *batch);
    /* The call has failed or is skipped: the batch was checked and won't run. */
    void (*undo)(void *user, struct order_batch *batch);
    /* The batch is submitted, and all batches that certainly precede it have run. */
    void (*run)(void *user, struct order_batch *batch);
    /* Each consumer has run the batch. */
    void (*ran)(void *user, struct order_batch *batch);
    /* The call has failed or is skipped, and the device is not lost: nothing was submitted. Called
     * for batches of commands, on any thread. */
    void (*fail)(void *user, struct order_batch *batch);
    /* The last user of the submission has let go. Called on any thread; the caller may hold a lock
     * (submission_finish_silently()). Batches that never ran retire, too. */
    void (*retire)(void *user, struct order_batch *batch);
    /* The order became unknown: any batch may have executed. */
    void (*order_unknown)(void *user, enum order_unknown_reason why);
    /* The order is unknown: takes an execution right after its submission, while its queue counts
     * as in use, on any thread. It sends no message. */
    void (*run_unordered)(void *user, struct execution *execution);

    /* Uses the copies of the executions that the application has observed to be complete. Called by
     * any thread when the application waits, queries or submits. */
    void (*deliver)(void *user);
    /* Waits for one execution to complete, then does what `deliver` does. Returns false if there is
     * none, or if it does not complete in a while. Called by any thread. */
    bool (*wait)(void *user);
};

VkResult execution_order_create(struct execution_order **order,
                                const struct execution_hooks *hooks);
/* Call before the device is published. Consumers are called in the order in which they are added.
 * Returns false if memory runs out. */
bool execution_order_add_consumer(struct execution_order *order, struct batch_consumer consumer);
/* The batches that are not retired. */
struct batch_list *execution_order_batches(struct execution_order *order);
/* Call `deliver` of each consumer; `wait` of each until one returns true; `run_unordered` of each.
 */
void execution_order_deliver(const struct execution_order *order);
bool execution_order_wait(const struct execution_order *order);
void execution_order_run_unordered(const struct execution_order *order,
                                   struct execution *execution);

/* Ends the order: releases batches that never ran without calling `run` or `undo`. Then the
 * consumers let go of the others, and the order is destroyed. */
void execution_order_end(struct execution_order *order);
void execution_order_destroy(struct execution_order *order);

/* ---- submissions */

enum submission_kind {
    SUBMIT_COMMANDS,
    SUBMIT_BINDINGS,    /* vkQueueBindSparse: ordered by semaphores and fences only; never checked;
                           run if submission_add_work added work */
    SUBMIT_HOST_WORK,   /* a host command that works on structures: one batch of no queue */
    SUBMIT_HOST_SIGNAL, /* vkSignalSemaphore; no queue */
    SUBMIT_HOST_WAIT,   /* a completion that the host has observed; the order submits it itself */
};

/* Returns NULL if the order is unknown or missing. The submission belongs to the order. Only
 * submission_finish ends the caller's use of it, and each caller calls it once. All functions below
 * accept NULL. submission_begin, submission_prepare and the functions that finish take the order's
 * lock; the others run on the submitting thread without it. */
struct submission *submission_begin(struct execution_order *order, enum submission_kind kind,
                                    VkQueue queue);
void submission_add_batch(struct submission *submission);

/* These add to the last batch. The value of a binary semaphore is ignored. */
void submission_add_wait(struct submission *submission, VkSemaphore semaphore, uint64_t value,
                         enum semaphore_scope scope);
void submission_add_commands(struct submission *submission, VkCommandBuffer command_buffer);
/* Adds host work or bindings. The submission takes over `captured` and gives it to `release`. If
 * `submission` is NULL, the caller keeps `captured`. */
void submission_add_work(struct submission *submission, void *captured);
void submission_add_signal(struct submission *submission, VkSemaphore semaphore, uint64_t value,
                           enum semaphore_scope scope);

/* The stages that the last wait or signal orders, if not ALL_COMMANDS. */
void submission_set_stages(struct submission *submission, VkPipelineStageFlags2 stages);

/* Makes submission_prepare skip the call, whatever the consumers return. */
void submission_set_skip(struct submission *submission);

/* What messages say of the submission, and the number of objects that were destroyed before. The
 * submission takes over the reference to the labels; if the submission is NULL, the reference is
 * released. */
void submission_set_origin(struct submission *submission, const struct submission_origin *origin,
                           uint64_t destroy_count);

/* The fence is signaled when the whole submission has executed. */
void submission_set_fence(struct submission *submission, VkFence fence);

/* Call before the call goes down, without a lock: calls `submit` and `check`. Returns true if the
 * call is to be skipped. The submission has failed then, whatever submission_finish gets. */
bool submission_prepare(struct submission *submission);

/* Call after the call, without a lock: runs the batches that are ready. An error in `result` means
 * that nothing was submitted, or that host work has failed; VK_ERROR_DEVICE_LOST makes the order
 * unknown. */
void submission_finish(struct submission *submission, VkResult result);
/* submission_finish() in two parts, for callers that hold a lock: the first part calls only
 * `retire` and `release`, the second part runs the batches that are ready. */
void submission_finish_silently(struct submission *submission, VkResult result);
void execution_order_run(struct execution_order *order);

/* Whether the queue waits for a signal that was not submitted yet. False if the order is unknown.
 */
bool execution_order_holds_queue(struct execution_order *order, VkQueue queue);
/* Whether a batch is held, or another thread runs one or is about to. */
bool execution_order_has_pending(struct execution_order *order);
/* The submission whose call is under way on the queue. NULL: none, or the order is unknown. */
struct submission *execution_order_under_way(struct execution_order *order, VkQueue queue);
/* Hands an execution of the call's command buffer at `index`, counted over all batches, to its
 * batch, which keeps it for USES_EXECUTIONS. Call before submission_finish(), on the same thread.
 * Returns false, and leaves the execution to the caller, if there is no such command buffer. */
bool submission_set_execution(struct submission *submission, uint32_t index,
                              struct execution *execution);

/* ---- semaphores and fences */

/* These functions take the order's lock and may run batches.
 * `foreign`: operations that the layer does not intercept may also signal the object. */
void execution_order_add_semaphore(struct execution_order *order, VkSemaphore handle,
                                   VkSemaphoreType type, uint64_t initial_value, bool foreign);
void execution_order_remove_semaphore(struct execution_order *order, VkSemaphore handle);
void execution_order_set_semaphore_foreign(struct execution_order *order, VkSemaphore handle);
/* A presentation has waited for the binary semaphore, or an acquisition will signal it. */
void execution_order_forget_signal(struct execution_order *order, VkSemaphore handle);

/* `signaled`: from the start. */
void execution_order_add_fence(struct execution_order *order, VkFence handle, bool foreign,
                               bool signaled);
void execution_order_remove_fence(struct execution_order *order, VkFence handle);
void execution_order_set_fence_foreign(struct execution_order *order, VkFence handle);
void execution_order_reset_fence(struct execution_order *order, VkFence handle);

/* ---- completions that the host has observed */

void execution_order_observe_fence(struct execution_order *order, VkFence handle);
/* The semaphore's value is `value` (`exact`), or at least `value`. */
void execution_order_observe_semaphore(struct execution_order *order, VkSemaphore handle,
                                       uint64_t value, bool exact);
/* The host has observed something that may come behind the work in `clock`; NULL: behind any work.
 */
void execution_order_observe_unknown(struct execution_order *order,
                                     const struct execution_clock *clock);
/* The host has observed that one of the fences is signaled, or that one of the semaphores has its
 * value. It is not known which one. */
void execution_order_observe_any_fence(struct execution_order *order, uint32_t count,
                                       const VkFence *fences);
void execution_order_observe_any_semaphore(struct execution_order *order,
                                           const VkSemaphoreWaitInfo *info);

/* A wait of the host, for so many ns, returned VK_TIMEOUT. */
void execution_order_note_timeout(struct execution_order *order, uint64_t timeout);
/* Returns the timeout of the first wait that returned VK_TIMEOUT behind the first `after` of them
 * and is among the first `until`; 0: none, or it is forgotten. */
uint64_t execution_order_find_timeout(struct execution_order *order, uint64_t after,
                                      uint64_t until);

/* All work that was submitted before a wait for idle. Other submissions may overlap the wait. */
struct idle_wait {
    struct execution_clock clock;
    struct execution_clock behind; /* as in struct order_batch */
    uint64_t serial;               /* of the last submitting call before the wait */
    VkQueue queue;                 /* VK_NULL_HANDLE: all */
};
void execution_order_start_idle(struct execution_order *order, VkQueue handle,
                                struct idle_wait *wait);
void execution_order_observe_idle(struct execution_order *order, const struct idle_wait *wait);

/* Makes the order unknown, for example after a call returned VK_ERROR_DEVICE_LOST. */
void execution_order_set_unknown(struct execution_order *order, enum order_unknown_reason why);

/* Sets `clock` to all work that has certainly executed before a host command that begins now. */
void execution_order_host_clock(struct execution_order *order, struct execution_clock *clock);
/* Waits until all work has run that the host has observed to be complete: another thread may be
 * about to run it. Gives up after some seconds, so that a callback of the application in which that
 * thread is cannot cause a deadlock. Returns at once to a callback. A submission may not call it:
 * work behind the submission runs only after its call. */
void execution_order_await_observed(struct execution_order *order);
/* The host has read what commands wrote as they completed, so it may know that the work in `clock`
 * is complete; NULL: that any work is. Unlike execution_order_observe_unknown() it orders nothing.
 */
void execution_order_note_results(struct execution_order *order,
                                  const struct execution_clock *clock);
/* The presentation engine has given an image back. What waits for it may come behind work of other
 * queues without a semaphore that the order knows. */
void execution_order_note_acquisition(struct execution_order *order);
/* Sets `clock` to all work whose completion the host may have observed, and `untracked` to a number
 * that changes when it may have observed completions that the clock lacks. Returns false if the
 * order is unknown. */
bool execution_order_find_observed(struct execution_order *order, struct execution_clock *clock,
                                   uint64_t *untracked);
/* Sets `clock` likewise. Returns false if the order has not yet run a part of that work. */
bool execution_order_host_is_current(struct execution_order *order, struct execution_clock *clock);

#endif
