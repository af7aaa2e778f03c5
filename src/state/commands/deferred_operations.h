/* SPDX-License-Identifier: Apache-2.0 */
/* The deferred operations of one device, and the host work that each executes.
 *
 * A deferred command takes effect when its operation is complete. Any thread may be the first to
 * observe that, by joining the operation or getting its result. The table calls `end` under its
 * lock, so the work has ended for every thread that has observed the completion. */
#ifndef ASSAY_STATE_COMMANDS_DEFERRED_OPERATIONS_H
#define ASSAY_STATE_COMMANDS_DEFERRED_OPERATIONS_H

#include <vulkan/vulkan_core.h>

#include "src/state/facts.h"

struct deferred_operations;

/* `end` takes over the work of an operation that has completed with `result`; VK_ERROR_UNKNOWN if
 * the result is unknown. It must not call these functions. */
VkResult deferred_operations_create(struct deferred_operations **operations,
                                    void (*end)(void *work, VkResult result));
/* Ends all work. */
void deferred_operations_destroy(struct deferred_operations *operations);

void deferred_operations_add(struct deferred_operations *operations, VkDeferredOperationKHR handle);
/* Ends the operation's work. */
void deferred_operations_remove(struct deferred_operations *operations,
                                VkDeferredOperationKHR handle);

/* Returns UNKNOWN if the operation is not in the table, but memory has run out for some. */
enum tristate deferred_operations_has(struct deferred_operations *operations,
                                      VkDeferredOperationKHR handle);

/* Call if a command was deferred: the operation takes over `work`, and ends its previous work.
 * Returns false if the operation is unknown; the caller keeps `work` then. */
bool deferred_operations_defer(struct deferred_operations *operations,
                               VkDeferredOperationKHR handle, void *work);

/* Notes that something was reported about the command whose work the operation has, and returns
 * whether that was done. */
void deferred_operations_note_report(struct deferred_operations *operations,
                                     VkDeferredOperationKHR handle);
bool deferred_operations_has_report(struct deferred_operations *operations,
                                    VkDeferredOperationKHR handle);

/* Returns the unique number of the operation's current work; 0: none. */
uint64_t deferred_operations_ticket(struct deferred_operations *operations,
                                    VkDeferredOperationKHR handle);
/* Call if the operation has completed: ends the work with this ticket. Returns false, and does
 * nothing, if the operation no longer has it. */
bool deferred_operations_complete(struct deferred_operations *operations,
                                  VkDeferredOperationKHR handle, uint64_t ticket, VkResult result);

#endif
