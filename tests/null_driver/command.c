/* SPDX-License-Identifier: Apache-2.0 */
/* Command pools and the command buffers allocated from them. */
#include "internal.h"

VkResult null_CreateCommandPool(VkDevice device, const VkCommandPoolCreateInfo *pCreateInfo,
                                const VkAllocationCallbacks *pAllocator,
                                VkCommandPool *pCommandPool)
{
    ENTER_OR_FAIL(CreateCommandPool);
    (void)pCreateInfo;
    (void)pAllocator;
    struct object *pool = object_create(OBJECT(device), TYPE_COMMAND_POOL, NULL);
    if (pool == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    *pCommandPool = HANDLE(VkCommandPool, pool->handle);
    return VK_SUCCESS;
}

void null_DestroyCommandPool(VkDevice device, VkCommandPool commandPool,
                             const VkAllocationCallbacks *pAllocator)
{
    ENTER(DestroyCommandPool);
    (void)device;
    (void)pAllocator;
    object_destroy(RAW(commandPool), TYPE_COMMAND_POOL);
}

static void free_command_buffers(uint32_t count, const VkCommandBuffer *buffers)
{
    for (uint32_t i = 0; i < count; i++)
        object_destroy_dispatchable(buffers[i], TYPE_COMMAND_BUFFER);
}

VkResult null_AllocateCommandBuffers(VkDevice device,
                                     const VkCommandBufferAllocateInfo *pAllocateInfo,
                                     VkCommandBuffer *pCommandBuffers)
{
    ENTER_OR_FAIL(AllocateCommandBuffers);
    (void)device;
    struct object *pool = object_find(RAW(pAllocateInfo->commandPool), TYPE_COMMAND_POOL);
    if (pool == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < pAllocateInfo->commandBufferCount; i++) {
        pCommandBuffers[i] =
            (VkCommandBuffer)object_create(pool, TYPE_COMMAND_BUFFER, transfers_release);
        if (pCommandBuffers[i] == VK_NULL_HANDLE) {
            free_command_buffers(i, pCommandBuffers);
            memset(pCommandBuffers, 0, pAllocateInfo->commandBufferCount * sizeof(VkCommandBuffer));
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        }
    }
    return VK_SUCCESS;
}

void null_FreeCommandBuffers(VkDevice device, VkCommandPool commandPool,
                             uint32_t commandBufferCount, const VkCommandBuffer *pCommandBuffers)
{
    ENTER(FreeCommandBuffers);
    (void)device;
    (void)commandPool;
    free_command_buffers(commandBufferCount, pCommandBuffers);
}
