/* SPDX-License-Identifier: Apache-2.0 */
/* Deferred operations of one device of backend cpu ("Deferred Host Operations"): work in parts, for
 * the threads that join. */
#ifndef ASSAY_CPU_DEFERRED_H
#define ASSAY_CPU_DEFERRED_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* `run` is called once for each part, from any threads at once; the first result that is not
 * VK_SUCCESS is the operation's. `help`, where it isn't NULL, is called by threads that find no
 * part left: it takes part in those that run, as long as there is something to do, and returns at
 * once when `finish` has been called, after the last part. `release` is called last, once, when no
 * thread is in the work any more. */
struct cpu_work {
    uint32_t part_count;
    uint32_t concurrency; /* threads that are of use at first, at least 1 */
    VkResult (*run)(void *context, uint32_t part);
    void (*help)(void *context);
    void (*finish)(void *context);
    void (*release)(void *context);
    void *context;
};

/* Does all of it on this thread, and releases it. */
VkResult cpu_work_do(const struct cpu_work *work);

/* The lock of the table of operations is held for look-ups alone; that of the work is never held
 * while a part runs. */
struct cpu_deferred_operations;

VkResult cpu_deferred_operations_create(struct cpu_deferred_operations **operations);
void cpu_deferred_operations_destroy(struct cpu_deferred_operations *operations); /* or NULL */

VkResult cpu_deferred_add(struct cpu_deferred_operations *operations, uint64_t *handle);
/* Work that isn't complete stays undone, save for parts that run. */
void cpu_deferred_remove(struct cpu_deferred_operations *operations, uint64_t handle);

/* VK_OPERATION_DEFERRED_KHR; after an error the work is released. */
VkResult cpu_deferred_start(struct cpu_deferred_operations *operations, uint64_t handle,
                            const struct cpu_work *work);

/* vkDeferredOperationJoinKHR, vkGetDeferredOperationResultKHR and
 * vkGetDeferredOperationMaxConcurrencyKHR; VK_ERROR_VALIDATION_FAILED and 0 for what is no
 * operation. */
VkResult cpu_deferred_join(struct cpu_deferred_operations *operations, uint64_t handle);
VkResult cpu_deferred_result(struct cpu_deferred_operations *operations, uint64_t handle);
uint32_t cpu_deferred_concurrency(struct cpu_deferred_operations *operations, uint64_t handle);

#endif
