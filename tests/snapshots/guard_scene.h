/* SPDX-License-Identifier: Apache-2.0 */
/* Instances of a BLAS that is built, in a scene whose builds the layer guards. */
#ifndef ASSAY_TESTS_SNAPSHOTS_GUARD_SCENE_H
#define ASSAY_TESTS_SNAPSHOTS_GUARD_SCENE_H

#include "tests/snapshots/scene.h"

enum {
    STRUCTURE_SIZE = 1 << 16,
    INSTANCE_SIZE = sizeof(VkAccelerationStructureInstanceKHR),
    GUARD_INSTANCES = 16,
};

extern struct guard_scene {
    struct device_buffer instances, pointers, range; /* range: of an indirect build */
    struct device_buffer spare;                      /* for one more structure */
} guard_scene;

/* `guard`: the setting. scene.blas is built. */
void guard_open(const char *guard);
void guard_open_references(void); /* the same with guard = references */
void guard_close(void);

#define GUARD_TEST(name) TEST_BETWEEN_IF(name, guard_open_references, guard_close, true)
#define NULL_TEST(name) TEST_BETWEEN_IF(name, guard_open_references, guard_close, platform.is_null)

/* An address of nothing, and what the message says of it. */
uint64_t guard_wild(void);
#define GUARD_NO_STRUCTURE "is not the address of an acceleration structure"

uint64_t guard_address(VkAccelerationStructureKHR structure);
/* A buffer for one structure; and a BLAS at its begin. */
struct device_buffer guard_buffer(void);
VkAccelerationStructureKHR guard_make(const struct device_buffer *buffer);
void guard_destroy(VkAccelerationStructureKHR structure);
/* Builds the structure, with a barrier behind; and builds and waits for one that it makes. */
void guard_build_boxes(VkCommandBuffer commands, VkAccelerationStructureKHR structure);
VkAccelerationStructureKHR guard_build_another(const struct device_buffer *buffer);
/* A reference that is valid on another device, and at no time on this one. */
uint64_t guard_of_another_device(void);

/* Writes valid instances with these references, and pointers to them. */
void guard_write(const uint64_t *references, uint32_t count);
/* Writes one instance, of this structure, and returns its address. */
uint64_t guard_refer_to(VkAccelerationStructureKHR structure);
void guard_point(uint32_t pointer, uint64_t address);
/* Changes the reference of the first instance when the command buffer executes. */
void guard_change_reference(VkCommandBuffer commands, uint64_t reference);

/* Builds of scene.tlas with the first `count` instances. */
void guard_build(VkCommandBuffer commands, uint32_t count);
void guard_build_at(VkCommandBuffer commands, uint32_t offset, uint32_t count);
void guard_build_pointers(VkCommandBuffer commands, uint32_t count);
void guard_build_moving(VkCommandBuffer commands, bool are_pointers, uint32_t count);
void guard_build_indirect(VkCommandBuffer commands, uint32_t count);

/* Builds in a command buffer of its own, and waits. */
void guard_build_alone(uint32_t count);
/* Submits, waits, and expects a build that read this reference. guard_finish() ends and frees
 * the command buffer, too. */
void guard_run(VkCommandBuffer commands, uint64_t reads);
void guard_finish(VkCommandBuffer commands, uint64_t reads);
/* What the builds have read since the last call, where the driver tells. */
void guard_expect_read(const uint64_t *references, uint32_t count);
/* There is a message that contains both texts; all are forgotten. */
void guard_expect(const char *text, const char *other);

#endif
