/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes (host_fixture.h) that are built by command buffers, from device-local copies of their
 * data; and structures of VK_NV_ray_tracing. */
#ifndef ASSAY_TESTS_CPU_BACKEND_DEVICE_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_DEVICE_FIXTURE_H

#include "tests/cpu_backend/host_fixture.h"

static const VkCommandBufferLevel PRIMARY = VK_COMMAND_BUFFER_LEVEL_PRIMARY;

/* A buffer for any use that the tests make of one. */
struct device_buffer device_buffer_create(VkDeviceSize size);

VkCommandBuffer device_begin(VkCommandBufferLevel level);
void device_end(VkCommandBuffer commands);
/* Submits, and waits with a fence. */
void device_run(VkCommandBuffer commands);
/* Ends it, runs it and frees it. */
void device_finish(VkCommandBuffer commands);

/* Makes all that was written visible to all that follows. */
void device_barrier(VkCommandBuffer commands);

/* A host build's parameters (fixture_triangles, fixture_instances, fixture_create_for) with the
 * same data in buffers. Not to be moved. */
struct device_build {
    struct fixture_build *host;
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    struct device_buffer staging, data;
};
void device_build_create(struct fixture_build *host, struct device_build *build);

/* Records a build of `dst`, an update where `src` isn't VK_NULL_HANDLE, with a barrier behind it.
 */
void device_build(VkCommandBuffer commands, struct device_build *build,
                  VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src);

/* ---- VK_NV_ray_tracing */

/* Bound to memory of its own. */
struct nv_structure {
    VkAccelerationStructureNV handle;
    VkDeviceMemory memory;
    struct device_buffer scratch;
};

/* For builds of `info`. */
struct nv_structure nv_create(const VkAccelerationStructureInfoNV *info);

VkMemoryRequirements nv_requirements(VkAccelerationStructureNV handle,
                                     VkAccelerationStructureMemoryRequirementsTypeNV type);

/* So many triangles of three floats a vertex, in a buffer, without indices. */
VkGeometryNV nv_triangles(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize stride,
                          uint32_t triangles);

/* Records a build, of `instances` at `offset` for a TLAS, with a barrier behind it; an update where
 * `src` isn't VK_NULL_HANDLE. */
void nv_build(VkCommandBuffer commands, const VkAccelerationStructureInfoNV *info,
              VkBuffer instances, VkDeviceSize offset, struct nv_structure *dst,
              VkAccelerationStructureNV src);

#endif
