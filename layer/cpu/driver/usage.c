/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: buffer usage. Usage of ray tracing is removed, because the driver does
 * not support it. Transfer usage is added to these buffers and to all with device addresses,
 * because the backend copies from and to them. */
#include "observers.h"
#include "src/base/block.h"
#include "src/base/chain.h"

static const VkBufferUsageFlags2 RAY_TRACING_USAGE =
    VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
    VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
    VK_BUFFER_USAGE_2_SHADER_BINDING_TABLE_BIT_KHR | VK_BUFFER_USAGE_2_MICROMAP_STORAGE_BIT_EXT |
    VK_BUFFER_USAGE_2_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT |
    VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX;

/* The bits of VkBufferUsageFlags are the lowest ones of VkBufferUsageFlags2. */
static VkBufferUsageFlags2 usage_below(VkBufferUsageFlags2 usage)
{
    if (!(usage & (RAY_TRACING_USAGE | VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT)))
        return usage;
    return (usage & ~RAY_TRACING_USAGE) | VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT |
           VK_BUFFER_USAGE_2_TRANSFER_DST_BIT;
}

/* Translates the usage of a structure that has pNext and usage. The caller ends the copy. Without
 * memory the chain stays unchanged. */
static VkResult usage_begin(struct chain_copy *copy, const void **chain, VkBufferUsageFlags *usage)
{
    *usage = (VkBufferUsageFlags)usage_below(*usage);
    VkResult result =
        chain_copy_begin(copy, *chain, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO);
    if (result != VK_SUCCESS)
        return result;
    VkBufferUsageFlags2CreateInfo *flags2 = copy->found;
    if (flags2)
        flags2->usage = usage_below(flags2->usage);
    *chain = copy->first;
    return VK_SUCCESS;
}

VkResult cpu_create_buffer(PFN_vkCreateBuffer down, VkDevice device,
                           const VkBufferCreateInfo *create_info,
                           const VkAllocationCallbacks *allocator, VkBuffer *buffer)
{
    VkBufferCreateInfo below = *create_info;
    struct chain_copy copy;
    VkResult result = usage_begin(&copy, &below.pNext, &below.usage);
    if (result == VK_SUCCESS)
        result = down(device, &below, allocator, buffer);
    chain_copy_end(&copy);
    return result;
}

void cpu_get_requirements(PFN_vkGetDeviceBufferMemoryRequirements down, VkDevice device,
                          const VkDeviceBufferMemoryRequirements *requested,
                          VkMemoryRequirements2 *requirements)
{
    VkDeviceBufferMemoryRequirements info = *requested;
    VkBufferCreateInfo below = *requested->pCreateInfo;
    struct chain_copy copy;
    info.pCreateInfo = &below;
    usage_begin(&copy, &below.pNext, &below.usage);
    down(device, &info, requirements);
    chain_copy_end(&copy);
}

void cpu_get_external_buffer(PFN_vkGetPhysicalDeviceExternalBufferProperties down,
                             VkPhysicalDevice physical_device,
                             const VkPhysicalDeviceExternalBufferInfo *info,
                             VkExternalBufferProperties *properties)
{
    VkPhysicalDeviceExternalBufferInfo below = *info;
    struct chain_copy copy;
    usage_begin(&copy, &below.pNext, &below.usage);
    down(physical_device, &below, properties);
    chain_copy_end(&copy);
}

/* Without memory the call goes down unchanged. */
void cpu_bind_descriptor_buffers(PFN_vkCmdBindDescriptorBuffersEXT down, VkCommandBuffer commands,
                                 uint32_t count, const VkDescriptorBufferBindingInfoEXT *infos)
{
    VkDescriptorBufferBindingInfoEXT *below;
    struct chain_copy *copies;
    struct block block;
    if (!block_begin(&block,
                     block_size(count, sizeof(*below)) + block_size(count, sizeof(*copies)))) {
        down(commands, count, infos);
        return;
    }
    below = block_copy(&block, infos, count, sizeof(*below));
    copies = block_take(&block, count, sizeof(*copies));
    for (uint32_t i = 0; i < count; i++)
        usage_begin(&copies[i], &below[i].pNext, &below[i].usage);
    down(commands, count, below);
    for (uint32_t i = 0; i < count; i++)
        chain_copy_end(&copies[i]);
    block_end(&block);
}
