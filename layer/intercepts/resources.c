/* SPDX-License-Identifier: Apache-2.0 */
/* Observes memory, buffers, their bindings and addresses, and acceleration structures. */
#include "src/state/resources/resources.h"

#include "layer/consumers.h"
#include "layer/execution/build_records.h"
#include "layer/execution/submitted_builds.h"
#include "layer/hazards/executed/checks.h"
#include "layer/intercepts/intercepts.h"
#include "layer/physical_device.h"
#include "layer/snapshots/guard/references.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"
#include "src/state/resources/update_templates.h"

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
    if (type >= device->memory.memoryTypeCount || !device->facts.is_group)
        return false;
    uint32_t heap = device->memory.memoryTypes[type].heapIndex;
    return device->memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_MULTI_INSTANCE_BIT;
}

/* Whether the allocation is imported or may be exported, as far as is known. */
static bool is_shared(const VkMemoryAllocateInfo *info)
{
    bool found = false;
    for (const VkBaseInStructure *each = info->pNext; each && !found; each = each->pNext)
        found = each->sType != VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO &&
                each->sType != VK_STRUCTURE_TYPE_MEMORY_DEDICATED_ALLOCATE_INFO &&
                each->sType != VK_STRUCTURE_TYPE_MEMORY_PRIORITY_ALLOCATE_INFO_EXT &&
                each->sType != VK_STRUCTURE_TYPE_MEMORY_OPAQUE_CAPTURE_ADDRESS_ALLOCATE_INFO;
    return found;
}

void note_allocation(struct layer_device *device, const VkMemoryAllocateInfo *info,
                     VkDeviceMemory memory)
{
    resources_add_memory(device->resources, memory, info->allocationSize, info->memoryTypeIndex,
                         properties_of(device, info->memoryTypeIndex), has_instances(device, info));
    if ((device->hazard_checks || device->places) && is_shared(info))
        resources_share_memory(device->resources, memory);
}

void forget_memory(struct layer_device *device, VkDeviceMemory memory)
{
    readable_forget_all();
    if (device->hazard_checks)
        hazard_checks_forget(device->hazard_checks, MEMORY_FREED,
                             resources_find_memory_id(device->resources, memory));
    resources_remove_memory(device->resources, memory);
    object_names_end(device->names, VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(memory), 0);
}

void note_mapping(struct layer_device *device, VkDeviceMemory memory, VkDeviceSize offset,
                  VkDeviceSize size, void *data)
{
    resources_map_memory(device->resources, memory, offset, size, data);
}

void forget_mapping(struct layer_device *device, VkDeviceMemory memory)
{
    readable_forget_all();
    resources_unmap_memory(device->resources, memory);
}

/* ---- destroyed objects */

/* Remembers an object that is about to be destroyed, and its name. Returns its number, or 0 if it
 * has none. */
static uint64_t note_destroyed(struct layer_device *device, VkObjectType type, uint64_t handle,
                               bool is_reported)
{
    const enum resource_kind kind =
        type == VK_OBJECT_TYPE_BUFFER ? RESOURCE_BUFFER : RESOURCE_ACCEL;
    struct destroyed_object object = {.type = type,
                                      .handle = handle,
                                      .id = resources_find_id(device->resources, kind, handle),
                                      .is_reported = is_reported};
    struct resource_span span;
    uint64_t last = 0;
    if (resources_find_span(device->resources, type, handle, true, &span) && span.address) {
        object.address = span.address;
        object.size = span.size;
        object_names_get(device->names, type, handle, object.name, sizeof(object.name));
        last = destroyed_objects_add(device->destroyed, &object);
    }
    object_names_end(device->names, type, handle, object.id);
    return last;
}

/* ---- buffers */

void note_buffer(struct layer_device *device, VkBuffer buffer, const VkBufferCreateInfo *info)
{
    resources_add_buffer(device->resources, buffer, info);
}

void forget_buffer(struct layer_device *device, VkBuffer buffer)
{
    note_destroyed(device, VK_OBJECT_TYPE_BUFFER, handle_number(buffer), false);
    resources_remove_buffer(device->resources, buffer);
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

/* A failed call has bound nothing if it has one binding; otherwise it may have bound some buffers.
 * VK_KHR_maintenance6 returns the result of each if the application requests that. */
static void observe_bind(struct layer_device *state, const VkBindBufferMemoryInfo *bind,
                         bool is_only_one, VkResult result)
{
    const VkBindMemoryStatus *status =
        chain_find(bind->pNext, VK_STRUCTURE_TYPE_BIND_MEMORY_STATUS);
    if (result != VK_SUCCESS && status && status->pResult)
        result = *status->pResult;
    if (result == VK_SUCCESS)
        resources_bind_buffer(state->resources, bind->buffer, bind->memory, bind->memoryOffset,
                              instances_differ(bind));
    else if (!is_only_one)
        resources_forget_binding(state->resources, bind->buffer);
}

void note_bindings(struct layer_device *device, uint32_t count, const VkBindBufferMemoryInfo *infos,
                   VkResult result)
{
    for (uint32_t i = 0; i < count; i++)
        observe_bind(device, &infos[i], count == 1, result);
}

void note_buffer_address(struct layer_device *device, const VkBufferDeviceAddressInfo *info,
                         VkDeviceAddress address)
{
    resources_set_address(device->resources, info->buffer, address);
}

/* ---- acceleration structures */

void note_callbacks(struct layer_device *device, enum resource_kind kind, uint64_t handle,
                    const VkAllocationCallbacks *callbacks)
{
    if (callbacks)
        resources_note_callbacks(device->resources, kind, handle);
}

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

void note_accel_address(struct layer_device *device,
                        const VkAccelerationStructureDeviceAddressInfoKHR *info,
                        VkDeviceAddress address)
{
    if (device->input_checks)
        resources_set_accel_address(device->resources, info->accelerationStructure, address);
    guard_follow(device);
}

void note_accel(struct layer_device *device, VkAccelerationStructureKHR accel,
                const VkAccelerationStructureCreateInfoKHR *info)
{
    resources_add_accel(device->resources, accel, info);
    note_address(device, accel);
}

void note_accel_2(struct layer_device *device, VkAccelerationStructureKHR accel,
                  const VkAccelerationStructureCreateInfo2KHR *info)
{
    resources_add_accel_at(device->resources, accel, info);
    note_address(device, accel);
}

/* Which structures the instances of a build refer to is known once the build has executed. So the
 * destruction is noted at the pending batches, unless it is reported for another use. */
static void note_destroyed_accel(struct layer_device *device, VkAccelerationStructureKHR accel)
{
    const struct used_object used = {.id = layer_accel_id(device, accel)};
    struct pending_use use;
    const bool is_reported =
        device->input_checks && submitted_builds_find_use(device->submitted_builds, &used, &use);
    const uint64_t last = note_destroyed(device, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                         handle_number(accel), is_reported);
    if (last && device->input_checks && !is_reported)
        submitted_builds_note_destroyed(device->submitted_builds, last);
}

void forget_accel(struct layer_device *device, VkAccelerationStructureKHR accel)
{
    hazard_checks_forget(device->hazard_checks, STRUCTURE_DESTROYED, handle_number(accel));
    consumers_on_destroy(device, accel);
    build_records_add_destroyed(device, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                handle_number(accel));
    note_destroyed_accel(device, accel);
    structures_note_destroyed(device->structures, resources_remove_accel(device->resources, accel),
                              1);
}

/* ---- descriptor update templates */

void note_update_template(struct layer_device *device, VkDescriptorUpdateTemplate handle,
                          const VkDescriptorUpdateTemplateCreateInfo *info)
{
    update_templates_add(device->update_templates, handle, info);
}

void forget_update_template(struct layer_device *device, VkDescriptorUpdateTemplate handle)
{
    update_templates_remove(device->update_templates, handle);
}
