/* SPDX-License-Identifier: Apache-2.0 */
/* A planned loss of the device, hang or crash. While the device hangs, submissions are kept; the
 * end of the hang executes them, the one that hung from its beginning. */
#include "internal.h"

#include <signal.h>
#include <stdlib.h>

/* A call that submits work, in the form of vkQueueSubmit2 without waits. */
struct kept_submission {
    struct kept_submission *next;
    VkCommandBuffer *commands;
    VkSemaphoreSubmitInfo *signals;
    uint32_t command_count, signal_count;
    VkFence fence;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of all below */
static struct null_driver_fault planned;                 /* number 0: nothing is planned */
static struct null_driver_fault last;                    /* that happened */
static struct kept_submission *kept, **kept_last = &kept;
static atomic_bool is_armed, hangs, is_at_once;

void null_driver_plan_fault(const struct null_driver_fault *fault)
{
    pthread_mutex_lock(&lock);
    planned = fault != NULL ? *fault : (struct null_driver_fault){0};
    if (fault != NULL && planned.number == 0)
        planned.number = 1;
    atomic_store(&is_armed, fault != NULL);
    atomic_store(&is_at_once, false);
    pthread_mutex_unlock(&lock);
}

bool fault_is_at_build(void)
{
    return atomic_load(&is_armed);
}

bool loss_is_at_once(void)
{
    return device_is_lost() && atomic_load(&is_at_once);
}

bool device_hangs(void)
{
    return atomic_load(&hangs);
}

enum null_driver_progress hang_progress(void)
{
    pthread_mutex_lock(&lock);
    const enum null_driver_progress progress = last.progress;
    pthread_mutex_unlock(&lock);
    return device_hangs() ? progress : NULL_DRIVER_STANDS;
}

/* ---- what happens */

static void write_to_nowhere(void)
{
    volatile uintptr_t nowhere = 16; /* compilers warn of an address that they know */
    *(volatile int *)nowhere = 0;    // NOLINT
}

static void *crash(void *number)
{
    if ((intptr_t)number == SIGSEGV)
        write_to_nowhere();
    else
        raise((int)(intptr_t)number);
    return NULL;
}

static void crash_as_planned(const struct null_driver_fault *fault)
{
    void *number = (void *)(intptr_t)(fault->signal != 0 ? fault->signal : SIGSEGV);
    pthread_t thread;
    if (!fault->in_thread || pthread_create(&thread, NULL, crash, number) != 0)
        crash(number);
    else
        pthread_join(thread, NULL);
}

static void happen(const struct null_driver_fault *fault)
{
    if (fault->kind == NULL_DRIVER_LOSE) {
        atomic_store(&is_at_once, fault->is_at_once);
        null_driver_set_device_lost(true);
    }
    if (fault->kind == NULL_DRIVER_HANG)
        atomic_store(&hangs, true);
    if (fault->kind == NULL_DRIVER_CRASH)
        crash_as_planned(fault);
}

/* Whether it happens the next time; `skips_copies` as planned, for AT_BUILD. */
static bool is_next(enum null_driver_place at, bool skips_copies)
{
    return planned.number == 1 && planned.at == at && planned.skips_copies == skips_copies;
}

static bool pass(enum null_driver_place at)
{
    if (!atomic_load(&is_armed))
        return false;
    pthread_mutex_lock(&lock);
    const struct null_driver_fault fault = planned;
    const bool is_here = fault.number != 0 && fault.at == at;
    const bool happens = is_here && fault.number == 1;
    if (happens)
        last = fault;
    if (is_here && --planned.number == 0)
        atomic_store(&is_armed, false);
    pthread_mutex_unlock(&lock);
    if (happens)
        happen(&fault);
    return happens;
}

bool fault_at_submit(void)
{
    return pass(NULL_DRIVER_AT_SUBMIT);
}

void fault_at_wait(uint64_t timeout)
{
    if (timeout != 0)
        pass(NULL_DRIVER_AT_WAIT);
}

bool fault_at_build(void)
{
    return pass(NULL_DRIVER_AT_BUILD);
}

bool fault_before_copies(void)
{
    if (!atomic_load(&is_armed))
        return false;
    pthread_mutex_lock(&lock);
    const bool happens = is_next(NULL_DRIVER_AT_BUILD, true);
    pthread_mutex_unlock(&lock);
    return happens && pass(NULL_DRIVER_AT_BUILD);
}

/* ---- submissions during a hang */

static void *copy_of(const void *items, size_t size)
{
    void *copy = driver_allocate(NULL, size + 1);
    if (copy != NULL && size > 0)
        memcpy(copy, items, size);
    return copy;
}

void fault_keep(const VkSubmitInfo2 *info, const VkCommandBuffer *commands, VkFence fence)
{
    struct kept_submission *submission = driver_allocate(NULL, sizeof(*submission));
    if (submission == NULL)
        return;
    *submission = (struct kept_submission){
        .commands = copy_of(commands, info->commandBufferInfoCount * sizeof(*commands)),
        .signals = copy_of(info->pSignalSemaphoreInfos,
                           info->signalSemaphoreInfoCount * sizeof(*submission->signals)),
        .command_count = info->commandBufferInfoCount,
        .signal_count = info->signalSemaphoreInfoCount,
        .fence = fence,
    };
    pthread_mutex_lock(&lock);
    *kept_last = submission;
    kept_last = &submission->next;
    pthread_mutex_unlock(&lock);
}

static void finish_kept(struct kept_submission *submission, bool executes)
{
    for (uint32_t i = 0; executes && i < submission->command_count; i++)
        transfers_execute(submission->commands[i]);
    for (uint32_t i = 0; executes && i < submission->signal_count; i++)
        sync_signal(RAW(submission->signals[i].semaphore), VK_OBJECT_TYPE_SEMAPHORE,
                    submission->signals[i].value);
    if (executes)
        sync_signal(RAW(submission->fence), VK_OBJECT_TYPE_FENCE, 1);
    free(submission->commands);
    free(submission->signals);
    free(submission);
}

void null_driver_end_hang(void)
{
    pthread_mutex_lock(&lock);
    struct kept_submission *submission = kept, *next;
    kept = NULL;
    kept_last = &kept;
    pthread_mutex_unlock(&lock);
    for (; submission != NULL; submission = next) {
        next = submission->next;
        finish_kept(submission, !device_is_lost());
    }
    atomic_store(&hangs, false);
    sync_wake();
}

/* ---- VK_EXT_device_fault */

COMMAND(GetDeviceFaultInfoEXT)
{
    pthread_mutex_lock(&lock);
    const struct null_driver_fault fault = last;
    pthread_mutex_unlock(&lock);
    const uint32_t count = fault.address != 0;
    if (pFaultInfo != NULL && pFaultCounts->addressInfoCount >= count && count > 0) {
        strcpy(pFaultInfo->description, "a page is missing");
        pFaultInfo->pAddressInfos[0] = (VkDeviceFaultAddressInfoEXT){
            .addressType = fault.address_type,
            .reportedAddress = fault.address,
            .addressPrecision = fault.precision,
        };
    }
    pFaultCounts->addressInfoCount = count;
    return VK_SUCCESS;
}
