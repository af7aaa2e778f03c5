/* SPDX-License-Identifier: Apache-2.0 */
/* The deferred operations of one device of backend cpu (Vulkan specification, Deferred Host
 * Operations). Their work is split into parts, which the joining threads execute. */
#ifndef ASSAY_CPU_DEFERRED_H
#define ASSAY_CPU_DEFERRED_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* Work of a deferred operation.
 *
 * `run` is called once for each part, on several threads at the same time. The first result that is
 * not VK_SUCCESS is the operation's result. `help` (may be NULL) is called by threads that find no
 * part left: it helps the running parts while they have something to do. `finish` (may be NULL) is
 * called after the last part; from then on `help` returns at once. `release` is called once, at the
 * end, when no thread is in the work. */
struct cpu_work {
    uint32_t part_count;
    uint32_t concurrency; /* number of threads that can help at the start, at least 1 */
    VkResult (*run)(void *context, uint32_t part);
    void (*help)(void *context);
    void (*finish)(void *context);
    void (*release)(void *context);
    void *context;
};

/* Does all the work on this thread, and releases it. */
VkResult cpu_work_do(const struct cpu_work *work);

/* The lock of the table is only held for look-ups. The lock of a job is released while a part runs.
 */
struct cpu_deferred_operations;

VkResult cpu_deferred_operations_create(struct cpu_deferred_operations **operations);
void cpu_deferred_operations_destroy(struct cpu_deferred_operations *operations); /* or NULL */

VkResult cpu_deferred_add(struct cpu_deferred_operations *operations, uint64_t *handle);
/* Parts that have not started never run. */
void cpu_deferred_remove(struct cpu_deferred_operations *operations, uint64_t handle);

/* Takes over the work. Returns VK_OPERATION_DEFERRED_KHR, or an error; then the work is released.
 */
VkResult cpu_deferred_start(struct cpu_deferred_operations *operations, uint64_t handle,
                            const struct cpu_work *work);

/* vkDeferredOperationJoinKHR, vkGetDeferredOperationResultKHR and
 * vkGetDeferredOperationMaxConcurrencyKHR. For an unknown handle they return
 * VK_ERROR_VALIDATION_FAILED, VK_ERROR_VALIDATION_FAILED and 0. */
VkResult cpu_deferred_join(struct cpu_deferred_operations *operations, uint64_t handle);
VkResult cpu_deferred_result(struct cpu_deferred_operations *operations, uint64_t handle);
uint32_t cpu_deferred_concurrency(struct cpu_deferred_operations *operations, uint64_t handle);

#endif
