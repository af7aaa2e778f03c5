/* SPDX-License-Identifier: Apache-2.0 */
/* The events (VkEvent) of one device, and whether a wait for an event may have to wait for the
 * host.
 *
 * The host may set an event after the submission that waits for the event. Then all that the host
 * did before that executes before the commands after the wait. This is impossible if the event is
 * certainly set when the wait executes: by the host before the submission, or by an earlier command
 * of the same queue. The table has its own lock. */
#ifndef ASSAY_STATE_COMMANDS_EVENTS_H
#define ASSAY_STATE_COMMANDS_EVENTS_H

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

struct events;
struct journal;

VkResult events_create(struct events **events);
void events_destroy(struct events *events);

/* If memory runs out, the event counts as one that the host may have to set. */
void events_add(struct events *events, VkEvent handle, bool device_only);
void events_remove(struct events *events, VkEvent handle);

/* For vkSetEvent, after the call; and for vkResetEvent, before the call. */
void events_set(struct events *events, VkEvent handle);
void events_reset(struct events *events, VkEvent handle);
/* Whether the host has set the event, and no command that was submitted since sets or resets it. */
bool events_is_set_by_host(struct events *events, VkEvent handle);

/* Whether a wait that is being recorded may have to wait for the host. Uses only the command
 * buffer's journal and the event's flags. */
bool events_may_be_open(struct events *events, VkEvent handle, const struct journal *journal);

/* Call before a command buffer is submitted, in the order of the queue's submissions. Returns
 * whether the command buffer may have to wait for the host. */
bool events_submit(struct events *events, VkQueue queue, const struct journal *journal);
/* Call if a submission has failed: no event counts as set any more. */
void events_forget(struct events *events);

#endif
