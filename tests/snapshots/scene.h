/* SPDX-License-Identifier: Apache-2.0 */
/* A device with acceleration structures, with the layer or without it; and the one of a test
 * program, with a BLAS of boxes on it. What fails unexpectedly ends the test. */
#ifndef ASSAY_TESTS_SNAPSHOTS_SCENE_H
#define ASSAY_TESTS_SNAPSHOTS_SCENE_H

#include "tests/fixture/geometry.h"
#include "tests/fixture/instance.h"
#include "tests/unit/unit_test.h"

enum { FIXTURE_OBJECTS = 32 };

struct fixture {
    struct instance_fixture instance;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    VkQueue queue;
    VkCommandPool pool;
    uint32_t memory_type; /* mapped and coherent */
    /* What fixture_close() destroys. */
    struct device_buffer buffers[FIXTURE_OBJECTS];
    VkAccelerationStructureKHR structures[FIXTURE_OBJECTS];
    uint32_t buffer_count, structure_count;
};

void fixture_open(struct fixture *own, const struct platform *on,
                  const struct instance_settings *settings);
/* With one more extension, and a chain of features. */
void fixture_open_with(struct fixture *own, const struct platform *on,
                       const struct instance_settings *settings, void *chain,
                       const char *extension);
void fixture_close(struct fixture *own);

/* Has a device address beside its other usage. */
struct device_buffer fixture_buffer(struct fixture *own, VkDeviceSize size,
                                    VkBufferUsageFlags usage);

VkAccelerationStructureKHR fixture_structure(struct fixture *own,
                                             const struct device_buffer *buffer,
                                             VkDeviceSize offset, VkDeviceSize size,
                                             VkAccelerationStructureTypeKHR type);

VkCommandBuffer fixture_begin(struct fixture *own, VkCommandBufferUsageFlags flags);
/* Ends and submits it, and waits. */
void fixture_finish(struct fixture *own, VkCommandBuffer commands);
VkResult fixture_submit(struct fixture *own, VkCommandBuffer commands, VkFence fence);

/* Makes all earlier writes visible to all later commands. */
void fixture_barrier(struct fixture *own, VkCommandBuffer commands);

/* A build of one geometry. */
struct fixture_build {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info; /* its sType and geometries are set later */
    VkAccelerationStructureBuildRangeInfoKHR range;
};
void fixture_build(struct fixture *own, VkCommandBuffer commands,
                   const struct fixture_build *build);
/* A build of `count` AABBs, with scratch memory. */
void fixture_build_boxes(struct fixture *own, VkCommandBuffer commands,
                         VkAccelerationStructureKHR dst, VkDeviceAddress boxes, uint32_t count,
                         VkDeviceAddress scratch);

/* ---- the device of a test program */

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
/* A build of the TLAS with an instance at an address, or with a pointer to it. */
void scene_build_instance(VkCommandBuffer commands, VkDeviceAddress data, bool is_pointer);

/* Turns a box upside down, which level content reports. */
void scene_invalidate_box(uint32_t i);

/* ---- a compute shader on a device without the layer */

void shader_open(const uint32_t *code, size_t code_size, uint32_t constants_size);
void shader_run(const void *constants, uint32_t constants_size, uint32_t groups);
void shader_close(void);

#endif
