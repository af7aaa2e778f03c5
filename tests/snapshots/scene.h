/* SPDX-License-Identifier: Apache-2.0 */
/* The device of a test program, with the layer or without it; and a compute shader by itself. What
 * fails unexpectedly ends the test. */
#ifndef ASSAY_TESTS_SNAPSHOTS_SCENE_H
#define ASSAY_TESTS_SNAPSHOTS_SCENE_H

#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"

enum { FIXTURE_BUFFERS = 16 };

extern struct platform platform; /* that unit_test_open() opens, by default the null driver */
extern struct fixture {
    struct instance_fixture instance;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    VkQueue queue;
    VkCommandPool pool;
    uint32_t memory_type;                          /* mapped and coherent */
    struct device_buffer buffers[FIXTURE_BUFFERS]; /* which fixture_close() destroys */
    uint32_t buffer_count;
} fixture;

void fixture_open(const struct instance_settings *settings);
void fixture_close(void);

/* Has a device address beside its other usage. */
struct device_buffer fixture_buffer(VkDeviceSize size, VkBufferUsageFlags usage);

VkCommandBuffer fixture_begin(void);
/* Makes all writes visible, ends and submits the command buffer, and waits. */
void fixture_finish(VkCommandBuffer commands);

/* ---- a compute shader on a device without the layer */

void shader_open(const uint32_t *code, size_t code_size, uint32_t constants_size);
void shader_run(const void *constants, uint32_t constants_size, uint32_t groups);
void shader_close(void);

#endif
