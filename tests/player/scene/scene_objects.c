/* SPDX-License-Identifier: Apache-2.0 */
/* Memory, buffers, acceleration structures and inputs of a scene. */
#include <stdlib.h>
#include <string.h>

#include "tests/fixture/dense_blocks.h"
#include "tests/player/scene/scene.h"

/* ---- ownership ---- */

void scene_defer(struct scene *scene, VkDevice device, uint64_t handle,
                 void (*destroy)(struct scene *scene, VkDevice device, uint64_t handle))
{
    if (scene->cleanup_count == SCENE_CLEANUPS)
        abort();
    scene->cleanups[scene->cleanup_count++] = (struct scene_cleanup){destroy, device, handle};
}

static struct scene_cleanup take_cleanup(struct scene *scene, uint64_t handle)
{
    for (uint32_t i = scene->cleanup_count; i-- > 0;) {
        const struct scene_cleanup cleanup = scene->cleanups[i];
        if (cleanup.handle != handle)
            continue;
        scene->cleanup_count--;
        memmove(&scene->cleanups[i], &scene->cleanups[i + 1],
                (scene->cleanup_count - i) * sizeof(cleanup));
        return cleanup;
    }
    abort();
}

void scene_destroy(struct scene *scene, uint64_t handle)
{
    const struct scene_cleanup cleanup = take_cleanup(scene, handle);
    cleanup.destroy(scene, cleanup.device, cleanup.handle);
}

void scene_forget(struct scene *scene, uint64_t handle)
{
    take_cleanup(scene, handle);
}

const VkuDeviceDispatchTable *scene_table_of(const struct scene *scene, VkDevice device)
{
    return device == scene->other_device ? &scene->other_vk : scene->vk;
}

SCENE_DESTROYS(free_memory, FreeMemory, VkDeviceMemory)
SCENE_CREATES(create_buffer, Buffer, VkBuffer, VkBufferCreateInfo)
SCENE_CREATES(create_accel, AccelerationStructureKHR, VkAccelerationStructureKHR,
              VkAccelerationStructureCreateInfoKHR)
SCENE_CREATES_BY(create_accel_at, CreateAccelerationStructure2KHR, AccelerationStructureKHR,
                 VkAccelerationStructureKHR, VkAccelerationStructureCreateInfo2KHR)

static void destroy_other_device(struct scene *scene, VkDevice device, uint64_t handle)
{
    (void)handle;
    scene->other_vk.DestroyDevice(device, NULL);
    scene->other_device = VK_NULL_HANDLE;
}

/* ---- memory ---- */

static uint32_t find_memory_type(const struct scene *scene, VkMemoryPropertyFlags properties)
{
    const VkPhysicalDeviceMemoryProperties *memory = &scene->fixture->memory;
    for (uint32_t i = 0; i < memory->memoryTypeCount; i++)
        if ((memory->memoryTypes[i].propertyFlags & properties) == properties)
            return i;
    return UINT32_MAX;
}

static struct test_memory allocate(struct scene *scene, VkDeviceSize size, uint32_t type,
                                   const void *chain)
{
    struct test_memory memory = {.size = size};
    const STRUCT(VkMemoryAllocateFlagsInfo, flags_info, .pNext = chain,
                 .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    const STRUCT(VkMemoryAllocateInfo, allocate_info,
                 .pNext = scene->fixture->setup.route == ROUTE_EXT ? chain : &flags_info,
                 .allocationSize = size, .memoryTypeIndex = type);
    const VkDevice device = scene->fixture->device;

    GET(scene->vk->AllocateMemory(device, &allocate_info, NULL, &memory.handle));
    scene_defer(scene, device, (uint64_t)memory.handle, free_memory);
    return memory;
}

struct test_memory scene_allocate_with(struct scene *scene, VkDeviceSize size,
                                       VkMemoryPropertyFlags properties, const void *chain)
{
    const uint32_t type = find_memory_type(scene, properties);

    if (type == UINT32_MAX) {
        scene_skip(scene, "no memory type of the wanted kind");
        return (struct test_memory){.size = size};
    }
    struct test_memory memory = allocate(scene, size, type, chain);
    if ((properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) != 0)
        GET(scene->vk->MapMemory(scene->fixture->device, memory.handle, 0, size, 0,
                                 (void **)&memory.bytes));
    return memory;
}

struct test_memory scene_allocate_of_type(struct scene *scene, VkDeviceSize size,
                                          uint32_t memory_type_bits)
{
    return allocate(scene, size, (uint32_t)__builtin_ctz(memory_type_bits), NULL);
}

struct test_memory scene_allocate(struct scene *scene, VkDeviceSize size)
{
    return scene_allocate_with(
        scene, size, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
        NULL);
}

/* ---- buffers ---- */

struct device_buffer scene_create_buffer_with(struct scene *scene,
                                              const VkBufferCreateInfo *create_info)
{
    return (struct device_buffer){.handle = create_buffer(scene, create_info),
                                  .size = create_info->size,
                                  .usage = create_info->usage};
}

struct device_buffer scene_create_buffer(struct scene *scene, VkDeviceSize size,
                                         VkBufferUsageFlags usage)
{
    const STRUCT(VkBufferCreateInfo, create_info, .size = size, .usage = usage);
    return scene_create_buffer_with(scene, &create_info);
}

VkDeviceAddress scene_buffer_address(struct scene *scene, VkBuffer buffer)
{
    const STRUCT(VkBufferDeviceAddressInfo, info, .buffer = buffer);
    const VkDevice device = scene->fixture->device;

    switch (scene->fixture->setup.route) {
    case ROUTE_KHR:
        return scene->vk->GetBufferDeviceAddressKHR(device, &info);
    case ROUTE_EXT:
        return scene->vk->GetBufferDeviceAddressEXT(device, &info);
    case ROUTE_CHAIN:
    case ROUTE_FEATURES2:
        break;
    }
    return scene->vk->GetBufferDeviceAddress(device, &info);
}

VkDeviceSize scene_buffer_memory_size(struct scene *scene, const struct device_buffer *buffer)
{
    VkMemoryRequirements requirements;
    scene->vk->GetBufferMemoryRequirements(scene->fixture->device, buffer->handle, &requirements);
    return requirements.size;
}

void scene_note_binding(struct scene *scene, struct device_buffer *buffer,
                        const struct test_memory *memory, VkDeviceSize offset)
{
    buffer->memory = memory->handle;
    buffer->bytes = memory->bytes != NULL ? memory->bytes + offset : NULL;
    if ((buffer->usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0)
        buffer->address = scene_buffer_address(scene, buffer->handle);
}

void scene_bind(struct scene *scene, struct device_buffer *buffer, const struct test_memory *memory,
                VkDeviceSize offset)
{
    if (memory->handle == VK_NULL_HANDLE)
        return;
    GET(scene->vk->BindBufferMemory(scene->fixture->device, buffer->handle, memory->handle,
                                    offset));
    scene_note_binding(scene, buffer, memory, offset);
}

static struct device_buffer bind_own(struct scene *scene, struct device_buffer buffer)
{
    const struct test_memory memory =
        scene_allocate(scene, scene_buffer_memory_size(scene, &buffer));
    scene_bind(scene, &buffer, &memory, 0);
    return buffer;
}

struct device_buffer scene_buffer(struct scene *scene, VkDeviceSize size, VkBufferUsageFlags usage)
{
    return bind_own(scene, scene_create_buffer(scene, size, usage));
}

struct device_buffer scene_buffer_of_flags2(struct scene *scene, VkDeviceSize size,
                                            VkBufferUsageFlags usage, VkBufferUsageFlags2 usage2)
{
    const STRUCT(VkBufferUsageFlags2CreateInfo, flags2, .usage = usage2);
    const STRUCT(VkBufferCreateInfo, create_info, .pNext = &flags2, .size = size, .usage = usage);
    struct device_buffer buffer = scene_create_buffer_with(scene, &create_info);
    buffer.usage |=
        VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT; /* so that its address is asked for */
    return bind_own(scene, buffer);
}

VkDeviceAddress scene_freed_address(struct scene *scene)
{
    const struct device_buffer buffer = scene_buffer(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
    scene_destroy(scene, (uint64_t)buffer.memory);
    return buffer.address;
}

VkDeviceAddress scene_destroyed_address(struct scene *scene)
{
    const struct device_buffer buffer = scene_buffer(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
    scene_destroy(scene, (uint64_t)buffer.handle);
    return buffer.address;
}

VkDeviceAddress scene_address_without_usage(struct scene *scene)
{
    return scene_buffer(scene, SCENE_MICROMAP_INPUT_SIZE, SCRATCH_USAGE).address;
}

struct device_buffer scene_dense_buffer(struct scene *scene, VkBufferUsageFlags2 usage)
{
    const struct device_buffer buffer = scene_buffer_of_flags2(
        scene, SCENE_BUFFER_SIZE, INPUT_USAGE, usage | VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT);
    dense_blocks_write(buffer.bytes, SCENE_BUFFER_SIZE / DENSE_BLOCK);
    return buffer;
}

/* ---- acceleration structures ---- */

VkAccelerationStructureKHR
scene_create_accel(struct scene *scene, const VkAccelerationStructureCreateInfoKHR *create_info)
{
    return create_accel(scene, create_info);
}

VkAccelerationStructureKHR scene_accel_at(struct scene *scene,
                                          const VkAccelerationStructureCreateInfo2KHR *create_info)
{
    return create_accel_at(scene, create_info);
}

static VkAccelerationStructureKHR opacity_micromap_in(struct scene *scene,
                                                      const struct device_buffer *buffer,
                                                      VkDeviceSize offset, VkDeviceSize size)
{
    const VkDeviceAddressRangeKHR range = {.address = buffer->address + offset, .size = size};
    return scene_accel_at(
        scene, &MAKE(VkAccelerationStructureCreateInfo2KHR, .addressRange = range,
                     .addressFlags = VK_ADDRESS_COMMAND_UNKNOWN_STORAGE_BUFFER_USAGE_BIT_KHR,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR));
}

VkAccelerationStructureKHR scene_accel_in(struct scene *scene, const struct device_buffer *buffer,
                                          VkDeviceSize offset, VkDeviceSize size,
                                          VkAccelerationStructureTypeKHR type)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, create_info, .buffer = buffer->handle,
                 .offset = offset, .size = size, .type = type);
    if (type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)
        return opacity_micromap_in(scene, buffer, offset, size);
    return scene_create_accel(scene, &create_info);
}

void scene_enter_other_device(struct scene *scene)
{
    struct fixture *fixture = scene->fixture;

    scene->own_device = fixture->device;
    if (scene->other_device == VK_NULL_HANDLE) {
        scene->other_device = fixture_create_device(fixture);
        vkuInitDeviceDispatchTable(scene->other_device, &scene->other_vk,
                                   fixture->instance.get_device_proc_addr);
        scene_defer(scene, scene->other_device, (uint64_t)(uintptr_t)scene->other_device,
                    destroy_other_device);
    }
    fixture->device = scene->other_device;
    scene->vk = &scene->other_vk;
}

void scene_leave_other_device(struct scene *scene)
{
    scene->fixture->device = scene->own_device;
    scene->vk = &scene->fixture->vk;
}

VkAccelerationStructureKHR scene_accel_of_other_device(struct scene *scene, uint32_t build)
{
    const struct device_buffer dst_buffer = scene->dst_buffers[build];

    scene_enter_other_device(scene);
    const VkAccelerationStructureKHR accel = scene_accel_for(scene, build);
    scene_leave_other_device(scene);
    scene->dst_buffers[build] = dst_buffer;
    return accel;
}

/* ---- sparse ---- */

struct device_buffer scene_sparse_buffer(struct scene *scene, VkDeviceSize size,
                                         VkBufferUsageFlags usage, VkBufferCreateFlags flags)
{
    const STRUCT(VkBufferCreateInfo, create_info,
                 .flags = VK_BUFFER_CREATE_SPARSE_BINDING_BIT | flags, .size = size,
                 .usage = usage);
    struct device_buffer buffer = scene_create_buffer_with(scene, &create_info);
    buffer.address = scene_buffer_address(scene, buffer.handle);
    return buffer;
}

/* ---- inputs, and builds that come before the call ---- */

static bool copies_inputs(const struct scene *scene)
{
    return scene->fixture->copies_inputs && !command_is_on_host(scene->command);
}

static struct device_buffer device_local_buffer(struct scene *scene, VkDeviceSize size,
                                                VkBufferUsageFlags usage)
{
    struct device_buffer buffer =
        scene_create_buffer(scene, size, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    const struct test_memory memory = scene_allocate_with(
        scene, scene_buffer_memory_size(scene, &buffer), VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, NULL);
    scene_bind(scene, &buffer, &memory, 0);
    return buffer;
}

struct device_buffer scene_input(struct scene *scene, VkDeviceSize size, VkBufferUsageFlags usage)
{
    if (!copies_inputs(scene))
        return scene_buffer(scene, size, usage);
    struct device_buffer buffer = device_local_buffer(scene, size, usage);
    const struct device_buffer source = scene_buffer(scene, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    if (scene->input_count == SCENE_INPUTS_MAX)
        abort();
    scene->inputs[scene->input_count++] =
        (struct scene_input_copy){source.handle, buffer.handle, size};
    buffer.bytes = source.bytes;
    return buffer;
}

void scene_barrier(struct scene *scene, VkCommandBuffer command_buffer)
{
    commands_barrier(scene->vk, command_buffer);
}

void scene_inputs_copy(struct scene *scene, VkCommandBuffer command_buffer)
{
    if (!copies_inputs(scene))
        return;
    scene_barrier(scene, command_buffer);
    for (uint32_t i = 0; i < scene->input_count; i++) {
        const struct scene_input_copy *copy = &scene->inputs[i];
        const VkBufferCopy region = {0, 0, copy->size};
        scene->vk->CmdCopyBuffer(command_buffer, copy->source, copy->buffer, 1, &region);
    }
    scene_barrier(scene, command_buffer);
}

VkCommandBuffer scene_begin_before(struct scene *scene)
{
    const VkCommandBuffer command_buffer =
        copies_inputs(scene) ? scene_begin_own(scene) : scene->command_buffer;
    scene_inputs_copy(scene, command_buffer);
    return command_buffer;
}

void scene_end_before(struct scene *scene, VkCommandBuffer command_buffer)
{
    scene_barrier(scene, command_buffer);
    if (command_buffer != scene->command_buffer)
        scene_run(scene, command_buffer);
}
