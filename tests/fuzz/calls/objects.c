/* SPDX-License-Identifier: Apache-2.0 */
/* Memory, buffers, structures, micromaps: created, bound, named, destroyed. */
#include <string.h>

#include "calls.h"

/* ---- memory */

void call_allocate_memory(struct calls *calls)
{
    struct slot *slot = pick(calls, MEMORIES);
    const STRUCT(VkMemoryAllocateFlagsInfo, flags, .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    STRUCT(VkMemoryAllocateInfo, info);
    info.pNext = take(calls) % 8 ? NULL : &flags;
    info.allocationSize = take_size(calls);
    info.memoryTypeIndex = (take(calls) + 1u) % 6;
    CREATE(calls, slot, info.allocationSize, AllocateMemory, &info);
}

void call_map_memory(struct calls *calls)
{
    struct slot *slot = pick(calls, MEMORIES);
    const VkDeviceMemory memory = HANDLE_OF(VkDeviceMemory, slot);
    void *bytes;
    if (take(calls) % 2) {
        calls->vk.UnmapMemory(calls->device, memory);
        slot->bytes = NULL;
    } else if (calls->vk.MapMemory(calls->device, memory, 0, VK_WHOLE_SIZE, 0, &bytes) ==
                   VK_SUCCESS &&
               slot->is_alive) {
        slot->bytes = bytes;
    }
}

/* ---- buffers */

static void ask_address(struct calls *calls, struct slot *slot)
{
    const STRUCT(VkBufferDeviceAddressInfo, info, .buffer = HANDLE_OF(VkBuffer, slot));
    VkDeviceAddress address = calls->vk.GetBufferDeviceAddress(calls->device, &info);
    if (address)
        slot->address = address;
}

void call_create_buffer(struct calls *calls)
{
    static const VkBufferUsageFlags usages[] = {
        VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
            VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
        VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
        VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
        VK_BUFFER_USAGE_TRANSFER_DST_BIT,
        VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
            VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT |
            VK_BUFFER_USAGE_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT,
    };
    static const VkBufferCreateFlags flags[] = {0, 0, VK_BUFFER_CREATE_SPARSE_BINDING_BIT,
                                                VK_BUFFER_CREATE_SPARSE_BINDING_BIT |
                                                    VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT |
                                                    VK_BUFFER_CREATE_SPARSE_ALIASED_BIT};
    struct slot *slot = pick(calls, BUFFERS);
    STRUCT(VkBufferCreateInfo, info);
    info.size = take_size(calls);
    info.usage = TAKE(calls, usages);
    info.flags = TAKE(calls, flags);
    CREATE(calls, slot, info.size, CreateBuffer, &info);
}

void call_bind_buffer(struct calls *calls)
{
    struct slot *slot = pick(calls, BUFFERS);
    const VkBuffer buffer = HANDLE_OF(VkBuffer, slot);
    const VkDeviceMemory memory = PICK(VkDeviceMemory, calls, MEMORIES);
    const VkDeviceSize offset = take_offset(calls);
    if (take(calls) % 2)
        calls->status =
            calls->vk.BindBufferMemory2(calls->device, 1,
                                        &MAKE(VkBindBufferMemoryInfo, .buffer = buffer,
                                              .memory = memory, .memoryOffset = offset));
    else
        calls->status = calls->vk.BindBufferMemory(calls->device, buffer, memory, offset);
    ask_address(calls, slot);
}

void call_get_address(struct calls *calls)
{
    ask_address(calls, pick(calls, BUFFERS));
}

void call_bind_sparse(struct calls *calls)
{
    const VkBuffer buffer = PICK(VkBuffer, calls, BUFFERS);
    VkSparseMemoryBind bind = {.memory = PICK(VkDeviceMemory, calls, MEMORIES)};
    bind.resourceOffset = take_offset(calls);
    bind.size = take_size(calls);
    bind.memoryOffset = take_offset(calls);
    const VkSparseBufferMemoryBindInfo binds = {buffer, 1, &bind};
    const VkFence fence = PICK(VkFence, calls, FENCES);
    calls->vk.QueueBindSparse(calls->queues[0], 1,
                              &MAKE(VkBindSparseInfo, .bufferBindCount = 1, .pBufferBinds = &binds),
                              fence);
}

/* What builds read: in memory that is mapped, or in the application's own. */
void call_write_data(struct calls *calls)
{
    static const VkAabbPositionsKHR boxes[] = {{0, 0, 0, 1, 1, 1}, {1, 0, 0, -1, 1, 1}};
    static const float floats[] = {0, 1, -1, 1e30f, __builtin_nanf(""), __builtin_inff()};
    unsigned char bytes[64] = {0};
    size_t size = sizeof(bytes);
    uint8_t place = take(calls), kind = take(calls);
    const struct slot *memory = &calls->slots[MEMORIES][place % slot_counts[MEMORIES]];
    unsigned char *target = place & 128 ? calls->host : memory->bytes;
    const VkDeviceSize room = place & 128 ? HOST_SIZE : memory->size;
    const VkDeviceSize offset = take_offset(calls);

    if (kind % 8 == 0) {
        memcpy(bytes, &boxes[kind / 8 % 2], size = sizeof(boxes[0]));
    } else if (kind % 8 == 1) {
        for (size_t i = 0; i < 9; i++)
            memcpy(bytes + i * sizeof(float), &TAKE(calls, floats), sizeof(float));
    } else if (kind % 8 == 2) {
        const struct slot *structure = pick(calls, STRUCTURES);
        VkAccelerationStructureInstanceKHR instance = {
            .transform = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
            .mask = 0xff,
            .flags = take(calls),
            .accelerationStructureReference =
                kind & 8 ? (uint64_t)(uintptr_t)structure->handle : structure->address};
        memcpy(bytes, &instance, size = sizeof(instance));
    } else if (kind % 8 == 3) {
        const uint64_t address =
            kind & 8 ? (uint64_t)(uintptr_t)take_pointer(calls) : take_address(calls, 0);
        memcpy(bytes, &address, size = sizeof(address));
    } else if (kind % 8 == 4) {
        VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = take_count(calls)};
        range.primitiveOffset = take(calls);
        range.firstVertex = take(calls);
        range.transformOffset = take(calls);
        memcpy(bytes, &range, size = sizeof(range));
    } else {
        for (size_t i = 0; i < 16; i++)
            bytes[i] = take(calls);
    }
    if (target && room > size && offset <= room - size)
        memcpy(target + offset, bytes, size);
}

/* ---- structures */

void call_create_structure(struct calls *calls)
{
    static const VkAccelerationStructureTypeKHR types[] = {
        VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR,
        VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR, (VkAccelerationStructureTypeKHR)99};
    struct slot *slot = pick(calls, STRUCTURES);
    const STRUCT(VkAccelerationStructureMotionInfoNV, motion, .maxInstances = 3);
    const VkBuffer buffer = PICK(VkBuffer, calls, BUFFERS);
    STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer);
    info.pNext = take(calls) % 4 == 1 ? &motion : NULL;
    info.offset = take_offset(calls);
    info.size = take_size(calls);
    info.type = TAKE(calls, types);
    CREATE(calls, slot, info.size, CreateAccelerationStructureKHR, &info);
}

void call_get_structure_address(struct calls *calls)
{
    struct slot *slot = pick(calls, STRUCTURES);
    const STRUCT(VkAccelerationStructureDeviceAddressInfoKHR, info,
                 .accelerationStructure = HANDLE_OF(VkAccelerationStructureKHR, slot));
    if (slot->is_alive)
        slot->address = calls->vk.GetAccelerationStructureDeviceAddressKHR(calls->device, &info);
}

void call_create_micromap(struct calls *calls)
{
    struct slot *slot = pick(calls, MICROMAPS);
    const VkBuffer buffer = PICK(VkBuffer, calls, BUFFERS);
    STRUCT(VkMicromapCreateInfoEXT, info, .buffer = buffer);
    info.offset = take_offset(calls);
    info.size = take_size(calls);
    info.type = (VkMicromapTypeEXT)(take(calls) % 2);
    CREATE(calls, slot, info.size, CreateMicromapEXT, &info);
}

/* ---- names, and what the messenger answers */

void call_name_object(struct calls *calls)
{
    static const char *const names[] = {"a name", "", NULL, "\xff%s%n\x01 \"quoted\"\n"};
    const uint8_t kind = take(calls);
    STRUCT(VkDebugUtilsObjectNameInfoEXT, info, .objectType = VK_OBJECT_TYPE_BUFFER,
           .pObjectName = TAKE(calls, names));
    info.objectHandle = (uint64_t)(uintptr_t)PICK(VkBuffer, calls, BUFFERS);
    if (kind % 3 == 1) {
        info.objectType = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
        info.objectHandle =
            (uint64_t)(uintptr_t)PICK(VkAccelerationStructureKHR, calls, STRUCTURES);
    } else if (kind % 3 == 2) {
        info.objectType = VK_OBJECT_TYPE_COMMAND_BUFFER;
        info.objectHandle = (uint64_t)(uintptr_t)pick_commands(calls);
    }
    calls->vk.SetDebugUtilsObjectNameEXT(calls->device, &info);
}

void call_answer(struct calls *calls)
{
    calls->answer = take(calls) % 2;
}

/* ---- destroyed */

/* A handle may be of an object that was destroyed before. If the driver gives handles out again, it
 * may be another object's by now, also one of the layer's own: a driver that is asked to destroy
 * that does so, with the layer or without, so no stream asks. */
#define DESTROY(name, type, kind, command)                                                         \
    void call_##name(struct calls *calls)                                                          \
    {                                                                                              \
        struct slot *slot = pick(calls, kind);                                                     \
        if (calls->recycles_handles && !slot->is_alive)                                            \
            return;                                                                                \
        calls->vk.command(calls->device, HANDLE_OF(type, slot), NULL);                             \
        slot->is_alive = false;                                                                    \
        slot->bytes = NULL;                                                                        \
    }

DESTROY(free_memory, VkDeviceMemory, MEMORIES, FreeMemory)
DESTROY(destroy_buffer, VkBuffer, BUFFERS, DestroyBuffer)
DESTROY(destroy_structure, VkAccelerationStructureKHR, STRUCTURES, DestroyAccelerationStructureKHR)
DESTROY(destroy_nv, VkAccelerationStructureNV, NV_STRUCTURES, DestroyAccelerationStructureNV)
DESTROY(destroy_micromap, VkMicromapEXT, MICROMAPS, DestroyMicromapEXT)
DESTROY(destroy_pool, VkCommandPool, POOLS, DestroyCommandPool)
DESTROY(destroy_query_pool, VkQueryPool, QUERY_POOLS, DestroyQueryPool)
