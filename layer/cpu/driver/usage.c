/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: buffer usage. Usage of ray tracing is removed, because the driver does
 * not support it. Transfer usage is added to these buffers and to all with device addresses,
 * because the backend copies from and to them. */
#include "layer/cpu/advertise.h"
#include "layer/cpu/driver/block.h"
#include "layer/cpu/overlay.h"
#include "observers.h"
#include "src/base/chain_copy.h"

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

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateBuffer(VkDevice device,
                                                const VkBufferCreateInfo *pCreateInfo,
                                                const VkAllocationCallbacks *pAllocator,
                                                VkBuffer *pBuffer)
{
    VkBufferCreateInfo below = *pCreateInfo;
    struct chain_copy copy;
    VkResult result = usage_begin(&copy, &below.pNext, &below.usage);
    if (result == VK_SUCCESS)
        result = cpu_next(device)->CreateBuffer(device, &below, pAllocator, pBuffer);
    chain_copy_end(&copy);
    return result;
}

/* A command and its alias differ only in which command of the next layer they call. */
#define DEFINE_GET_REQUIREMENTS(name)                                                              \
    VKAPI_ATTR void VKAPI_CALL cpu_##name(VkDevice device,                                         \
                                          const VkDeviceBufferMemoryRequirements *pInfo,           \
                                          VkMemoryRequirements2 *pMemoryRequirements)              \
    {                                                                                              \
        VkDeviceBufferMemoryRequirements info = *pInfo;                                            \
        VkBufferCreateInfo below = *pInfo->pCreateInfo;                                            \
        struct chain_copy copy;                                                                    \
        info.pCreateInfo = &below;                                                                 \
        usage_begin(&copy, &below.pNext, &below.usage);                                            \
        cpu_next(device)->name(device, &info, pMemoryRequirements);                                \
        chain_copy_end(&copy);                                                                     \
    }

DEFINE_GET_REQUIREMENTS(GetDeviceBufferMemoryRequirements)
DEFINE_GET_REQUIREMENTS(GetDeviceBufferMemoryRequirementsKHR)

#define DEFINE_GET_EXTERNAL(name)                                                                  \
    VKAPI_ATTR void VKAPI_CALL cpu_##name(                                                         \
        VkPhysicalDevice physicalDevice,                                                           \
        const VkPhysicalDeviceExternalBufferInfo *pExternalBufferInfo,                             \
        VkExternalBufferProperties *pExternalBufferProperties)                                     \
    {                                                                                              \
        struct layer_instance *instance = layer_find_instance(physicalDevice);                     \
        VkPhysicalDeviceExternalBufferInfo below = *pExternalBufferInfo;                           \
        struct chain_copy copy = {0};                                                              \
        if (cpu_advertises(instance, physicalDevice))                                              \
            usage_begin(&copy, &below.pNext, &below.usage);                                        \
        instance->next.name(physicalDevice, &below, pExternalBufferProperties);                    \
        chain_copy_end(&copy);                                                                     \
    }

DEFINE_GET_EXTERNAL(GetPhysicalDeviceExternalBufferProperties)
DEFINE_GET_EXTERNAL(GetPhysicalDeviceExternalBufferPropertiesKHR)

/* Without memory the call goes down unchanged. */
VKAPI_ATTR void VKAPI_CALL
cpu_CmdBindDescriptorBuffersEXT(VkCommandBuffer commandBuffer, uint32_t bufferCount,
                                const VkDescriptorBufferBindingInfoEXT *pBindingInfos)
{
    const VkuDeviceDispatchTable *next = cpu_next_of_recording(commandBuffer);
    VkDescriptorBufferBindingInfoEXT *below;
    struct chain_copy *copies;
    struct block block;
    if (!next)
        return;
    if (!block_begin(&block, block_size(bufferCount, sizeof(*below)) +
                                 block_size(bufferCount, sizeof(*copies)))) {
        next->CmdBindDescriptorBuffersEXT(commandBuffer, bufferCount, pBindingInfos);
        return;
    }
    below = block_copy(&block, pBindingInfos, bufferCount, sizeof(*below));
    copies = block_take(&block, bufferCount, sizeof(*copies));
    for (uint32_t i = 0; i < bufferCount; i++)
        usage_begin(&copies[i], &below[i].pNext, &below[i].usage);
    next->CmdBindDescriptorBuffersEXT(commandBuffer, bufferCount, below);
    for (uint32_t i = 0; i < bufferCount; i++)
        chain_copy_end(&copies[i]);
    block_end(&block);
}
