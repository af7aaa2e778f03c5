/* SPDX-License-Identifier: Apache-2.0 */
/* Fences, semaphores and events, and who waits for them; the simulated loss of the device. */
#include "internal.h"

#include <errno.h>
#include <time.h>

static pthread_mutex_t lock =
    PTHREAD_MUTEX_INITIALIZER; /* of every fence's and semaphore's value */
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

/* Waits until done(what), which is asked with the lock held. */
static VkResult wait_until(bool (*done)(const void *what), const void *what, uint64_t timeout)
{
    fault_at_wait(timeout);
    const struct timespec deadline = deadline_of(timeout);
    pthread_once(&changed_once, make_changed);
    pthread_mutex_lock(&lock);
    bool timed_out = timeout == 0;
    bool reached = done(what);
    while (!reached && !timed_out && !device_is_lost()) {
        timed_out = pthread_cond_timedwait(&changed, &lock, &deadline) == ETIMEDOUT;
        reached = done(what);
    }
    pthread_mutex_unlock(&lock);
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    return reached ? VK_SUCCESS : VK_TIMEOUT;
}

static bool no_longer_hangs(const void *what)
{
    return !device_hangs();
}

VkResult sync_wait_idle(void)
{
    return wait_until(no_longer_hangs, NULL, UINT64_MAX);
}

/* ---- fences */

ON_CREATION(CreateFence)
{
    object->fence_signaled = pCreateInfo->flags & VK_FENCE_CREATE_SIGNALED_BIT;
}

static void set_fence(VkFence fence, bool signaled)
{
    struct object *object = FIND(FENCE, fence);
    pthread_mutex_lock(&lock);
    if (object != NULL)
        object->fence_signaled = signaled;
    pthread_mutex_unlock(&lock);
}

void sync_signal_fence(VkFence fence)
{
    set_fence(fence, true);
}

COMMAND(ResetFences)
{
    for (uint32_t i = 0; i < fenceCount; i++)
        set_fence(pFences[i], false);
    return VK_SUCCESS;
}

struct fence_wait {
    uint32_t count;
    const VkFence *fences;
    bool all;
};

static bool fences_done(const void *what)
{
    const struct fence_wait *wait = what;
    uint32_t signaled = 0;
    for (uint32_t i = 0; i < wait->count; i++) {
        const struct object *fence = FIND(FENCE, wait->fences[i]);
        signaled += fence == NULL || fence->fence_signaled;
    }
    return wait->all ? signaled == wait->count : signaled > 0;
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

/* All but the last fence. */
static void signal_next(uint32_t count, const VkFence *fences)
{
    for (uint32_t i = 0; i + 1 < count; i++) {
        const struct object *fence = FIND(FENCE, fences[i]);
        if (fence != NULL && !fence->fence_signaled) {
            sync_signal_fence(fences[i]);
            return;
        }
    }
}

COMMAND(WaitForFences)
{
    const struct fence_wait wait = {fenceCount, pFences, waitAll};
    if (timeout > 0 && hang_progress() == NULL_DRIVER_COMPUTES)
        compute();
    if (timeout > 0 && hang_progress() == NULL_DRIVER_SIGNALS)
        signal_next(fenceCount, pFences);
    return wait_until(fences_done, &wait, timeout);
}

COMMAND(GetFenceStatus)
{
    const struct fence_wait wait = {1, &fence, true};
    const VkResult result = wait_until(fences_done, &wait, 0);
    return result == VK_TIMEOUT ? VK_NOT_READY : result;
}

/* ---- semaphores: binary ones have no state, as nothing ever waits for them */

ON_CREATION(CreateSemaphore)
{
    const VkSemaphoreTypeCreateInfo *type =
        chain_find(pCreateInfo->pNext, VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    object->semaphore_value = type != NULL ? type->initialValue : 0;
}

void sync_signal_semaphore(VkSemaphore semaphore, uint64_t value)
{
    struct object *object = FIND(SEMAPHORE, semaphore);
    pthread_mutex_lock(&lock);
    if (object != NULL && object->semaphore_value < value)
        object->semaphore_value = value;
    pthread_mutex_unlock(&lock);
}

COMMAND(SignalSemaphore)
{
    sync_signal_semaphore(pSignalInfo->semaphore, pSignalInfo->value);
    sync_wake();
    return VK_SUCCESS;
}

COMMAND(GetSemaphoreCounterValue)
{
    const struct object *object = FIND(SEMAPHORE, semaphore);
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    pthread_mutex_lock(&lock);
    *pValue = object != NULL ? object->semaphore_value : 0;
    pthread_mutex_unlock(&lock);
    return VK_SUCCESS;
}

static bool semaphores_done(const void *what)
{
    const VkSemaphoreWaitInfo *wait = what;
    uint32_t reached = 0;
    for (uint32_t i = 0; i < wait->semaphoreCount; i++) {
        const struct object *semaphore = FIND(SEMAPHORE, wait->pSemaphores[i]);
        reached += semaphore == NULL || semaphore->semaphore_value >= wait->pValues[i];
    }
    return wait->flags & VK_SEMAPHORE_WAIT_ANY_BIT ? reached > 0 : reached == wait->semaphoreCount;
}

static void count_up(uint32_t count, const VkSemaphore *semaphores)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct object *semaphore = FIND(SEMAPHORE, semaphores[i]);
        if (semaphore != NULL)
            sync_signal_semaphore(semaphores[i], semaphore->semaphore_value + 1);
    }
}

COMMAND(WaitSemaphores)
{
    if (timeout > 0 && hang_progress() == NULL_DRIVER_COMPUTES)
        compute();
    if (timeout > 0 && hang_progress() == NULL_DRIVER_SIGNALS)
        count_up(pWaitInfo->semaphoreCount, pWaitInfo->pSemaphores);
    return wait_until(semaphores_done, pWaitInfo, timeout);
}

/* ---- events, as the host sees them */

static void set_event(VkEvent event, bool set)
{
    struct object *object = FIND(EVENT, event);
    if (object != NULL)
        atomic_store(&object->event_set, set);
}

COMMAND(SetEvent)
{
    set_event(event, true);
    return VK_SUCCESS;
}

COMMAND(ResetEvent)
{
    set_event(event, false);
    return VK_SUCCESS;
}

COMMAND(GetEventStatus)
{
    const struct object *object = FIND(EVENT, event);
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    return object != NULL && atomic_load(&object->event_set) ? VK_EVENT_SET : VK_EVENT_RESET;
}
