/* SPDX-License-Identifier: Apache-2.0 */
/* Objects of VK_NV_ray_tracing, and builds with them. */
#include "nv_stage.h"

#define GET(call) assert_int_equal(call, VK_SUCCESS)

VkMemoryRequirements nv_requirements(struct device_stage *stage, VkAccelerationStructureNV handle,
                                     VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    const VkAccelerationStructureMemoryRequirementsInfoNV info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_INFO_NV,
        .type = type,
        .accelerationStructure = handle,
    };
    VkMemoryDedicatedRequirements dedicated = {.sType =
                                                   VK_STRUCTURE_TYPE_MEMORY_DEDICATED_REQUIREMENTS,
                                               .requiresDedicatedAllocation = VK_TRUE};
    VkMemoryRequirements2 requirements = {.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2,
                                          .pNext = &dedicated};
    stage->stage.vk.GetAccelerationStructureMemoryRequirementsNV(stage->stage.device, &info,
                                                                 &requirements);
    assert_false(dedicated.requiresDedicatedAllocation);
    return requirements.memoryRequirements;
}

static VkDeviceSize scratch_size(struct device_stage *stage, VkAccelerationStructureNV handle)
{
    const VkDeviceSize build =
        nv_requirements(stage, handle,
                        VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV)
            .size;
    const VkDeviceSize update =
        nv_requirements(stage, handle,
                        VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV)
            .size;
    return build > update ? build : update;
}

static void bind_memory(struct device_stage *stage, struct nv_structure *structure)
{
    const VkuDeviceDispatchTable *vk = &stage->stage.vk;
    const VkMemoryRequirements requirements = nv_requirements(
        stage, structure->handle, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV);
    assert_true(requirements.memoryTypeBits >> stage->stage.host_memory_type & 1);
    structure->size = requirements.size;
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .allocationSize = requirements.size,
                                         .memoryTypeIndex = stage->stage.host_memory_type};
    GET(vk->AllocateMemory(stage->stage.device, &memory, NULL, &structure->memory));
    const VkBindAccelerationStructureMemoryInfoNV bind = {
        .sType = VK_STRUCTURE_TYPE_BIND_ACCELERATION_STRUCTURE_MEMORY_INFO_NV,
        .accelerationStructure = structure->handle,
        .memory = structure->memory,
    };
    GET(vk->BindAccelerationStructureMemoryNV(stage->stage.device, 1, &bind));
}

struct nv_structure nv_create(struct device_stage *stage, const VkAccelerationStructureInfoNV *info,
                              VkDeviceSize compacted)
{
    struct nv_structure structure = {0};
    const VkAccelerationStructureCreateInfoNV create_info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_NV,
        .compactedSize = compacted,
        .info = *info,
    };
    GET(stage->stage.vk.CreateAccelerationStructureNV(stage->stage.device, &create_info, NULL,
                                                      &structure.handle));
    bind_memory(stage, &structure);
    if (!compacted)
        structure.scratch = device_buffer_create(stage, scratch_size(stage, structure.handle));
    return structure;
}

void nv_destroy(struct device_stage *stage, struct nv_structure *structure)
{
    const VkuDeviceDispatchTable *vk = &stage->stage.vk;
    vk->DestroyAccelerationStructureNV(stage->stage.device, structure->handle, NULL);
    vk->FreeMemory(stage->stage.device, structure->memory, NULL);
    device_buffer_destroy(stage, &structure->scratch);
}

uint64_t nv_reference(struct device_stage *stage, VkAccelerationStructureNV structure)
{
    uint64_t reference = 0;
    GET(stage->stage.vk.GetAccelerationStructureHandleNV(stage->stage.device, structure,
                                                         sizeof(reference), &reference));
    return reference;
}

void nv_build(struct device_stage *stage, VkCommandBuffer commands,
              const VkAccelerationStructureInfoNV *info, VkBuffer instances, VkDeviceSize offset,
              struct nv_structure *dst, VkAccelerationStructureNV src)
{
    stage->stage.vk.CmdBuildAccelerationStructureNV(commands, info, instances, offset,
                                                    src != VK_NULL_HANDLE, dst->handle, src,
                                                    dst->scratch.handle, 0);
    device_barrier(stage, commands);
}
