/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers: creation, binding and addresses. Images, which have no contents. Memory for both. */
#include "tests/null_driver/internal.h"

#include <stdlib.h>

/* Other buffers have the addresses of the memory that they are bound to. */
enum {
    OWN_ADDRESS =
        VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT
};

static void release_buffer(struct object *buffer)
{
    while (buffer->buffer.bindings != NULL) {
        struct binding *binding = buffer->buffer.bindings;
        buffer->buffer.bindings = binding->next;
        free(binding);
    }
    if (buffer->buffer.flags & OWN_ADDRESS) {
        address_remove_object(buffer);
        address_release(buffer->config, buffer->buffer.address, buffer->buffer.size);
    }
}

/* Until it is bound, or for good with OWN_ADDRESS; 0 where it gets one from memory alone. */
static VkDeviceAddress first_address(const struct null_driver_config *config,
                                     const VkBufferCreateInfo *info)
{
    const VkBufferOpaqueCaptureAddressCreateInfo *opaque =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_BUFFER_OPAQUE_CAPTURE_ADDRESS_CREATE_INFO);
    const VkBufferDeviceAddressCreateInfoEXT *address =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_CREATE_INFO_EXT);
    if (opaque != NULL && opaque->opaqueCaptureAddress != 0)
        return opaque->opaqueCaptureAddress;
    if (address != NULL && address->deviceAddress != 0)
        return address->deviceAddress;
    if (info->flags & OWN_ADDRESS)
        return address_allocate(config, info->size);
    return info->usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT
               ? address_allocate(NULL, info->size)
               : 0;
}

ON_CREATION(CreateBuffer)
{
    const VkBufferUsageFlags2CreateInfo *flags2 =
        chain_find(pCreateInfo->pNext, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO);
    object->buffer.usage = flags2 != NULL ? flags2->usage : pCreateInfo->usage;
    object->release = release_buffer;
    object->buffer.size = pCreateInfo->size;
    object->buffer.flags = pCreateInfo->flags;
    object->buffer.address = first_address(object->config, pCreateInfo);
    if (pCreateInfo->flags & OWN_ADDRESS)
        address_add_object(object, object->buffer.address, object->buffer.size);
}

void buffer_bind(struct object *buffer, const struct binding *binding)
{
    struct binding *copy = driver_allocate(NULL, sizeof(*copy));
    if (copy == NULL)
        return;
    *copy = *binding;
    copy->next = buffer->buffer.bindings;
    buffer->buffer.bindings = copy;
}

unsigned char *buffer_bytes(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize *size)
{
    const struct object *object = FIND(BUFFER, buffer);
    const struct binding *binding = object != NULL ? object->buffer.bindings : NULL;
    for (; binding != NULL; binding = binding->next) {
        if (offset >= binding->offset && offset - binding->offset < binding->size)
            break;
        /* An older one counts only up to where a newer one begins. */
        if (offset<binding->offset && * size> binding->offset - offset)
            *size = binding->offset - offset;
    }
    struct object *memory =
        binding != NULL ? object_find(binding->memory, VK_OBJECT_TYPE_DEVICE_MEMORY) : NULL;
    if (memory == NULL)
        return NULL;
    const VkDeviceSize inside = offset - binding->offset;
    if (*size > binding->size - inside)
        *size = binding->size - inside;
    return memory_bytes(memory, binding->memory_offset + inside, size);
}

bool buffer_has_usage(VkBuffer buffer, VkBufferUsageFlags2 usage)
{
    const struct object *object = FIND(BUFFER, buffer);
    return !buffer || (object != NULL && (object->buffer.usage & usage) == usage);
}

struct usage_at {
    VkDeviceAddress address;
    VkBufferUsageFlags2 usage;
};

static bool has_usage_at(const struct object *buffer, const void *wanted)
{
    const struct usage_at *at = wanted;
    return at->usage == (buffer->buffer.usage & at->usage) && buffer->buffer.address != 0 &&
           at->address >= buffer->buffer.address &&
           at->address - buffer->buffer.address < buffer->buffer.size;
}

bool address_has_usage(VkDeviceAddress address, VkBufferUsageFlags2 usage)
{
    return object_any(VK_OBJECT_TYPE_BUFFER, has_usage_at, &(struct usage_at){address, usage});
}

static void bind(VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize offset)
{
    struct object *to = FIND(BUFFER, buffer);
    const struct object *from = FIND(DEVICE_MEMORY, memory);
    if (to == NULL || from == NULL || to->buffer.flags & VK_BUFFER_CREATE_SPARSE_BINDING_BIT)
        return;
    if (!(to->buffer.flags & OWN_ADDRESS))
        to->buffer.address = from->memory.address + offset;
    buffer_bind(to, &(struct binding){
                        .size = to->buffer.size, .memory = RAW(memory), .memory_offset = offset});
}

COMMAND(BindBufferMemory)
{
    bind(buffer, memory, memoryOffset);
    return VK_SUCCESS;
}

COMMAND(BindBufferMemory2)
{
    for (uint32_t i = 0; i < bindInfoCount; i++)
        bind(pBindInfos[i].buffer, pBindInfos[i].memory, pBindInfos[i].memoryOffset);
    return VK_SUCCESS;
}

/* ---- memory requirements of buffers, and which memory types suit what */

uint32_t requirements_types(const struct null_driver_config *config, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags refused)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < config->memory.memoryTypeCount; i++) {
        const VkMemoryPropertyFlags flags = config->memory.memoryTypes[i].propertyFlags;
        if ((flags & required) == required && (flags & refused) == 0)
            bits |= 1u << i;
    }
    return bits;
}

static VkMemoryRequirements requirements_of_size(const struct null_driver_config *config,
                                                 VkDeviceSize size, VkBufferCreateFlags flags)
{
    const VkMemoryPropertyFlags protected = VK_MEMORY_PROPERTY_PROTECTED_BIT;
    const VkMemoryPropertyFlags lazy = VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT;
    const VkDeviceSize alignment = flags & VK_BUFFER_CREATE_SPARSE_BINDING_BIT ? 65536 : 256;
    return (VkMemoryRequirements){
        .size = align_up(size, alignment),
        .alignment = alignment,
        .memoryTypeBits = flags & VK_BUFFER_CREATE_PROTECTED_BIT
                              ? requirements_types(config, protected, lazy)
                              : requirements_types(config, 0, protected | lazy),
    };
}

COMMAND(GetBufferMemoryRequirements2)
{
    const struct object *object = FIND(BUFFER, pInfo->buffer);
    pMemoryRequirements->memoryRequirements =
        object != NULL
            ? requirements_of_size(CONFIG(device), object->buffer.size, object->buffer.flags)
            : (VkMemoryRequirements){0};
}

/* ---- images: created, measured, bound */

static VkMemoryRequirements requirements_of_info(const struct null_driver_config *config,
                                                 const VkImageCreateInfo *info)
{
    const VkExtent3D *extent = &info->extent;
    /* 16 bytes a texel and twice the first level are enough for any format with all its levels. */
    const VkDeviceSize texels =
        (VkDeviceSize)extent->width * extent->height * extent->depth * info->arrayLayers;
    const bool protected = info->flags & VK_IMAGE_CREATE_PROTECTED_BIT;
    const bool transient = info->usage & VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT;
    const VkMemoryPropertyFlags required = protected ? VK_MEMORY_PROPERTY_PROTECTED_BIT : 0;
    const VkMemoryPropertyFlags refused = (protected ? 0 : VK_MEMORY_PROPERTY_PROTECTED_BIT) |
                                          (transient ? 0 : VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT);
    return (VkMemoryRequirements){
        .size = align_up(texels * 32 * (info->samples != 0 ? info->samples : 1), 65536),
        .alignment = 65536,
        .memoryTypeBits = requirements_types(config, required, refused),
    };
}

ON_CREATION(CreateImage)
{
    object->image = requirements_of_info(object->config, pCreateInfo);
}

static VkMemoryRequirements requirements_of(VkImage image)
{
    const struct object *object = FIND(IMAGE, image);
    return object != NULL ? object->image : (VkMemoryRequirements){0};
}

COMMAND(GetImageMemoryRequirements2)
{
    pMemoryRequirements->memoryRequirements = requirements_of(pInfo->image);
}
