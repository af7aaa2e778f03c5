/* SPDX-License-Identifier: Apache-2.0 */
/* Memory requirements of buffers, and which memory types suit what. */
#include "tests/null_driver/internal.h"

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

static VkMemoryRequirements requirements(const struct null_driver_config *config, VkDeviceSize size,
                                         VkBufferCreateFlags flags)
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
        object != NULL ? requirements(CONFIG(device), object->buffer.size, object->buffer.flags)
                       : (VkMemoryRequirements){0};
}
