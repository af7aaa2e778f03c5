/* SPDX-License-Identifier: Apache-2.0 */
/* Objects of VK_NV_ray_tracing, and builds with them. */
#include "tests/cpu_backend/nv_fixture.h"

VkMemoryRequirements nv_requirements(VkAccelerationStructureNV handle,
                                     VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    const STRUCT(VkAccelerationStructureMemoryRequirementsInfoNV, info, .type = type,
                 .accelerationStructure = handle);
    STRUCT(VkMemoryDedicatedRequirements, dedicated, .requiresDedicatedAllocation = VK_TRUE);
    STRUCT(VkMemoryRequirements2, requirements, .pNext = &dedicated);
    vk.GetAccelerationStructureMemoryRequirementsNV(device, &info, &requirements);
    assert_false(dedicated.requiresDedicatedAllocation);
    return requirements.memoryRequirements;
}

static VkDeviceSize scratch_size(VkAccelerationStructureNV handle)
{
    const VkDeviceSize build =
        nv_requirements(handle, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV)
            .size;
    const VkDeviceSize update =
        nv_requirements(handle,
                        VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV)
            .size;
    return build > update ? build : update;
}

static void bind_memory(struct nv_structure *structure)
{
    const VkMemoryRequirements requirements = nv_requirements(
        structure->handle, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV);
    assert_true(requirements.memoryTypeBits >> host_memory_type & 1);
    structure->size = requirements.size;
    structure->memory = memory_create(&vk, device, host_memory_type, requirements.size);
    OWN(FreeMemory, structure->memory);
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, bind,
                 .accelerationStructure = structure->handle, .memory = structure->memory);
    GET(vk.BindAccelerationStructureMemoryNV(device, 1, &bind));
}

struct nv_structure nv_create(const VkAccelerationStructureInfoNV *info, VkDeviceSize compacted)
{
    struct nv_structure structure = {0};
    const STRUCT(VkAccelerationStructureCreateInfoNV, create_info, .compactedSize = compacted,
                 .info = *info);
    GET(vk.CreateAccelerationStructureNV(device, &create_info, NULL, &structure.handle));
    OWN(DestroyAccelerationStructureNV, structure.handle);
    bind_memory(&structure);
    if (!compacted)
        structure.scratch = device_buffer_create(scratch_size(structure.handle));
    return structure;
}

uint64_t nv_reference(VkAccelerationStructureNV structure)
{
    uint64_t reference = 0;
    GET(vk.GetAccelerationStructureHandleNV(device, structure, sizeof(reference), &reference));
    return reference;
}

void nv_build(VkCommandBuffer commands, const VkAccelerationStructureInfoNV *info,
              VkBuffer instances, VkDeviceSize offset, struct nv_structure *dst,
              VkAccelerationStructureNV src)
{
    vk.CmdBuildAccelerationStructureNV(commands, info, instances, offset, src != VK_NULL_HANDLE,
                                       dst->handle, src, dst->scratch.handle, 0);
    device_barrier(commands);
}
