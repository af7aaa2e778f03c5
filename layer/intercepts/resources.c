/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of memory, buffers, their bindings and addresses, and acceleration structures. */
#include "src/state/resources/resources.h"

#include "layer/accel_addresses.h"
#include "layer/execution/hazards/checks.h"
#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "layer/postmortem/loss.h"
#include "layer/snapshots/guard/follow.h"
#include "src/base/chain.h"

/* ---- memory */

static VkMemoryPropertyFlags properties_of(const struct layer_device *device, uint32_t type)
{
    return type < device->memory.memoryTypeCount ? device->memory.memoryTypes[type].propertyFlags
                                                 : 0;
}

static uint32_t bits_in(uint32_t mask)
{
    return (uint32_t)__builtin_popcount(mask);
}

/* Whether an allocation has several instances: one for each physical device of the mask; without a
 * mask, of the group, if the heap is multi-instance (Vulkan specification,
 * VkMemoryAllocateFlagsInfo). */
static bool has_instances(const struct layer_device *device,
                          const VkMemoryAllocateInfo *allocate_info)
{
    const VkMemoryAllocateFlagsInfo *flags =
        chain_find(allocate_info->pNext, VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO);
    if (flags && (flags->flags & VK_MEMORY_ALLOCATE_DEVICE_MASK_BIT))
        return bits_in(flags->deviceMask) > 1;
    uint32_t type = allocate_info->memoryTypeIndex;
    if (type >= device->memory.memoryTypeCount || device->physical_device_count < 2)
        return false;
    uint32_t heap = device->memory.memoryTypes[type].heapIndex;
    return device->memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_MULTI_INSTANCE_BIT;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_AllocateMemory(VkDevice device,
                                                    const VkMemoryAllocateInfo *pAllocateInfo,
                                                    const VkAllocationCallbacks *pAllocator,
                                                    VkDeviceMemory *pMemory)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.AllocateMemory(device, pAllocateInfo, pAllocator, pMemory);
    if (result == VK_SUCCESS)
        resources_add_memory(state->resources, *pMemory, pAllocateInfo->allocationSize,
                             properties_of(state, pAllocateInfo->memoryTypeIndex),
                             has_instances(state, pAllocateInfo));
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_FreeMemory(VkDevice device, VkDeviceMemory memory,
                                            const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    if (state->hazard_checks)
        hazard_checks_forget(state->hazard_checks, MEMORY_FREED,
                             resources_find_memory_id(state->resources, memory));
    resources_remove_memory(state->resources, memory);
    object_names_set(state->names, VK_OBJECT_TYPE_DEVICE_MEMORY, (uint64_t)(uintptr_t)memory, NULL);
    state->vk.FreeMemory(device, memory, pAllocator);
}

static VkResult observe_map(struct layer_device *state, VkDeviceMemory memory, VkDeviceSize offset,
                            VkDeviceSize size, void *const *data, VkResult result)
{
    if (result == VK_SUCCESS)
        resources_map_memory(state->resources, memory, offset, size, *data);
    return postmortem_see(state, result);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_MapMemory(VkDevice device, VkDeviceMemory memory,
                                               VkDeviceSize offset, VkDeviceSize size,
                                               VkMemoryMapFlags flags, void **ppData)
{
    struct layer_device *state = layer_find_device(device);
    return observe_map(state, memory, offset, size, ppData,
                       state->vk.MapMemory(device, memory, offset, size, flags, ppData));
}

static VkResult map2(PFN_vkMapMemory2 next, struct layer_device *state, const VkMemoryMapInfo *info,
                     void **data)
{
    return observe_map(state, info->memory, info->offset, info->size, data,
                       next(state->handle, info, data));
}

VKAPI_ATTR VkResult VKAPI_CALL assay_MapMemory2(VkDevice device,
                                                const VkMemoryMapInfo *pMemoryMapInfo,
                                                void **ppData)
{
    struct layer_device *state = layer_find_device(device);
    return map2(state->vk.MapMemory2, state, pMemoryMapInfo, ppData);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_MapMemory2KHR(VkDevice device,
                                                   const VkMemoryMapInfo *pMemoryMapInfo,
                                                   void **ppData)
{
    struct layer_device *state = layer_find_device(device);
    return map2(state->vk.MapMemory2KHR, state, pMemoryMapInfo, ppData);
}

VKAPI_ATTR void VKAPI_CALL assay_UnmapMemory(VkDevice device, VkDeviceMemory memory)
{
    struct layer_device *state = layer_find_device(device);
    resources_unmap_memory(state->resources, memory);
    state->vk.UnmapMemory(device, memory);
}

static VkResult unmap2(PFN_vkUnmapMemory2 next, struct layer_device *state,
                       const VkMemoryUnmapInfo *info)
{
    resources_unmap_memory(state->resources, info->memory);
    return next(state->handle, info);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_UnmapMemory2(VkDevice device,
                                                  const VkMemoryUnmapInfo *pMemoryUnmapInfo)
{
    struct layer_device *state = layer_find_device(device);
    return unmap2(state->vk.UnmapMemory2, state, pMemoryUnmapInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_UnmapMemory2KHR(VkDevice device,
                                                     const VkMemoryUnmapInfo *pMemoryUnmapInfo)
{
    struct layer_device *state = layer_find_device(device);
    return unmap2(state->vk.UnmapMemory2KHR, state, pMemoryUnmapInfo);
}

/* ---- destroyed objects */

/* Remembers an object that is about to be destroyed, and forgets its name. */
static void note_destroyed(struct layer_device *device, VkObjectType type, uint64_t handle)
{
    struct destroyed_object object = {.type = type, .handle = handle};
    struct resource_span span;
    if (resources_find_span(device->resources, type, handle, true, &span) && span.address) {
        object.address = span.address;
        object.size = span.size;
        object_names_get(device->names, type, handle, object.name, sizeof(object.name));
        destroyed_objects_add(device->destroyed, &object);
    }
    object_names_set(device->names, type, handle, NULL);
}

/* ---- buffers */

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateBuffer(VkDevice device,
                                                  const VkBufferCreateInfo *pCreateInfo,
                                                  const VkAllocationCallbacks *pAllocator,
                                                  VkBuffer *pBuffer)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateBuffer(device, pCreateInfo, pAllocator, pBuffer);
    if (result == VK_SUCCESS)
        resources_add_buffer(state->resources, *pBuffer, pCreateInfo);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyBuffer(VkDevice device, VkBuffer buffer,
                                               const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    note_destroyed(state, VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)buffer);
    resources_remove_buffer(state->resources, buffer);
    state->vk.DestroyBuffer(device, buffer, pAllocator);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_BindBufferMemory(VkDevice device, VkBuffer buffer,
                                                      VkDeviceMemory memory,
                                                      VkDeviceSize memoryOffset)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.BindBufferMemory(device, buffer, memory, memoryOffset);
    if (result == VK_SUCCESS)
        resources_bind_buffer(state->resources, buffer, memory, memoryOffset, false);
    return result;
}

/* Whether instance i of the buffer is bound to another instance of the memory than i. */
static bool instances_differ(const VkBindBufferMemoryInfo *bind)
{
    const VkBindBufferMemoryDeviceGroupInfo *group =
        chain_find(bind->pNext, VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_DEVICE_GROUP_INFO);
    for (uint32_t i = 0; group && i < group->deviceIndexCount; i++)
        if (group->pDeviceIndices[i] != i)
            return true;
    return false;
}

/* A failed call may have bound some buffers. VK_KHR_maintenance6 returns the result of each if the
 * application requests that. */
static void observe_bind(struct layer_device *state, const VkBindBufferMemoryInfo *bind,
                         VkResult result)
{
    const VkBindMemoryStatus *status =
        chain_find(bind->pNext, VK_STRUCTURE_TYPE_BIND_MEMORY_STATUS);
    if (result != VK_SUCCESS && status && status->pResult)
        result = *status->pResult;
    if (result == VK_SUCCESS)
        resources_bind_buffer(state->resources, bind->buffer, bind->memory, bind->memoryOffset,
                              instances_differ(bind));
    else
        resources_forget_binding(state->resources, bind->buffer);
}

static VkResult bind_buffers(VkDevice device, PFN_vkBindBufferMemory2 bind, uint32_t count,
                             const VkBindBufferMemoryInfo *infos, struct layer_device *state)
{
    VkResult result = bind(device, count, infos);
    for (uint32_t i = 0; i < count; i++)
        observe_bind(state, &infos[i], result);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_BindBufferMemory2(VkDevice device, uint32_t bindInfoCount,
                                                       const VkBindBufferMemoryInfo *pBindInfos)
{
    struct layer_device *state = layer_find_device(device);
    return bind_buffers(device, state->vk.BindBufferMemory2, bindInfoCount, pBindInfos, state);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_BindBufferMemory2KHR(VkDevice device, uint32_t bindInfoCount,
                                                          const VkBindBufferMemoryInfo *pBindInfos)
{
    struct layer_device *state = layer_find_device(device);
    return bind_buffers(device, state->vk.BindBufferMemory2KHR, bindInfoCount, pBindInfos, state);
}

static VkDeviceAddress observe_address(struct layer_device *state,
                                       const VkBufferDeviceAddressInfo *info,
                                       VkDeviceAddress address)
{
    resources_set_address(state->resources, info->buffer, address);
    return address;
}

VKAPI_ATTR VkDeviceAddress VKAPI_CALL
assay_GetBufferDeviceAddress(VkDevice device, const VkBufferDeviceAddressInfo *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    return observe_address(state, pInfo, state->vk.GetBufferDeviceAddress(device, pInfo));
}

VKAPI_ATTR VkDeviceAddress VKAPI_CALL
assay_GetBufferDeviceAddressKHR(VkDevice device, const VkBufferDeviceAddressInfo *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    return observe_address(state, pInfo, state->vk.GetBufferDeviceAddressKHR(device, pInfo));
}

VKAPI_ATTR VkDeviceAddress VKAPI_CALL
assay_GetBufferDeviceAddressEXT(VkDevice device, const VkBufferDeviceAddressInfo *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    return observe_address(state, pInfo, state->vk.GetBufferDeviceAddressEXT(device, pInfo));
}

/* ---- acceleration structures */

/* Notes that the address of a new structure is unknown. Instances may refer to it even if the
 * application never queries the address. A guarded build needs the address when it executes; other
 * checks query it when they look up what an instance refers to. */
static void note_address(struct layer_device *state, VkAccelerationStructureKHR structure)
{
    if (!state->input_checks)
        return;
    resources_set_accel_address(state->resources, structure, 0);
    if (state->snapshots->guard)
        layer_query_accel_address(state, structure);
    guard_follow(state);
}

VKAPI_ATTR VkDeviceAddress VKAPI_CALL assay_GetAccelerationStructureDeviceAddressKHR(
    VkDevice device, const VkAccelerationStructureDeviceAddressInfoKHR *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    VkDeviceAddress address = state->vk.GetAccelerationStructureDeviceAddressKHR(device, pInfo);
    if (state->input_checks)
        resources_set_accel_address(state->resources, pInfo->accelerationStructure, address);
    guard_follow(state);
    return address;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateAccelerationStructureKHR(
    VkDevice device, const VkAccelerationStructureCreateInfoKHR *pCreateInfo,
    const VkAllocationCallbacks *pAllocator, VkAccelerationStructureKHR *pAccelerationStructure)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateAccelerationStructureKHR(device, pCreateInfo, pAllocator,
                                                               pAccelerationStructure);
    if (result != VK_SUCCESS)
        return result;
    resources_add_accel(state->resources, *pAccelerationStructure, pCreateInfo);
    note_address(state, *pAccelerationStructure);
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateAccelerationStructure2KHR(
    VkDevice device, const VkAccelerationStructureCreateInfo2KHR *pCreateInfo,
    const VkAllocationCallbacks *pAllocator, VkAccelerationStructureKHR *pAccelerationStructure)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateAccelerationStructure2KHR(device, pCreateInfo, pAllocator,
                                                                pAccelerationStructure);
    if (result != VK_SUCCESS)
        return result;
    resources_add_accel_at(state->resources, *pAccelerationStructure, pCreateInfo);
    note_address(state, *pAccelerationStructure);
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyAccelerationStructureKHR(
    VkDevice device, VkAccelerationStructureKHR accelerationStructure,
    const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    note_destroyed(state, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                   (uint64_t)(uintptr_t)accelerationStructure);
    structures_note_destroyed(state->structures,
                              resources_remove_accel(state->resources, accelerationStructure), 1);
    state->vk.DestroyAccelerationStructureKHR(device, accelerationStructure, pAllocator);
}
