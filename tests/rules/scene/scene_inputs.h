/* SPDX-License-Identifier: Apache-2.0 */
/* How what builds read gets to where they read it. */
#ifndef ASSAY_TESTS_RULES_SCENE_INPUTS_H
#define ASSAY_TESTS_RULES_SCENE_INPUTS_H

#include <stdbool.h>

#include "tests/fixture/objects.h"

/* The route of what device builds read. Builds that come before the call are in its command buffer
 * in the cases of rules_test, which submits few of them; INPUTS_VISIBLE, _COPIED and _UPLOADED
 * submit them at once, for the data may change afterwards. */
enum input_route {
    INPUTS_IN_PLACE, /* memory that the host sees */
    INPUTS_VISIBLE,  /* likewise */
    INPUTS_INLINE,   /* device-local, by vkCmdUpdateBuffer just before each build */
    INPUTS_COPIED,   /* device-local, by vkCmdCopyBuffer just before each build */
    INPUTS_UPLOADED, /* device-local, by a submission of their own */
};

enum { SCENE_STAGED_MAX = 24, SCENE_SEMAPHORES_MAX = 32 };

struct scene;

/* A buffer that the cases write by its `bytes`. */
struct staged_input {
    VkBuffer buffer;
    VkBuffer source; /* null: inline, or `bytes` are the buffer's own memory */
    VkDeviceSize size;
    uint8_t *bytes;
    uint8_t *other; /* see scene_inputs_exchange(); NULL: its bytes stay */
};

struct scene_inputs {
    struct staged_input items[SCENE_STAGED_MAX];
    uint32_t count;
    /* What is submitted before the call, to another queue, is waited for by these. */
    VkSemaphore semaphores[SCENE_SEMAPHORES_MAX];
    uint32_t semaphore_count;
};

/* A bound buffer of inputs, by the world's route. Without `exchanged` its bytes stay at exchanges.
 */
struct device_buffer scene_input(struct scene *scene, VkDeviceSize size, VkBufferUsageFlags usage,
                                 bool exchanged);

/* Records what brings the inputs of the build that is recorded next. */
void scene_inputs_stage(struct scene *scene, VkCommandBuffer command_buffer);
/* Submits what brings the inputs of the command buffer that is submitted next. */
void scene_inputs_upload(struct scene *scene);

/* Where builds that come before the call are recorded; and their end. */
VkCommandBuffer scene_begin_before(struct scene *scene);
void scene_end_before(struct scene *scene, VkCommandBuffer command_buffer);

/* Keeps the bytes of the inputs as they are now; whether they are others since; and exchanges
 * both. */
void scene_inputs_remember(struct scene *scene);
bool scene_inputs_differ(const struct scene *scene);
void scene_inputs_exchange(struct scene *scene);

#endif
