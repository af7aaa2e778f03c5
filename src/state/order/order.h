/* SPDX-License-Identifier: Apache-2.0 */
/* The order in which the batches of one device execute, over all queues, as far as it is certain.
 *
 * A call that submits goes through three steps: its batches are collected (submission_begin and
 * submission_add_*), prepared before the call goes down, and finished after it. From semaphores,
 * fences and what the host has seen complete each batch gets a moment, and a clock of all that it
 * certainly follows. A batch that waits for a timeline value whose signal has not been submitted is
 * held back, with all later ones of its queue that come after it, until the signal is.
 *
 * Who uses the order (execution_hooks) is told of each batch when all that it certainly follows has
 * been told before it. Batches that no signal holds back stand in a run list from the moment that
 * they are prepared, so one never runs before another whose submission began earlier, however the
 * application came to know that the earlier one is complete. A batch at the head of the list whose
 * call is under way blocks the list: from its check until its run, or its drop, nothing else runs.
 *
 * Work of the host may take long, and blocks nobody: it runs twice, when it has begun and when it
 * has ended, which is its moment. What it follows is what was known when it began. A check of it
 * must not change anything, so it is never dropped.
 *
 * One lock guards everything; it is held neither while a call goes down nor while a hook runs.
 * `check`, `run`, `drop` and `lost` are called by one thread at a time: one that finds another at
 * it leaves its batches to that one. So a hook's thread need not be the one that submitted, and its
 * submission may even have completed; what a batch needs of its command buffers is captured at
 * submission.
 *
 * Without memory, with a lost device, with more queues than there are indices, or where what the
 * host sees contradicts the order, the order is lost for the rest of the device's life: no batch
 * runs any more. All functions accept NULL for a lost or missing order. */
#ifndef ASSAY_STATE_ORDER_ORDER_H
#define ASSAY_STATE_ORDER_ORDER_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/order/clock.h"

struct execution_order;
struct submission;

struct submitted_commands {
    VkCommandBuffer handle; /* VK_NULL_HANDLE: other work */
    void *captured;
};

/* What has become of work of the host. */
enum work_phase {
    WORK_OF_QUEUE, /* it isn't the host's */
    WORK_BEGINS,
    WORK_ENDS,
    WORK_FAILS, /* it ends, too, and what it did isn't known */
};

/* A batch, when its turn has come. */
struct batch_run {
    VkQueue queue; /* VK_NULL_HANDLE: the host */
    enum work_phase work;
    struct timestamp timestamp;          /* of work of the host when it ends */
    const struct execution_clock *clock; /* what it certainly follows */
    const struct submitted_commands *commands;
    uint32_t command_count;
    bool checked; /* `check` has seen it */
    /* False: batches that have not been submitted yet may execute before it, so that nothing can be
     * said against it. What it does counts as ever. */
    bool predecessors_known;
};

/* Why the order is lost. */
enum order_unknown_reason {
    ORDER_UNKNOWN_DEVICE_LOST,      /* that is lost itself */
    ORDER_UNKNOWN_OUT_OF_MEMORY,    /* there was none */
    ORDER_UNKNOWN_TOO_MANY_QUEUES,  /* of which there are more than are told apart */
    ORDER_UNKNOWN_RACING_THREADS,   /* that submit to one queue at once */
    ORDER_UNKNOWN_TOO_MANY_WAITS,   /* for signals that aren't submitted: of too many batches, or of
                              sparse   bindings */
    ORDER_UNKNOWN_UNTRACKED_SIGNAL, /* that saw complete what nothing known has released */
};

/* What the order is for. Each may be NULL. */
struct execution_hooks {
    void *user;
    /* What `run` will need of a command buffer that is being submitted: a reference to its journal.
     * On the submitting thread, before the call goes down. `release` may come on any thread. */
    void *(*capture)(void *user, VkCommandBuffer command_buffer);
    void (*release)(void *user, void *captured);
    /* Whether it waits for what only the host may do, after the submission: what comes before the
     * rest of the queue is not known then. At once after `capture`. */
    bool (*is_open)(void *user, VkQueue queue, const void *captured);
    /* Before the call goes down: a batch with nothing before it that has not run, save for batches
     * of the same call that were checked just before. True: skip the call. */
    bool (*check)(void *user, const struct batch_run *batch);
    /* The call has failed or is skipped: what was checked since the last run will not run. */
    void (*drop)(void *user);
    /* The batch is submitted, and its turn has come. */
    void (*run)(void *user, const struct batch_run *batch);
    /* The order is lost: anything may have executed. */
    void (*order_unknown)(void *user, enum order_unknown_reason why);
};

VkResult execution_order_create(struct execution_order **order,
                                const struct execution_hooks *hooks);
/* Batches that never ran are dropped without a word. */
void execution_order_destroy(struct execution_order *order);

/* ---- submissions */

enum submission_kind {
    SUBMIT_COMMANDS,
    SUBMIT_BINDINGS,    /* vkQueueBindSparse: order by semaphores and fences only, and no check;
                           run where it has work */
    SUBMIT_HOST_WORK,   /* a host command that works on structures: one batch of no queue */
    SUBMIT_HOST_SIGNAL, /* vkSignalSemaphore; no queue */
};

/* What a semaphore operation orders besides other semaphore operations. */
enum semaphore_scope {
    SCOPE_NOTHING, /* none of the work on acceleration structures */
    SCOPE_BUILDS,  /* work on acceleration structures */
    SCOPE_ALL,     /* all commands */
};

/* NULL where nothing needs to be observed. */
struct submission *submission_begin(struct execution_order *order, enum submission_kind kind,
                                    VkQueue queue);
void submission_add_batch(struct submission *submission);

/* To the last batch. Values of binary semaphores are ignored. */
void submission_add_wait(struct submission *submission, VkSemaphore semaphore, uint64_t value,
                         enum semaphore_scope scope);
void submission_add_commands(struct submission *submission, VkCommandBuffer command_buffer);
/* Of the host, or bindings; `captured` goes to `release` in the end. Not for NULL. */
void submission_add_work(struct submission *submission, void *captured);
void submission_add_signal(struct submission *submission, VkSemaphore semaphore, uint64_t value,
                           enum semaphore_scope scope);

/* Prepared, it is to be skipped whatever the checks say. */
void submission_set_skip(struct submission *submission);

/* Signalled when all of it has executed. */
void submission_set_fence(struct submission *submission, VkFence fence);

/* Before the call goes down. True: a check asks to skip the call, and the submission is over. */
bool submission_prepare(struct submission *submission);

/* After the call. Errors mean that nothing was submitted, or that work of the host has failed; but
 * a lost device loses the order. */
void submission_finish(struct submission *submission, VkResult result);
/* The same in two parts, for callers with a lock: no hook is called but `release`; and what has its
 * turn by now runs. */
void submission_finish_silently(struct submission *submission, VkResult result);
void execution_order_run(struct execution_order *order);

/* ---- semaphores and fences */

/* `foreign`: it may also be signalled by what the layer doesn't see. */
void execution_order_add_semaphore(struct execution_order *order, VkSemaphore handle,
                                   VkSemaphoreType type, uint64_t initial_value, bool foreign);
void execution_order_remove_semaphore(struct execution_order *order, VkSemaphore handle);
void execution_order_set_semaphore_foreign(struct execution_order *order, VkSemaphore handle);
/* A binary semaphore was waited for by presentation, or is signalled by acquisition. */
void execution_order_forget_signal(struct execution_order *order, VkSemaphore handle);

void execution_order_add_fence(struct execution_order *order, VkFence handle, bool foreign);
void execution_order_remove_fence(struct execution_order *order, VkFence handle);
void execution_order_set_fence_foreign(struct execution_order *order, VkFence handle);
void execution_order_reset_fence(struct execution_order *order, VkFence handle);

/* ---- what the host has seen */

void execution_order_observe_fence(struct execution_order *order, VkFence handle);
/* Its value is that (`exact`), or at least that. */
void execution_order_observe_semaphore(struct execution_order *order, VkSemaphore handle,
                                       uint64_t value, bool exact);

/* What has been submitted before a wait for idle; the wait may overlap other submissions. */
struct idle_wait {
    struct execution_clock clock;
    uint64_t serial;
    VkQueue queue; /* VK_NULL_HANDLE: all */
};
void execution_order_start_idle(struct execution_order *order, VkQueue handle,
                                struct idle_wait *wait);
void execution_order_observe_idle(struct execution_order *order, const struct idle_wait *wait);

/* A call has returned VK_ERROR_DEVICE_LOST, say. */
void execution_order_set_unknown(struct execution_order *order, enum order_unknown_reason why);

/* What certainly executed before a command that the host is about to carry out. */
void execution_order_host_clock(struct execution_order *order, struct execution_clock *clock);
/* The same; false where not all of that has had its turn. */
bool execution_order_host_is_current(struct execution_order *order, struct execution_clock *clock);

#endif
