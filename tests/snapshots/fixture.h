/* SPDX-License-Identifier: Apache-2.0 */
/* A device with acceleration structures, with the layer or without it. What fails unexpectedly ends
 * the test. */
#ifndef ASSAY_TESTS_SNAPSHOTS_FIXTURE_H
#define ASSAY_TESTS_SNAPSHOTS_FIXTURE_H

#include "tests/fixture/geometry.h"
#include "tests/fixture/instance.h"

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

void fixture_open(struct fixture *fixture, const struct platform *platform,
                  const struct instance_settings *settings);
/* With one more extension, and a chain of features. */
void fixture_open_with(struct fixture *fixture, const struct platform *platform,
                       const struct instance_settings *settings, void *chain,
                       const char *extension);
void fixture_close(struct fixture *fixture);

/* Has a device address beside its other usage. */
struct device_buffer fixture_buffer(struct fixture *fixture, VkDeviceSize size,
                                    VkBufferUsageFlags usage);

VkAccelerationStructureKHR fixture_structure(struct fixture *fixture,
                                             const struct device_buffer *buffer,
                                             VkDeviceSize offset, VkDeviceSize size,
                                             VkAccelerationStructureTypeKHR type);

VkCommandBuffer fixture_begin(struct fixture *fixture, VkCommandBufferUsageFlags flags);
VkCommandBuffer fixture_begin_secondary(struct fixture *fixture, VkCommandBufferUsageFlags flags);
/* Ends and submits it, and waits. */
void fixture_finish(struct fixture *fixture, VkCommandBuffer commands);
VkResult fixture_submit(struct fixture *fixture, VkCommandBuffer commands, VkFence fence);

/* Makes all earlier writes visible to all later commands. */
void fixture_barrier(struct fixture *fixture, VkCommandBuffer commands);

/* A build of one geometry. */
struct fixture_build {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info; /* its sType and geometries are set later */
    VkAccelerationStructureBuildRangeInfoKHR range;
};
void fixture_build(struct fixture *fixture, VkCommandBuffer commands,
                   const struct fixture_build *build);
/* A build of `count` AABBs, with scratch memory. */
void fixture_build_boxes(struct fixture *fixture, VkCommandBuffer commands,
                         VkAccelerationStructureKHR dst, VkDeviceAddress boxes, uint32_t count,
                         VkDeviceAddress scratch);

void fixture_expect_silence(const struct fixture *fixture);

#endif
