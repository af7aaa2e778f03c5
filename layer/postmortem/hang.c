/* SPDX-License-Identifier: Apache-2.0 */
/* Cuts waits into slices. */
#include "layer/postmortem/hang.h"

#include "layer/execution/input_checks.h"
#include "layer/execution/submitted_builds.h"
#include "layer/postmortem/marked_inputs.h"
#include "layer/postmortem/pending_list.h"
#include "layer/snapshots/snapshots.h"
#include "src/platform/clock.h"
#include "src/report/message.h"

#define SECOND UINT64_C(1000000000)

enum { SLICES = 4 }; /* of hang_seconds: how often progress is looked for */

struct watch {
    struct layer_device *device;
    uint64_t hang;     /* nanoseconds */
    uint64_t since;    /* when progress was seen last */
    uint64_t progress; /* see submitted_builds_progress() */
};

/* Returns how long the device may make no progress, in nanoseconds, or 0 if that is not limited. */
static uint64_t find_limit(const struct layer_device *device)
{
    if (!device->input_checks || device->snapshots->are_for_backend ||
        atomic_load(&device->hang_reported))
        return 0;
    return reporter_settings(device->instance->reporter)->hang_seconds * SECOND;
}

/* Returns false if there is nothing to watch. */
static bool begin(struct layer_device *device, struct watch *watch)
{
    uint64_t limit = find_limit(device);
    if (!limit || !submitted_builds_are_pending(device->submitted_builds))
        return false;
    *watch = (struct watch){.device = device,
                            .hang = limit,
                            .since = clock_monotonic(),
                            .progress = submitted_builds_progress(device->submitted_builds)};
    return true;
}

static void report(const struct watch *watch)
{
    struct layer_device *device = watch->device;
    char line[MESSAGE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, "The device has made no progress for ");
    text_append_count(&text, watch->hang / SECOND, "second");
    text_append(&text, ", while the application waits for it. ");
    if (!pending_list_append(device, true, &text) || atomic_exchange(&device->hang_reported, true))
        return;
    marked_inputs_read(device, "read while the device made no progress");
    reporter_report_event(device->instance->reporter, "ASSAY-hang", line);
}

/* Called when a slice has passed. Returns false if nothing is left to watch. */
static bool look(struct watch *watch)
{
    uint64_t progress = submitted_builds_progress(watch->device->submitted_builds);
    if (progress != watch->progress) {
        watch->progress = progress;
        watch->since = clock_monotonic();
    } else if (clock_monotonic() - watch->since >= watch->hang) {
        report(watch);
    }
    return !atomic_load(&watch->device->hang_reported);
}

/* ---- waits with a timeout */

struct wait {
    struct layer_device *device;
    VkResult (*wait)(const struct wait *wait, uint64_t timeout);
    uint32_t count;
    const VkFence *fences;
    VkBool32 all;
    PFN_vkWaitSemaphores wait_semaphores;
    const VkSemaphoreWaitInfo *info;
};

/* Whether the wait has an end: a later one cannot be told from none. */
static bool has_end(uint64_t begin, uint64_t timeout)
{
    return timeout < UINT64_MAX - begin;
}

static VkResult wait_in_slices(const struct wait *wait, uint64_t timeout)
{
    struct watch watch;
    if (timeout <= find_limit(wait->device) / SLICES || !begin(wait->device, &watch))
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
        result = wait->wait(wait, slice);
        if (result == VK_TIMEOUT)
            watches = look(&watch);
    }
    return result;
}

static VkResult wait_for_fences(const struct wait *wait, uint64_t timeout)
{
    return wait->device->vk.WaitForFences(wait->device->handle, wait->count, wait->fences,
                                          wait->all, timeout);
}

VkResult hang_wait_for_fences(struct layer_device *device, uint32_t count, const VkFence *fences,
                              VkBool32 all, uint64_t timeout)
{
    const struct wait wait = {
        .device = device, .wait = wait_for_fences, .count = count, .fences = fences, .all = all};
    return wait_in_slices(&wait, timeout);
}

static VkResult wait_semaphores(const struct wait *wait, uint64_t timeout)
{
    return wait->wait_semaphores(wait->device->handle, wait->info, timeout);
}

VkResult hang_wait_semaphores(struct layer_device *device, PFN_vkWaitSemaphores next,
                              const VkSemaphoreWaitInfo *info, uint64_t timeout)
{
    const struct wait wait = {
        .device = device, .wait = wait_semaphores, .wait_semaphores = next, .info = info};
    return wait_in_slices(&wait, timeout);
}

/* ---- waits for idle */

void hang_wait_before_idle(struct layer_device *device, VkQueue queue)
{
    struct watch watch;
    uint64_t last = 0;
    bool watches = begin(device, &watch);
    while (watches) {
        struct ticket *ticket = input_checks_next_ticket(device->input_checks, queue, last);
        if (!ticket)
            return;
        VkResult result = VK_TIMEOUT;
        while (watches && result == VK_TIMEOUT) {
            result = ticket->wait(ticket, watch.hang / SLICES);
            watches = result != VK_TIMEOUT || look(&watch);
        }
        last = ticket->number;
        ticket_release(ticket);
    }
}
