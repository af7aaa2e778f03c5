/* SPDX-License-Identifier: Apache-2.0 */
/* The command pools and command buffers of one device: what each is recording and inside what.
 *
 * The table has a lock of its own; a record is not locked, since the application synchronizes
 * access to a command buffer and its pool. A found record stays good until the application frees
 * it. */
#ifndef ASSAY_STATE_COMMANDS_COMMAND_BUFFERS_H
#define ASSAY_STATE_COMMANDS_COMMAND_BUFFERS_H

#include <stdbool.h>
#include <vulkan/vulkan_core.h>

#include "src/state/builds/build_states.h"
#include "src/state/builds/previous_shape.h"
#include "src/state/commands/journal.h"
#include "src/state/commands/object_names.h"
#include "src/state/commands/validity.h"
#include "src/state/facts.h"

struct command_buffers;

struct command_pool {
    VkCommandPool handle;
    VkQueueFlags queue_flags; /* of its family; 0: not known */
    bool is_protected;
    struct command_buffer *first; /* of its command buffers */
};

/* Its memory is that of a record for as long as there is the table, since look-ups without a lock
 * may come upon that of another command buffer, of which they read the handle: null while the
 * record is unused. */
struct command_buffer {
    VkCommandBuffer _Atomic handle; /* first */
    struct command_pool *pool;
    struct command_buffer *previous, *next; /* in the pool */
    VkCommandBufferLevel level;
    /* What rules may see while it is recording. `suspended` is UNKNOWN until the first rendering: a
     * command buffer before may have suspended one. */
    struct command_buffer_facts facts;
    bool suspending;           /* the rendering instance in progress will be suspended */
    struct validity *validity; /* of a recording that executes secondaries; else NULL */
    struct dependents dependents;
    struct journal *journal; /* NULL: never recorded, or no memory for it */
    /* What the journal alone tells of structures; made when first asked for. */
    struct build_states known;
    bool has_known_states;
    bool
        work_failed; /* for lack of memory: what a backend should carry out isn't all in the journal
                      */
    bool executes_once;       /* VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT */
    bool inherits_conditions; /* where a secondary executes, queries or conditional rendering may be
                                 active */
    struct label_stack labels;
    struct previous_shape previous_shape;
};

VkResult command_buffers_create(struct command_buffers **command_buffers);
void command_buffers_destroy(struct command_buffers *command_buffers);

void command_buffers_add_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                              VkQueueFlags queue_flags, bool is_protected);
/* Tells `gone` of each command buffer that goes with it. */
void command_buffers_remove_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                 void (*gone)(void *user, VkCommandBuffer handle), void *user);
void command_buffers_reset_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                bool releases);

void command_buffers_add(struct command_buffers *command_buffers, VkCommandPool pool,
                         VkCommandBufferLevel level, uint32_t count,
                         const VkCommandBuffer *handles);
void command_buffers_remove(struct command_buffers *command_buffers, uint32_t count,
                            const VkCommandBuffer *handles);

/* NULL if it isn't known. */
struct command_buffer *command_buffers_find(struct command_buffers *command_buffers,
                                            VkCommandBuffer handle);

/* Whether a record was lost for lack of memory, so that a valid handle may be unknown. */
bool command_buffers_incomplete(struct command_buffers *command_buffers);

/* What rules may see; for a handle without record alive is NO, or UNKNOWN where one was lost. */
void command_buffers_facts(struct command_buffers *command_buffers,
                           const struct command_buffer *command_buffer, VkCommandBuffer handle,
                           struct command_buffer_facts *facts);

/* The command buffer's label stack, or NULL. */
struct label_stack *command_buffers_labels(struct command_buffers *command_buffers,
                                           VkCommandBuffer handle);

/* What commands do to a command buffer. All accept NULL. */
void command_buffer_begin(struct command_buffer *command_buffer,
                          const VkCommandBufferBeginInfo *begin_info, uint64_t destroy_count,
                          VkResult result);
void command_buffer_end(struct command_buffer *command_buffer, VkResult result);
/* `releases`: what it kept for the next recording is freed, too. */
void command_buffer_reset(struct command_buffer *command_buffer, bool releases, VkResult result);
void command_buffer_begin_rendering(struct command_buffer *command_buffer, VkRenderingFlags flags);
void command_buffer_end_rendering(struct command_buffer *command_buffer);
void command_buffer_set_video_coding(struct command_buffer *command_buffer, bool inside);
void command_buffer_execute(struct command_buffer *primary, struct command_buffer *secondary);

#endif
