/* SPDX-License-Identifier: Apache-2.0 */
/* The deferred operations of one device, and the work of the host that each carries out.
 *
 * A command that was deferred has its effects when its operation is complete, which any thread may
 * be the first to learn, by joining or by asking for the result. Work is handed to `end` under the
 * lock, so that every thread which has learned of it finds it ended. */
#ifndef ASSAY_STATE_COMMANDS_DEFERRED_OPERATIONS_H
#define ASSAY_STATE_COMMANDS_DEFERRED_OPERATIONS_H

#include <vulkan/vulkan_core.h>

#include "src/state/facts.h"

struct deferred_operations;

/* `end` takes work whose operation has completed with `result`, or with VK_ERROR_UNKNOWN where it
 * isn't known how it went. It must not call back. */
VkResult deferred_operations_create(struct deferred_operations **operations,
                                    void (*end)(void *work, VkResult result));
/* Ends all work. */
void deferred_operations_destroy(struct deferred_operations *operations);

void deferred_operations_add(struct deferred_operations *operations, VkDeferredOperationKHR handle);
/* Ends its work. */
void deferred_operations_remove(struct deferred_operations *operations,
                                VkDeferredOperationKHR handle);

/* Whether there is such an operation. */
enum tristate deferred_operations_has(struct deferred_operations *operations,
                                      VkDeferredOperationKHR handle);

/* A command was deferred: the operation takes its work over, and ends what it had before. False
 * where the operation isn't known. */
bool deferred_operations_defer(struct deferred_operations *operations,
                               VkDeferredOperationKHR handle, void *work);

/* A number, never used twice, of the work that the operation has now; 0: none. */
uint64_t deferred_operations_ticket(struct deferred_operations *operations,
                                    VkDeferredOperationKHR handle);
/* The operation has completed. Nothing happens unless it still has the work of that number. Returns
 * whether it had. */
bool deferred_operations_complete(struct deferred_operations *operations,
                                  VkDeferredOperationKHR handle, uint64_t ticket, VkResult result);

#endif
