/* SPDX-License-Identifier: Apache-2.0 */
/* Tracks recordings of primary command buffers that become invalid because a secondary command
 * buffer that they execute is recorded again, reset or freed.
 *
 * The secondary marks the recordings that depend on it. So the check at each build is one atomic
 * load, however many secondaries the primary executes. The list of each secondary has its own lock;
 * all else is atomic. */
#ifndef ASSAY_STATE_COMMANDS_COMMAND_BUFFERS_H
#define ASSAY_STATE_COMMANDS_COMMAND_BUFFERS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/platform/threads.h"
#include "src/state/builds/structures.h"
#include "src/state/commands/journal.h"
#include "src/state/commands/object_names.h"
#include "src/state/facts.h"

/* The validity of one recording. The recording and the secondaries that it executes share it. */
struct validity {
    atomic_uint references;
    atomic_bool invalidated;
};

struct validity *validity_create(void); /* with one reference; NULL if memory runs out */
void validity_release(struct validity *validity);

/* The recordings that depend on a command buffer. */
struct dependents {
    pthread_mutex_t lock; /* guards the rest, but `count` may be read without it */
    struct validity **items;
    atomic_uint count;
    uint32_t capacity;
};

/* If memory runs out, `validity` will not be invalidated. */
void dependents_add(struct dependents *dependents, struct validity *validity);
void dependents_invalidate(struct dependents *dependents);

/* ---- The command pools and command buffers of one device, and the recording state of each.
 *
 * The table has its own lock. A record has none, because the application synchronizes access to a
 * command buffer and its pool. A found record is valid until the application frees the command
 * buffer. */

struct command_buffers;

struct command_pool {
    VkCommandPool handle;
    uint32_t queue_family;
    VkQueueFlags queue_flags; /* of the queue family; 0: unknown */
    bool is_protected;
    struct command_buffer *first; /* list of its command buffers */
};

/* A record is freed only with its table, because a look-up without the lock may read the handle of
 * a retired record. The handle of a retired record is VK_NULL_HANDLE. */
struct command_buffer {
    VkCommandBuffer _Atomic handle; /* first member: take_record() clears all but this */
    struct command_pool *pool;
    struct command_buffer *previous, *next; /* in the pool */
    VkCommandBufferLevel level;
    /* `suspended` is UNKNOWN until the first rendering, because an earlier command buffer may have
     * suspended a rendering instance. */
    struct command_buffer_facts facts;
    uint64_t render_pass; /* the handle in the last vkCmdBeginRenderPass, with setting hazards */
    bool suspending;      /* the current rendering instance will be suspended */
    struct validity *validity;    /* NULL if the recording executes no secondary command buffer */
    struct dependents dependents; /* recordings that execute this command buffer */
    struct journal *journal;      /* NULL: never recorded, or memory ran out */
    /* Bindings of this recording from before journal->work exists, as layer/snapshots has them. The
     * memory is kept for the next recording. */
    void *early_bindings;
    bool has_early_bindings;
    /* Structure states that follow from the journal alone; made on first use. */
    struct structures known;
    bool has_known_states;
    bool work_failed;      /* memory ran out: journal->work lacks some commands for the backend */
    bool executes_once;    /* VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT */
    bool executes_at_once; /* VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT */
    /* A secondary that may execute inside an active query or conditional rendering. */
    bool inherits_conditions;
    struct label_stack labels;
};

VkResult command_buffers_create(struct command_buffers **command_buffers);
void command_buffers_destroy(struct command_buffers *command_buffers);

void command_buffers_add_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                              uint32_t queue_family, VkQueueFlags queue_flags, bool is_protected);
/* Calls `removed` for each command buffer of the pool, without the lock. */
void command_buffers_remove_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                 void (*removed)(void *user, VkCommandBuffer handle), void *user);
void command_buffers_reset_pool(struct command_buffers *command_buffers, VkCommandPool handle,
                                bool releases);

void command_buffers_add(struct command_buffers *command_buffers, VkCommandPool pool,
                         VkCommandBufferLevel level, uint32_t count,
                         const VkCommandBuffer *handles);
void command_buffers_remove(struct command_buffers *command_buffers, uint32_t count,
                            const VkCommandBuffer *handles);

/* Returns NULL if the handle is unknown. */
struct command_buffer *command_buffers_find(struct command_buffers *command_buffers,
                                            VkCommandBuffer handle);

/* Whether memory ran out for a record, so that a valid handle may be unknown. */
bool command_buffers_are_unknown(struct command_buffers *command_buffers);

void command_buffers_set_unknown(struct command_buffers *command_buffers);

/* Sets `facts` for rules. For a handle without a record (`command_buffer` NULL), alive is NO, or
 * UNKNOWN if the table is incomplete. */
void command_buffers_facts(struct command_buffers *command_buffers,
                           const struct command_buffer *command_buffer, VkCommandBuffer handle,
                           struct command_buffer_facts *facts);

/* The command buffer's label stack, or NULL. */
struct label_stack *command_buffers_labels(struct command_buffers *command_buffers,
                                           VkCommandBuffer handle);

/* These update the record for a command. All accept NULL. */
void command_buffer_begin(struct command_buffer *command_buffer,
                          const VkCommandBufferBeginInfo *begin_info, uint64_t destroy_count,
                          VkResult result);
void command_buffer_end(struct command_buffer *command_buffer, VkResult result);
/* `releases`: also frees the memory that was kept for the next recording. */
void command_buffer_reset(struct command_buffer *command_buffer, bool releases, VkResult result);
void command_buffer_begin_rendering(struct command_buffer *command_buffer, VkRenderingFlags flags);
void command_buffer_end_rendering(struct command_buffer *command_buffer);
void command_buffer_set_video_coding(struct command_buffer *command_buffer, bool inside);
void command_buffer_execute(struct command_buffer *primary, struct command_buffer *secondary);

#endif
