/* SPDX-License-Identifier: Apache-2.0 */
/* What is reported when the device is lost or hangs, or the process crashes (docs/postmortem.md).
 */
#ifndef ASSAY_LAYER_POSTMORTEM_POSTMORTEM_H
#define ASSAY_LAYER_POSTMORTEM_POSTMORTEM_H

#include "layer/layer.h"
#include "src/base/text_buffer.h"

/* ---- a lost device */

/* Called with the first VK_ERROR_DEVICE_LOST of a device, without a lock: validates the inputs that
 * had been copied, lists the builds that may not be complete, and makes the execution order
 * unknown. Does nothing on later calls. */
void postmortem_report_loss(struct layer_device *device);

/* Each intercept of a command that can return VK_ERROR_DEVICE_LOST passes its result through this
 * before it returns. */
static inline VkResult postmortem_see(struct layer_device *device, VkResult result)
{
    if (__builtin_expect(result == VK_ERROR_DEVICE_LOST, false))
        postmortem_report_loss(device);
    return result;
}

/* ---- Waits of the application. The layer watches whether the device makes progress: if it makes
 * none for hang_seconds, one report lists the builds that it may be executing, and the wait goes
 * on. Results and timeouts are those of the driver. Without builds whose marks are pending, or
 * below level CONTENT, the calls go down as they are. */

VkResult hang_wait_for_fences(struct layer_device *device, uint32_t count, const VkFence *fences,
                              VkBool32 all, uint64_t timeout);
VkResult hang_wait_semaphores(struct layer_device *device, PFN_vkWaitSemaphores wait,
                              const VkSemaphoreWaitInfo *info, uint64_t timeout);

/* Called before a wait for idle, which cannot be cut into slices: waits until the executions of a
 * queue, or of all queues if it is VK_NULL_HANDLE, are complete or the device is lost. The layer
 * waits for its own fences, so no queue is used. */
void hang_wait_before_idle(struct layer_device *device, VkQueue queue);

/* ---- Setting crash_report: the report when the process gets SIGSEGV, SIGBUS, SIGFPE or SIGABRT.
 *
 * The first device with the setting (16 at most) installs the handlers, and the last one puts the
 * application's back. A handler that the application has installed meanwhile stays; the layer's
 * library then stays in memory, because that handler may call the layer's.
 *
 * The handler itself neither allocates nor waits for a lock: it lists the builds that the device
 * may be executing. The inputs that had been copied are validated by a thread that waits for this;
 * the handler gives it a few seconds, because the thread may need a lock that the crash left taken.
 */

/* Called when a device was created, and before it is destroyed. Do nothing if the instance has not
 * set crash_report, or below level EXECUTION. */
void crash_add_device(struct layer_device *device);
void crash_remove_device(struct layer_device *device);

/* ---- The list of the builds that the device may be executing, as words. */

enum { PENDING_LISTED = 20 };

/* Device addresses that the device or the process accessed without right. */
enum { FAULTS_MAX = 8 };
struct pending_faults {
    struct {
        uint64_t begin, end;
        uint64_t structure; /* the handle of the one there, or 0 */
    } ranges[FAULTS_MAX];   /* with empty ones */
};

/* Appends "1 build was submitted ..." and the builds, PENDING_LISTED at most, the likeliest culprit
 * first: builds with findings about their inputs; builds whose structures or inputs contain a
 * faulting address; builds whose inputs had been copied and that had not finished, in the order of
 * submission; then those of unknown progress, those that the device had not reached, and those that
 * had finished. If their progress is the same, it says that they are in the order of submission.
 * Returns their number; appends nothing if there are none.
 *
 * Unless `waits`, this neither allocates nor waits for a lock, so a signal handler may call it. It
 * then returns 0 if another thread uses the list; names and sizes are missing if it cannot get
 * them. Not for two threads at once. `faults`: NULL if none are known. */
uint32_t pending_list_append(const struct layer_device *device, bool waits,
                             const struct pending_faults *faults, struct text_buffer *text);

#endif
