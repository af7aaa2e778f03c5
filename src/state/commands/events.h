/* SPDX-License-Identifier: Apache-2.0 */
/* The events (VkEvent) of one device, as far as it matters who ends a wait for one. The host may
 * set an event after the submission of what waits for it, and what it does before that comes before
 * whatever is behind the wait. Not so where the wait certainly finds the event set: by the host
 * before the submission, or by the same queue earlier. It has its own lock. */
#ifndef ASSAY_STATE_COMMANDS_EVENTS_H
#define ASSAY_STATE_COMMANDS_EVENTS_H

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

struct events;
struct journal;

VkResult events_create(struct events **events);
void events_destroy(struct events *events);

/* An event that can't be kept for lack of memory is one that the host may have to set. */
void events_add(struct events *events, VkEvent handle, bool device_only);
void events_remove(struct events *events, VkEvent handle);

/* By the host: after the call, and before it. */
void events_set(struct events *events, VkEvent handle);
void events_reset(struct events *events, VkEvent handle);

/* What a command buffer waits for that is being recorded: whether that may be up to the host, as
 * far as the command buffer and the event's kind tell. */
bool events_may_be_open(struct events *events, VkEvent handle, const struct journal *journal);

/* A command buffer is about to be submitted, behind all that the queue was given before. Returns
 * whether it may have to wait for the host. */
bool events_submit(struct events *events, VkQueue queue, const struct journal *journal);
/* A submission has failed: what it was to set isn't. */
void events_forget(struct events *events);

#endif
