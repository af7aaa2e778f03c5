/* SPDX-License-Identifier: Apache-2.0 */
/* Structures of VK_NV_ray_tracing on a device fixture, and builds from one buffer of inputs. */
#ifndef ASSAY_TESTS_CPU_BACKEND_NV_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_NV_FIXTURE_H

#include "device_fixture.h"

/* Bound to memory of its own. */
struct nv_structure {
    VkAccelerationStructureNV handle;
    VkDeviceMemory memory;
    VkDeviceSize size; /* that it asks for */
    struct device_buffer scratch;
};

/* For builds of `info`, or, where `compacted` isn't 0, for a compacting copy. */
struct nv_structure nv_create(const VkAccelerationStructureInfoNV *info, VkDeviceSize compacted);

VkMemoryRequirements nv_requirements(VkAccelerationStructureNV handle,
                                     VkAccelerationStructureMemoryRequirementsTypeNV type);

/* What instances refer to. */
uint64_t nv_reference(VkAccelerationStructureNV structure);

/* Records a build, of `instances` at `offset` for a TLAS, with a barrier behind it; an update where
 * `src` isn't VK_NULL_HANDLE. */
void nv_build(VkCommandBuffer commands, const VkAccelerationStructureInfoNV *info,
              VkBuffer instances, VkDeviceSize offset, struct nv_structure *dst,
              VkAccelerationStructureNV src);

#endif
