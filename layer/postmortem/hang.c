/* SPDX-License-Identifier: Apache-2.0 */
/* Cuts waits into slices. */
#include "layer/postmortem/postmortem.h"

#include "layer/execution/input_checks.h"
#include "layer/execution/submitted_builds.h"
#include "layer/snapshots/snapshots.h"
#include "src/platform/clock.h"
#include "src/report/message.h"
#include "src/report/words.h"

#define SECOND UINT64_C(1000000000)

enum {
    SLICES = 4, /* of hang_seconds: how often progress is looked for */
    /* A driver on the processor that has used one part of hang_seconds makes progress. It uses more
     * even on a very busy machine; threads that wait use less. */
    PROCESSOR_PARTS = 500,
};

struct watch {
    struct layer_device *device;
    const struct wait *wait; /* NULL: for idle */
    uint64_t hang;           /* nanoseconds */
    uint64_t since;          /* when progress was seen last */
    uint64_t progress;       /* see find_progress(); 0 in the first slice */
    uint64_t slice_cpu;      /* clock_process_cpu() when the slice began */
    uint64_t cpu_since;      /* processor time of the slices since progress was seen last */
};

/* A wait with a timeout. */
struct wait {
    struct layer_device *device;
    VkResult (*wait)(const struct wait *wait, uint64_t timeout);
    uint64_t (*find_progress)(const struct wait *wait);
    uint32_t count;
    const VkFence *fences;
    VkBool32 all;
    PFN_vkWaitSemaphores wait_semaphores;
    const VkSemaphoreWaitInfo *info;
};

/* ---- progress */

/* The number of executions whose own fences are signaled. */
static uint64_t count_complete(const struct layer_device *device)
{
    uint64_t count = 0, last = 0;
    struct ticket *ticket;
    while ((ticket = input_checks_next_ticket(device->input_checks, VK_NULL_HANDLE, last))) {
        count += ticket->wait(ticket, 0) == VK_SUCCESS;
        last = ticket->number;
        ticket_release(ticket);
    }
    return count;
}

/* A number that changes when the device gets further: with the marks, the layer's own fences, what
 * any thread of the application has observed, and what this one waits for. */
static uint64_t find_progress(const struct watch *watch)
{
    const struct layer_device *device = watch->device;
    struct execution_clock seen;
    uint64_t sum = submitted_builds_progress(device->submitted_builds);
    sum = sum * 31 + count_complete(device);
    execution_order_host_clock(device->order, &seen);
    for (uint32_t i = EXECUTION_HOST + 1; i < seen.queues; i++)
        sum = sum * 31 + seen.counts[i];
    return watch->wait ? sum * 31 + watch->wait->find_progress(watch->wait) : sum;
}

/* Returns how long the device may make no progress, in nanoseconds, or 0 if that is not limited. */
static uint64_t find_limit(const struct layer_device *device)
{
    if (!device->input_checks || device->snapshots->are_for_backend ||
        atomic_load(&device->hang_reported))
        return 0;
    return reporter_settings(device->instance->reporter)->hang_seconds * SECOND;
}

/* Returns false if there is nothing to watch. Most waits are shorter than a slice, so progress is
 * measured first at the end of one. */
static bool begin_watch(struct layer_device *device, const struct wait *wait, struct watch *watch)
{
    uint64_t limit = find_limit(device);
    if (!limit || !submitted_builds_are_pending(device->submitted_builds))
        return false;
    *watch =
        (struct watch){.device = device, .wait = wait, .hang = limit, .since = clock_monotonic()};
    return true;
}

static void report_hang(const struct watch *watch)
{
    struct layer_device *device = watch->device;
    char line[MESSAGE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_say(&text, "The device has made no progress for {}, while the application waits for it. ",
             count_of(watch->hang / SECOND, "second"));
    if (!submitted_builds_are_pending(device->submitted_builds) ||
        atomic_exchange(&device->hang_reported, true))
        return;
    input_checks_read_marked(device->input_checks, "read while the device made no progress");
    if (!pending_list_append(device, true, NULL, &text)) {
        atomic_store(&device->hang_reported, false); /* it went on meanwhile */
        return;
    }
    reporter_report_event(device->instance->reporter, "ASSAY-hang", line);
}

static void begin_slice(struct watch *watch)
{
    watch->slice_cpu = clock_process_cpu();
}

/* A driver on the processor makes progress while its threads run, for example when it compiles.
 * Called when a slice has passed. */
static bool has_run(struct watch *watch)
{
    watch->cpu_since += clock_process_cpu() - watch->slice_cpu;
    return watch->device->is_on_processor && watch->cpu_since >= watch->hang / PROCESSOR_PARTS;
}

/* Called when a slice has passed. Returns false if nothing is left to watch. */
static bool look_for_progress(struct watch *watch)
{
    bool has_progress = has_run(watch);
    uint64_t progress = find_progress(watch);
    if (has_progress || progress != watch->progress) {
        watch->progress = progress;
        watch->since = clock_monotonic();
        watch->cpu_since = 0;
    } else if (clock_monotonic() - watch->since >= watch->hang) {
        report_hang(watch);
    }
    return !atomic_load(&watch->device->hang_reported);
}

/* ---- waits in slices */

/* Whether the wait has an end: one that is too late is the same as none. */
static bool has_end(uint64_t begin, uint64_t timeout)
{
    return timeout < UINT64_MAX - begin;
}

static VkResult wait_in_slices(const struct wait *wait, uint64_t timeout)
{
    struct watch watch;
    if (timeout <= find_limit(wait->device) / SLICES || !begin_watch(wait->device, wait, &watch))
        return wait->wait(wait, timeout);
    const uint64_t begun = clock_monotonic(), slice = watch.hang / SLICES;
    VkResult result = VK_TIMEOUT;
    bool watches = true;
    while (result == VK_TIMEOUT) {
        uint64_t passed = clock_monotonic() - begun;
        uint64_t left = !has_end(begun, timeout) ? timeout
                        : passed < timeout       ? timeout - passed
                                                 : 0;
        if (!watches || left <= slice)
            return wait->wait(wait, left);
        begin_slice(&watch);
        result = wait->wait(wait, slice);
        if (result == VK_TIMEOUT)
            watches = look_for_progress(&watch);
    }
    return result;
}

static VkResult wait_for_fences(const struct wait *wait, uint64_t timeout)
{
    return wait->device->vk.WaitForFences(wait->device->handle, wait->count, wait->fences,
                                          wait->all, timeout);
}

/* Fences of which one is enough are all unsignaled while the wait goes on. */
static uint64_t count_signaled(const struct wait *wait)
{
    uint64_t count = 0;
    for (uint32_t i = 0; wait->all && wait->count > 1 && i < wait->count; i++)
        count +=
            wait->device->vk.GetFenceStatus(wait->device->handle, wait->fences[i]) == VK_SUCCESS;
    return count;
}

VkResult hang_wait_for_fences(struct layer_device *device, uint32_t count, const VkFence *fences,
                              VkBool32 all, uint64_t timeout)
{
    const struct wait wait = {.device = device,
                              .wait = wait_for_fences,
                              .find_progress = count_signaled,
                              .count = count,
                              .fences = fences,
                              .all = all};
    return wait_in_slices(&wait, timeout);
}

static VkResult wait_semaphores(const struct wait *wait, uint64_t timeout)
{
    return wait->wait_semaphores(wait->device->handle, wait->info, timeout);
}

static uint64_t add_values(const struct wait *wait)
{
    const VkuDeviceDispatchTable *vk = &wait->device->vk;
    PFN_vkGetSemaphoreCounterValue get = wait->wait_semaphores == vk->WaitSemaphoresKHR
                                             ? vk->GetSemaphoreCounterValueKHR
                                             : vk->GetSemaphoreCounterValue;
    uint64_t sum = 0, value;
    for (uint32_t i = 0; get && i < wait->info->semaphoreCount; i++)
        if (get(wait->device->handle, wait->info->pSemaphores[i], &value) == VK_SUCCESS)
            sum = sum * 31 + value;
    return sum;
}

VkResult hang_wait_semaphores(struct layer_device *device, PFN_vkWaitSemaphores next,
                              const VkSemaphoreWaitInfo *info, uint64_t timeout)
{
    const struct wait wait = {.device = device,
                              .wait = wait_semaphores,
                              .find_progress = add_values,
                              .wait_semaphores = next,
                              .info = info};
    return wait_in_slices(&wait, timeout);
}

/* ---- waits for idle */

void hang_wait_before_idle(struct layer_device *device, VkQueue queue)
{
    struct watch watch;
    uint64_t last = 0;
    bool watches = begin_watch(device, NULL, &watch);
    while (watches) {
        struct ticket *ticket = input_checks_next_ticket(device->input_checks, queue, last);
        if (!ticket)
            return;
        VkResult result = VK_TIMEOUT;
        while (watches && result == VK_TIMEOUT) {
            begin_slice(&watch);
            result = ticket->wait(ticket, watch.hang / SLICES);
            watches = result != VK_TIMEOUT || look_for_progress(&watch);
        }
        last = ticket->number;
        ticket_release(ticket);
    }
}
