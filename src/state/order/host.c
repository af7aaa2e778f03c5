/* SPDX-License-Identifier: Apache-2.0 */
/* The semaphores and fences of an order, and the completions that the host has observed. */
#include <stdlib.h>

#include "src/base/handle.h"
#include "src/state/order/records.h"

static uint64_t key_of_semaphore(VkSemaphore handle)
{
    return handle_number(handle);
}

static uint64_t key_of_fence(VkFence handle)
{
    return handle_number(handle);
}

struct semaphore_clock *execution_order_semaphore(const struct execution_order *order,
                                                  VkSemaphore handle)
{
    return handle_table_find(&order->semaphores, key_of_semaphore(handle));
}

struct order_fence *execution_order_fence(const struct execution_order *order, VkFence handle)
{
    return handle_table_find(&order->fences, key_of_fence(handle));
}

/* Returns true with the lock held; false, without it, if the order is unknown or missing. */
static bool lock_known_order(struct execution_order *order)
{
    if (!order)
        return false;
    pthread_mutex_lock(&order->lock);
    if (!unknown_is_set(&order->unknown))
        return true;
    pthread_mutex_unlock(&order->lock);
    return false;
}

static void drain_and_unlock(struct execution_order *order)
{
    execution_order_drain(order);
    pthread_mutex_unlock(&order->lock);
}

/* ---- waits of the host as batches */

void execution_order_add_host_wait(struct execution_order *order, VkSemaphore handle,
                                   uint64_t value)
{
    const struct semaphore_clock *semaphore = execution_order_semaphore(order, handle);
    struct submission *submission = order->hooks.follows_host && !unknown_is_set(&order->unknown)
                                        ? submission_create(order, SUBMIT_HOST_WAIT, VK_NULL_HANDLE)
                                        : NULL;
    if (!submission)
        return;
    execution_clock_copy(&submission->host, &order->host);
    submission->timed_out_waits = order->timed_out_waits;
    submission_add_batch(submission);
    submission_add_wait(submission, handle, value, SCOPE_ALL);
    if (submission->out_of_memory) {
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_OUT_OF_MEMORY);
    } else {
        struct order_batch *batch = &submission->batches[0];
        execution_clock_copy(&batch->clock, &order->host);
        if (semaphore)
            submission->operations[0].id = semaphore->id;
        order_batch_follow_waits(batch, &batch->clock, &batch->clock, &order->maybe);
        batch->predecessors_known = semaphore != NULL;
        submission_describe(submission);
        submission_set_states(submission, BATCH_SUBMITTED);
        batch_list_append_submission(&order->batches, submission);
        order_batch_end_on_host(batch);
    }
    submission_unreference(submission);
}

/* ---- semaphores */

static void remove_semaphore(struct execution_order *order, VkSemaphore handle)
{
    struct semaphore_clock *semaphore =
        handle_table_remove(&order->semaphores, key_of_semaphore(handle));
    if (!semaphore)
        return;
    semaphore_clock_release(semaphore);
    free(semaphore);
}

void execution_order_add_semaphore(struct execution_order *order, VkSemaphore handle,
                                   VkSemaphoreType type, uint64_t initial_value, bool foreign)
{
    if (!lock_known_order(order))
        return;
    remove_semaphore(order, handle);
    struct semaphore_clock *semaphore = calloc(1, sizeof(*semaphore));
    if (semaphore && handle_table_set(&order->semaphores, key_of_semaphore(handle), semaphore)) {
        semaphore->id = ++order->last_semaphore;
        semaphore->timeline = type == VK_SEMAPHORE_TYPE_TIMELINE;
        semaphore->initial = semaphore->reached = semaphore->met = initial_value;
        semaphore->foreign = foreign;
    } else {
        free(semaphore);
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_OUT_OF_MEMORY);
    }
    drain_and_unlock(order);
}

void execution_order_remove_semaphore(struct execution_order *order, VkSemaphore handle)
{
    if (!lock_known_order(order))
        return;
    remove_semaphore(order, handle);
    execution_order_release_held(order);
    drain_and_unlock(order);
}

void execution_order_set_semaphore_foreign(struct execution_order *order, VkSemaphore handle)
{
    if (!lock_known_order(order))
        return;
    struct semaphore_clock *semaphore = execution_order_semaphore(order, handle);
    if (semaphore)
        semaphore->foreign = true;
    execution_order_release_held(order);
    drain_and_unlock(order);
}

void execution_order_forget_signal(struct execution_order *order, VkSemaphore handle)
{
    if (!lock_known_order(order))
        return;
    struct semaphore_clock *semaphore = execution_order_semaphore(order, handle);
    if (semaphore && !semaphore->timeline)
        semaphore->last_wait = semaphore_clock_last(semaphore);
    drain_and_unlock(order);
}

/* ---- fences */

void execution_order_add_fence(struct execution_order *order, VkFence handle, bool foreign,
                               bool signaled)
{
    if (!lock_known_order(order))
        return;
    free(handle_table_remove(&order->fences, key_of_fence(handle)));
    struct order_fence *fence = calloc(1, sizeof(*fence));
    if (fence && handle_table_set(&order->fences, key_of_fence(handle), fence)) {
        fence->foreign = foreign;
        fence->seen = signaled;
    } else {
        free(fence);
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_OUT_OF_MEMORY);
    }
    drain_and_unlock(order);
}

void execution_order_remove_fence(struct execution_order *order, VkFence handle)
{
    if (!lock_known_order(order))
        return;
    free(handle_table_remove(&order->fences, key_of_fence(handle)));
    drain_and_unlock(order);
}

void execution_order_set_fence_foreign(struct execution_order *order, VkFence handle)
{
    if (!lock_known_order(order))
        return;
    struct order_fence *fence = execution_order_fence(order, handle);
    if (fence)
        fence->foreign = fence->is_imported = true;
    drain_and_unlock(order);
}

void execution_order_reset_fence(struct execution_order *order, VkFence handle)
{
    if (!lock_known_order(order))
        return;
    struct order_fence *fence = execution_order_fence(order, handle);
    if (fence) {
        fence->serial = 0;
        fence->seen = fence->has_clock = false;
    }
    drain_and_unlock(order);
}

void execution_order_join_fence(struct execution_order *order, const struct order_fence *fence)
{
    execution_clock_join(&order->host, &fence->clock);
    execution_clock_join(&order->maybe, &fence->behind);
}

/* ---- completions that the host has observed
 *
 * If a held batch is complete, either a call that released it is still under way, and the
 * completion counts when that call has returned; or something that the layer can't track released
 * it, and the order becomes unknown. */

void execution_order_observe_fence(struct execution_order *order, VkFence handle)
{
    if (!lock_known_order(order))
        return;
    struct order_fence *fence = execution_order_fence(order, handle);
    if (fence && !fence->foreign && fence->serial) {
        if (fence->has_clock)
            execution_order_join_fence(order, fence);
        else if (!order->in_flight)
            execution_order_set_unknown_locked(order, ORDER_UNKNOWN_UNTRACKED_SIGNAL);
    } else if (fence && !fence->seen) {
        order->untracked += fence->is_imported || !fence->serial;
        execution_order_add_host_wait(order, VK_NULL_HANDLE, 0);
    }
    if (fence)
        fence->seen = true;
    drain_and_unlock(order);
}

/* Submits the wait, unless the host has observed so much already. What the value of a foreign
 * semaphore means is unknown. */
static void note_wait(struct execution_order *order, VkSemaphore handle,
                      const struct semaphore_clock *semaphore, uint64_t seen_before)
{
    if (semaphore->seen > seen_before && semaphore->seen > semaphore->initial)
        execution_order_add_host_wait(order, semaphore->foreign ? VK_NULL_HANDLE : handle,
                                      semaphore->seen);
}

void execution_order_observe_semaphore(struct execution_order *order, VkSemaphore handle,
                                       uint64_t value, bool exact)
{
    if (!lock_known_order(order))
        return;
    struct semaphore_clock *semaphore = execution_order_semaphore(order, handle);
    if (semaphore && semaphore->timeline) {
        const uint64_t seen_before = semaphore->seen;
        semaphore_clock_observe(semaphore, value, exact);
        if (!semaphore_clock_catch_up(semaphore, &order->host, &order->maybe) && !order->in_flight)
            execution_order_set_unknown_locked(order, ORDER_UNKNOWN_UNTRACKED_SIGNAL);
        note_wait(order, handle, semaphore, seen_before);
        execution_order_release_held(order);
    }
    drain_and_unlock(order);
}

void execution_order_note_timeout(struct execution_order *order, uint64_t timeout)
{
    if (!lock_known_order(order))
        return;
    order->timeouts[order->timed_out_waits++ % ORDER_TIMEOUTS] = timeout;
    drain_and_unlock(order);
}

uint64_t execution_order_find_timeout(struct execution_order *order, uint64_t after, uint64_t until)
{
    uint64_t timeout = 0;
    if (!lock_known_order(order))
        return 0;
    if (after < until && after < order->timed_out_waits &&
        order->timed_out_waits - after <= ORDER_TIMEOUTS)
        timeout = order->timeouts[after % ORDER_TIMEOUTS];
    pthread_mutex_unlock(&order->lock);
    return timeout;
}

/* The host may have observed the completion of the work in `clock`; NULL: of any work. */
static void note_maybe(struct execution_order *order, const struct execution_clock *clock)
{
    if (clock)
        execution_clock_join(&order->maybe, clock);
    else
        order->untracked++;
}

void execution_order_observe_unknown(struct execution_order *order,
                                     const struct execution_clock *clock)
{
    if (!lock_known_order(order))
        return;
    note_maybe(order, clock);
    execution_order_add_host_wait(order, VK_NULL_HANDLE, 0);
    drain_and_unlock(order);
}

/* Adds what the host knows if the fence is signaled. Returns false if that is unknown. */
static bool add_fence(const struct execution_order *order, VkFence handle,
                      struct execution_clock *clock)
{
    const struct order_fence *fence = execution_order_fence(order, handle);
    if (fence && fence->foreign && !fence->is_imported && fence->serial)
        return true;
    if (!fence || fence->foreign || (fence->serial ? !fence->has_clock : !fence->seen))
        return false;
    if (fence->serial)
        execution_clock_join(clock, &fence->behind);
    return true;
}

void execution_order_observe_any_fence(struct execution_order *order, uint32_t count,
                                       const VkFence *fences)
{
    struct execution_clock clock = {0};
    bool is_known = true;
    if (!lock_known_order(order))
        return;
    for (uint32_t i = 0; i < count; i++)
        is_known &= add_fence(order, fences[i], &clock);
    note_maybe(order, is_known ? &clock : NULL);
    execution_order_add_host_wait(order, VK_NULL_HANDLE, 0);
    drain_and_unlock(order);
}

/* Does the same for a semaphore that has the value. */
static bool add_semaphore(const struct execution_order *order, VkSemaphore handle, uint64_t value,
                          struct execution_clock *clock)
{
    const struct semaphore_clock *semaphore = execution_order_semaphore(order, handle);
    const struct semaphore_signal *signal = NULL;
    if (!semaphore || !semaphore->timeline || semaphore->foreign)
        return false;
    const enum semaphore_wait_status status = semaphore_clock_wait(semaphore, value, NULL, &signal);
    if (status == SEMAPHORE_REACHED && signal)
        execution_clock_join(clock, &signal->behind);
    return status == SEMAPHORE_MET || (status == SEMAPHORE_REACHED && signal);
}

void execution_order_observe_any_semaphore(struct execution_order *order,
                                           const VkSemaphoreWaitInfo *info)
{
    struct execution_clock clock = {0};
    bool is_known = true;
    if (!lock_known_order(order))
        return;
    for (uint32_t i = 0; i < info->semaphoreCount; i++)
        is_known &= add_semaphore(order, info->pSemaphores[i], info->pValues[i], &clock);
    note_maybe(order, is_known ? &clock : NULL);
    execution_order_add_host_wait(order, VK_NULL_HANDLE, 0);
    drain_and_unlock(order);
}

void execution_order_note_results(struct execution_order *order,
                                  const struct execution_clock *clock)
{
    if (!lock_known_order(order))
        return;
    note_maybe(order, clock);
    pthread_mutex_unlock(&order->lock);
}

void execution_order_note_acquisition(struct execution_order *order)
{
    if (!lock_known_order(order))
        return;
    order->untracked += order->queue_count > EXECUTION_HOST + 2; /* two queues or more */
    pthread_mutex_unlock(&order->lock);
}

static void start_idle(struct idle_wait *wait, const struct order_queue *queue)
{
    execution_order_join_all(&wait->clock, queue);
    execution_clock_join(&wait->behind, &queue->clocks.behind);
}

void execution_order_join_idle(struct execution_order *order, const struct order_queue *queue)
{
    execution_order_join_all(&order->host, queue);
    execution_clock_join(&order->maybe, &queue->clocks.behind);
}

void execution_order_start_idle(struct execution_order *order, VkQueue handle,
                                struct idle_wait *wait)
{
    *wait = (struct idle_wait){.queue = handle};
    if (!lock_known_order(order))
        return;
    wait->serial = order->last_serial;
    for (uint32_t i = EXECUTION_HOST + 1; i < order->queue_count; i++)
        if (!handle || order->queues[i].handle == handle)
            start_idle(wait, &order->queues[i]);
    drain_and_unlock(order);
}

static void observe_queue_idle(struct execution_order *order, struct order_queue *queue,
                               uint64_t serial)
{
    if (queue->held && queue->held->submission->serial <= serial && !order->in_flight)
        execution_order_set_unknown_locked(order, ORDER_UNKNOWN_UNTRACKED_SIGNAL);
    else
        queue->idle_serial = serial;
}

void execution_order_observe_idle(struct execution_order *order, const struct idle_wait *wait)
{
    if (!lock_known_order(order))
        return;
    execution_clock_join(&order->host, &wait->clock);
    execution_clock_join(&order->maybe, &wait->behind);
    for (uint32_t i = EXECUTION_HOST + 1;
         i < order->queue_count && !unknown_is_set(&order->unknown); i++)
        if (!wait->queue || order->queues[i].handle == wait->queue)
            observe_queue_idle(order, &order->queues[i], wait->serial);
    drain_and_unlock(order);
}

void execution_order_host_clock(struct execution_order *order, struct execution_clock *clock)
{
    clock->queues = 0;
    if (!lock_known_order(order))
        return;
    execution_clock_copy(clock, &order->host);
    drain_and_unlock(order);
}

bool execution_order_find_observed(struct execution_order *order, struct execution_clock *clock,
                                   uint64_t *untracked)
{
    if (!lock_known_order(order))
        return false;
    execution_clock_copy(clock, &order->host);
    execution_clock_join(clock, &order->maybe);
    *untracked = order->untracked;
    pthread_mutex_unlock(&order->lock);
    return true;
}

bool execution_order_host_is_current(struct execution_order *order, struct execution_clock *clock)
{
    clock->queues = 0;
    if (!lock_known_order(order))
        return false;
    execution_clock_copy(clock, &order->host);
    bool all_ran = !order->run_list && !order->drain.is_busy;
    drain_and_unlock(order);
    return all_ran;
}
