/* SPDX-License-Identifier: Apache-2.0 */
/* Fences, semaphores and events, and who waits for them; the simulated loss of the device; deferred
 * operations. */
#include "internal.h"

#include <errno.h>
#include <time.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of what is waited for */
static pthread_cond_t changed;
static pthread_once_t changed_once = PTHREAD_ONCE_INIT;
static atomic_bool lost;

bool device_is_lost(void)
{
    return atomic_load(&lost);
}

void null_driver_set_device_lost(bool is_lost)
{
    atomic_store(&lost, is_lost);
    sync_wake();
}

/* Its clock has to be that of the timeouts. */
static void make_changed(void)
{
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&changed, &attributes);
    pthread_condattr_destroy(&attributes);
}

void sync_wake(void)
{
    pthread_once(&changed_once, make_changed);
    pthread_mutex_lock(&lock);
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
}

static struct timespec deadline_of(uint64_t timeout)
{
    const uint64_t second = 1000000000, most = 3600 * 24 * 365;
    struct timespec deadline;
    clock_gettime(CLOCK_MONOTONIC, &deadline);
    const uint64_t seconds = timeout / second;
    deadline.tv_sec += (time_t)(seconds < most ? seconds : most);
    deadline.tv_nsec += (long)(timeout % second);
    if (deadline.tv_nsec >= (long)second) {
        deadline.tv_nsec -= (long)second;
        deadline.tv_sec++;
    }
    return deadline;
}

/* ---- values: 1 of a fence or an event that is set; binary semaphores need none, as nothing ever
 * waits for them */

/* Who waits for what is unknown need not wait. */
static uint64_t value_of(uint64_t handle, VkObjectType type)
{
    const struct object *object = object_find(handle, type);
    return object != NULL ? atomic_load(&object->value) : UINT64_MAX;
}

static void set_value(uint64_t handle, VkObjectType type, uint64_t value)
{
    struct object *object = object_find(handle, type);
    if (object != NULL)
        atomic_store(&object->value, value);
}

void sync_signal(uint64_t handle, VkObjectType type, uint64_t value)
{
    pthread_mutex_lock(&lock);
    if (value_of(handle, type) < value)
        set_value(handle, type, value);
    pthread_mutex_unlock(&lock);
}

ON_CREATION(CreateFence)
{
    object->value = pCreateInfo->flags & VK_FENCE_CREATE_SIGNALED_BIT;
}

ON_CREATION(CreateSemaphore)
{
    const VkSemaphoreTypeCreateInfo *type =
        chain_find(pCreateInfo->pNext, VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    object->value = type != NULL ? type->initialValue : 0;
}

COMMAND(ResetFences)
{
    for (uint32_t i = 0; i < fenceCount; i++)
        set_value(RAW(pFences[i]), VK_OBJECT_TYPE_FENCE, 0);
    return VK_SUCCESS;
}

COMMAND(SignalSemaphore)
{
    sync_signal(RAW(pSignalInfo->semaphore), VK_OBJECT_TYPE_SEMAPHORE, pSignalInfo->value);
    sync_wake();
    return VK_SUCCESS;
}

COMMAND(GetSemaphoreCounterValue)
{
    *pValue = value_of(RAW(semaphore), VK_OBJECT_TYPE_SEMAPHORE);
    return device_is_lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

COMMAND(SetEvent)
{
    set_value(RAW(event), VK_OBJECT_TYPE_EVENT, 1);
    return VK_SUCCESS;
}

COMMAND(ResetEvent)
{
    set_value(RAW(event), VK_OBJECT_TYPE_EVENT, 0);
    return VK_SUCCESS;
}

COMMAND(GetEventStatus)
{
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    return value_of(RAW(event), VK_OBJECT_TYPE_EVENT) == 1 ? VK_EVENT_SET : VK_EVENT_RESET;
}

/* ---- waiting */

struct wait {
    VkObjectType type;
    bool for_all;
    uint32_t count; /* 0: for the end of a hang */
    const void *handles;
    const uint64_t *values; /* NULL: 1 */
};

static uint64_t handle_at(const struct wait *wait, uint32_t i)
{
    return ((const uint64_t *)wait->handles)[i];
}

static bool is_over(const struct wait *wait)
{
    uint32_t reached = 0;
    for (uint32_t i = 0; i < wait->count; i++)
        reached += value_of(handle_at(wait, i), wait->type) >=
                   (wait->values != NULL ? wait->values[i] : 1);
    if (wait->count == 0)
        return !device_hangs();
    return wait->for_all ? reached == wait->count : reached > 0;
}

/* Uses more processor time than any wait needs, however busy the machine is. */
static void compute(void)
{
    const int64_t most = 5 * 1000 * 1000;
    struct timespec begin, now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    do
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    while ((now.tv_sec - begin.tv_sec) * 1000000000 + now.tv_nsec - begin.tv_nsec < most);
}

/* Signals the next fence, but not the last one; or counts all semaphores up. */
static void signal_some(const struct wait *wait)
{
    const bool are_fences = wait->type == VK_OBJECT_TYPE_FENCE;
    for (uint32_t i = 0; i + are_fences < wait->count; i++) {
        const uint64_t value = value_of(handle_at(wait, i), wait->type);
        if (are_fences && value > 0)
            continue;
        sync_signal(handle_at(wait, i), wait->type, value + 1);
        if (are_fences)
            return;
    }
}

static VkResult wait_for(const struct wait *wait, uint64_t timeout)
{
    if (timeout > 0 && hang_progress() == NULL_DRIVER_COMPUTES)
        compute();
    if (timeout > 0 && hang_progress() == NULL_DRIVER_SIGNALS)
        signal_some(wait);
    fault_at_wait(timeout);
    const struct timespec deadline = deadline_of(timeout);
    pthread_once(&changed_once, make_changed);
    pthread_mutex_lock(&lock);
    bool timed_out = timeout == 0;
    bool reached = is_over(wait);
    while (!reached && !timed_out && !device_is_lost()) {
        timed_out = pthread_cond_timedwait(&changed, &lock, &deadline) == ETIMEDOUT;
        reached = is_over(wait);
    }
    pthread_mutex_unlock(&lock);
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    return reached ? VK_SUCCESS : VK_TIMEOUT;
}

VkResult sync_wait_idle(void)
{
    return wait_for(&(struct wait){0}, UINT64_MAX);
}

COMMAND(WaitForFences)
{
    return wait_for(&(struct wait){VK_OBJECT_TYPE_FENCE, waitAll, fenceCount, pFences, NULL},
                    timeout);
}

COMMAND(GetFenceStatus)
{
    const struct wait wait = {VK_OBJECT_TYPE_FENCE, true, 1, &fence, NULL};
    const VkResult result = wait_for(&wait, 0);
    return result == VK_TIMEOUT ? VK_NOT_READY : result;
}

COMMAND(WaitSemaphores)
{
    const struct wait wait = {
        VK_OBJECT_TYPE_SEMAPHORE, !(pWaitInfo->flags & VK_SEMAPHORE_WAIT_ANY_BIT),
        pWaitInfo->semaphoreCount, pWaitInfo->pSemaphores, pWaitInfo->pValues};
    return wait_for(&wait, timeout);
}

/* ---- deferred operations: nothing to do, but done only at the join that the configuration says */

static pthread_mutex_t joins_lock = PTHREAD_MUTEX_INITIALIZER; /* of all operations */

VkResult deferred_start(VkDevice device, VkDeferredOperationKHR operation)
{
    struct object *object = FIND(DEFERRED_OPERATION_KHR, operation);
    if (object == NULL)
        return VK_SUCCESS;
    const uint32_t joins = CONFIG(device)->deferred_joins;
    pthread_mutex_lock(&joins_lock);
    object->deferred.joins_left = joins;
    pthread_mutex_unlock(&joins_lock);
    return joins > 0 ? VK_OPERATION_DEFERRED_KHR : VK_OPERATION_NOT_DEFERRED_KHR;
}

static uint32_t joins_left(VkDeferredOperationKHR operation)
{
    const struct object *object = FIND(DEFERRED_OPERATION_KHR, operation);
    pthread_mutex_lock(&joins_lock);
    const uint32_t left = object != NULL ? object->deferred.joins_left : 0;
    pthread_mutex_unlock(&joins_lock);
    return left;
}

COMMAND(GetDeferredOperationMaxConcurrencyKHR)
{
    return joins_left(operation);
}

COMMAND(GetDeferredOperationResultKHR)
{
    return joins_left(operation) > 0 ? VK_NOT_READY : VK_SUCCESS;
}

COMMAND(DeferredOperationJoinKHR)
{
    struct object *object = FIND(DEFERRED_OPERATION_KHR, operation);
    if (object == NULL)
        return VK_SUCCESS;
    pthread_mutex_lock(&joins_lock);
    if (object->deferred.joins_left > 0)
        object->deferred.joins_left--;
    const bool done = object->deferred.joins_left == 0;
    pthread_mutex_unlock(&joins_lock);
    return done ? VK_SUCCESS : VK_THREAD_IDLE_KHR;
}
