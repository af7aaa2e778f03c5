/* SPDX-License-Identifier: Apache-2.0 */
/* Creates the structures that the driver builds again, and the TLAS over them. */
#include "layer/compare/tracer.h"

#include <stdlib.h>
#include <string.h>

static uint64_t align(uint64_t address, uint64_t alignment)
{
    return (address + alignment - 1) / alignment * alignment;
}

static VkResult create_scratch(const struct compare_device *device, uint64_t size,
                               struct compare_structure *structure)
{
    return compare_buffer_create(device, size + device->scratch_alignment, false,
                                 &structure->scratch);
}

static VkResult create_structure(const struct compare_device *device,
                                 VkAccelerationStructureTypeKHR type, uint64_t size,
                                 struct compare_structure *structure)
{
    VkResult result = compare_buffer_create(device, size, false, &structure->buffer);
    const VkAccelerationStructureCreateInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
        .buffer = structure->buffer.handle,
        .size = size,
        .type = type,
    };
    if (result == VK_SUCCESS)
        result = device->vk->CreateAccelerationStructureKHR(device->handle, &info, NULL,
                                                            &structure->handle);
    return result;
}

static VkAccelerationStructureBuildGeometryInfoKHR
bottom_info(const struct compare_input *input, const struct compare_structure *target,
            const struct compare_structure *structure)
{
    VkAccelerationStructureBuildGeometryInfoKHR info = input->parameters->info;
    info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    info.mode = target ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                       : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.srcAccelerationStructure = target ? target->handle : VK_NULL_HANDLE;
    info.dstAccelerationStructure = target ? target->handle : structure->handle;
    info.pGeometries = structure->geometries;
    info.ppGeometries = NULL;
    return info;
}

static VkResult find_sizes(const struct compare_device *device, const struct compare_input *input,
                           const struct compare_structure *structure,
                           VkAccelerationStructureBuildSizesInfoKHR *sizes)
{
    VkAccelerationStructureBuildGeometryInfoKHR info = bottom_info(input, NULL, structure);
    uint32_t *counts = malloc((info.geometryCount + 1ull) * sizeof(*counts));
    *sizes = (VkAccelerationStructureBuildSizesInfoKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    if (!counts)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < info.geometryCount; i++)
        counts[i] = input->parameters->ranges[i].primitiveCount;
    device->vk->GetAccelerationStructureBuildSizesKHR(
        device->handle, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, counts, sizes);
    free(counts);
    return VK_SUCCESS;
}

static VkResult create_input(const struct compare_device *device, const struct compare_input *input,
                             struct compare_structure *structure)
{
    uint64_t size = compare_input_size(input);
    uint32_t count = input->parameters->info.geometryCount;
    if (size == UINT64_MAX)
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    structure->geometries = malloc((count + 1ull) * sizeof(*structure->geometries));
    if (!structure->geometries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    size += COMPARE_ALIGNMENT;
    VkResult result = compare_buffer_create(device, size, true, &structure->input);
    if (result != VK_SUCCESS)
        return result;
    memset(structure->input.bytes, 0, size);
    uint64_t address = align(structure->input.address, COMPARE_ALIGNMENT);
    compare_input_place(input, address,
                        structure->input.bytes + (address - structure->input.address),
                        structure->geometries);
    return VK_SUCCESS;
}

VkResult compare_structure_create(const struct compare_device *device,
                                  const struct compare_input *input,
                                  const struct compare_structure *target,
                                  struct compare_structure *structure)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes;
    VkResult result = create_input(device, input, structure);
    if (result == VK_SUCCESS)
        result = find_sizes(device, input, structure, &sizes);
    if (result == VK_SUCCESS)
        result = create_scratch(device, target ? sizes.updateScratchSize : sizes.buildScratchSize,
                                structure);
    if (result == VK_SUCCESS && !target)
        result = create_structure(device, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                  sizes.accelerationStructureSize, structure);
    return result;
}

static VkAccelerationStructureBuildGeometryInfoKHR
top_info(const struct compare_structure *structure)
{
    return (VkAccelerationStructureBuildGeometryInfoKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
        .flags = structure->flags,
        .dstAccelerationStructure = structure->handle,
        .geometryCount = 1,
        .pGeometries = structure->geometries,
    };
}

/* Returns the size of the pointers before the instances. */
static uint64_t pointers_size(const struct compare_instances *instances)
{
    return instances->array_of_pointers
               ? align(instances->count * sizeof(uint64_t), COMPARE_ALIGNMENT)
               : 0;
}

static VkResult create_instances(const struct compare_device *device,
                                 const struct compare_instances *instances,
                                 struct compare_structure *structure)
{
    uint64_t size =
        pointers_size(instances) + instances->count * sizeof(VkAccelerationStructureInstanceKHR);
    structure->geometries = calloc(1, sizeof(*structure->geometries));
    if (!structure->geometries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkResult result =
        compare_buffer_create(device, COMPARE_ALIGNMENT + size, true, &structure->input);
    *structure->geometries = (VkAccelerationStructureGeometryKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
        .flags = instances->geometry_flags,
        .geometry.instances =
            {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
             .arrayOfPointers = instances->array_of_pointers,
             .data.deviceAddress = align(structure->input.address, COMPARE_ALIGNMENT)},
    };
    structure->flags = instances->flags;
    structure->instance_count = instances->count;
    return result;
}

void compare_structure_set_instance(const struct compare_structure *structure,
                                    const struct compare_instances *instances, uint32_t instance,
                                    uint64_t reference, uint32_t record)
{
    uint64_t base = align(structure->input.address, COMPARE_ALIGNMENT);
    uint64_t address =
        base + pointers_size(instances) + instance * sizeof(VkAccelerationStructureInstanceKHR);
    VkAccelerationStructureInstanceKHR copy = instances->instances[instance];
    copy.accelerationStructureReference = reference;
    copy.instanceShaderBindingTableRecordOffset = record & 0xffffff;
    memcpy(structure->input.bytes + (address - structure->input.address), &copy, sizeof(copy));
    if (instances->array_of_pointers)
        memcpy(structure->input.bytes + (base - structure->input.address) +
                   instance * sizeof(address),
               &address, sizeof(address));
}

VkResult compare_structure_create_top(const struct compare_device *device,
                                      const struct compare_instances *instances,
                                      struct compare_structure *structure)
{
    VkAccelerationStructureBuildSizesInfoKHR sizes = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    VkResult result = create_instances(device, instances, structure);
    if (result != VK_SUCCESS)
        return result;
    const VkAccelerationStructureBuildGeometryInfoKHR info = top_info(structure);
    device->vk->GetAccelerationStructureBuildSizesKHR(
        device->handle, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, &instances->count,
        &sizes);
    result = create_scratch(device, sizes.buildScratchSize, structure);
    if (result == VK_SUCCESS)
        result = create_structure(device, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                                  sizes.accelerationStructureSize, structure);
    return result;
}

void compare_structure_free(const struct compare_device *device,
                            struct compare_structure *structure)
{
    if (structure->handle)
        device->vk->DestroyAccelerationStructureKHR(device->handle, structure->handle, NULL);
    compare_buffer_free(device, &structure->buffer);
    compare_buffer_free(device, &structure->scratch);
    compare_buffer_free(device, &structure->input);
    free(structure->geometries);
    *structure = (struct compare_structure){0};
}

static void build_structure(const struct compare_device *device, VkCommandBuffer commands,
                            VkAccelerationStructureBuildGeometryInfoKHR *info,
                            const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                            const struct compare_structure *structure)
{
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
        .dstAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                         VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
    };
    info->scratchData.deviceAddress = align(structure->scratch.address, device->scratch_alignment);
    device->vk->CmdBuildAccelerationStructuresKHR(commands, 1, info, &ranges);
    device->vk->CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                                   VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR |
                                       trace_pipeline_stage(device),
                                   0, 1, &barrier, 0, NULL, 0, NULL);
}

void compare_structure_build(const struct compare_device *device, VkCommandBuffer commands,
                             const struct compare_input *input,
                             const struct compare_structure *target,
                             const struct compare_structure *structure)
{
    VkAccelerationStructureBuildGeometryInfoKHR info = bottom_info(input, target, structure);
    build_structure(device, commands, &info, input->parameters->ranges, structure);
}

void compare_structure_build_top(const struct compare_device *device, VkCommandBuffer commands,
                                 const struct compare_structure *structure)
{
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount =
                                                                structure->instance_count};
    VkAccelerationStructureBuildGeometryInfoKHR info = top_info(structure);
    build_structure(device, commands, &info, &range, structure);
}
