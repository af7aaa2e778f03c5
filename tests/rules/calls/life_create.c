/* SPDX-License-Identifier: Apache-2.0 */
/* Creation of structures and micromaps. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

/* Creates the object of the call in another buffer. */
static void create_in(struct scene *scene, const struct device_buffer *buffer)
{
    scene->life.create.buffer = scene->life.create_micromap.buffer = buffer->handle;
    scene->life.create_at.addressRange.address = buffer->address;
}

static void create_with_usage(struct scene *scene, VkBufferUsageFlags usage)
{
    const struct device_buffer buffer =
        scene_buffer(scene, 4096, usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    create_in(scene, &buffer);
}

static void create_in_sparse_buffer(struct scene *scene, VkBufferCreateFlags flags)
{
    const struct device_buffer buffer = scene_sparse_buffer(
        scene, 1 << 16, place_usage(scene) & ~(VkFlags)VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, flags);
    create_in(scene, &buffer);
}

static void create_in_protected_buffer(struct scene *scene)
{
    const STRUCT(VkBufferCreateInfo, info, .flags = VK_BUFFER_CREATE_PROTECTED_BIT, .size = 4096,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    struct device_buffer buffer = scene_create_buffer_with(scene, &info);
    const struct test_memory memory =
        scene_allocate_with(scene, 4096, VK_MEMORY_PROPERTY_PROTECTED_BIT, NULL);
    scene_bind(scene, &buffer, &memory, 0);
    create_in(scene, &buffer);
}

static void chain_captured_data(struct scene *scene)
{
    static const uint64_t data[8];
    static const VkOpaqueCaptureDescriptorDataCreateInfoEXT captured = {
        .sType = VK_STRUCTURE_TYPE_OPAQUE_CAPTURE_DESCRIPTOR_DATA_CREATE_INFO_EXT,
        .opaqueCaptureDescriptorData = data};
    scene->life.create.pNext = scene->life.create_at.pNext = &captured;
}

#include "created.inc"
