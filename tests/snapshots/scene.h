/* SPDX-License-Identifier: Apache-2.0 */
/* The device of a test program, and a BLAS of boxes on it. */
#ifndef ASSAY_TESTS_SNAPSHOTS_SCENE_H
#define ASSAY_TESTS_SNAPSHOTS_SCENE_H

#include "tests/snapshots/fixture.h"
#include "tests/unit/unit_test.h"

extern struct platform platform;
extern struct fixture fixture;

extern struct scene {
    struct device_buffer boxes, structures, scratch;
    VkDeviceAddress scratch_address; /* aligned */
    VkAccelerationStructureKHR blas, tlas;
} scene;

/* NULL in `settings`: level content and the defaults. The boxes are zeros. There is a TLAS if
 * `has_tlas` is set. Each structure, and the scratch buffer, has `structure_size` bytes. */
struct scene_setup {
    struct instance_settings settings;
    VkDeviceSize boxes_size, structure_size;
    bool has_tlas;
};
void scene_open(const struct scene_setup *setup);
#define SCENE_OPEN(...) scene_open(&(struct scene_setup){__VA_ARGS__})
void scene_close(void);

/* Plans a fault of the null driver. */
#define PLAN_FAULT(...) platform.null_driver.plan_fault(&(struct null_driver_fault){__VA_ARGS__})

/* A buffer that builds may read. */
struct device_buffer scene_input(VkDeviceSize size);

/* A build of the BLAS, with a barrier behind it; and one that begins a command buffer. */
void scene_build_boxes(VkCommandBuffer commands, uint32_t count);
VkCommandBuffer scene_record_boxes(VkCommandBufferUsageFlags flags, uint32_t count);

/* Ends a command buffer and submits it. */
void scene_submit(VkCommandBuffer commands);

/* An instance of the BLAS. If it is not valid, its transform has no inverse, which level content
 * reports. */
void scene_write_instance(const struct device_buffer *buffer, bool is_valid);
/* A build of the TLAS with instances at an address, or with pointers to them; and one that is
 * recorded, with one instance. */
struct fixture_build scene_describe_instances(VkDeviceAddress data, bool are_pointers,
                                              uint32_t count);
void scene_build_instance(VkCommandBuffer commands, VkDeviceAddress data, bool is_pointer);

/* Turns a box upside down, which level content reports. */
void scene_invalidate_box(uint32_t i);

/* There are `count` messages, and each contains the text; forgets them. */
void expect_messages(uint32_t count, const char *text);

/* A test between open_scene(), which its file defines, and scene_close(). unit_test_open() opens
 * the platform, by default the null driver. */
#define SCENE_TEST(name) TEST_BETWEEN_IF(name, open_scene, scene_close, true)

#endif
