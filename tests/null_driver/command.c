/* SPDX-License-Identifier: Apache-2.0 */
/* Command pools and the command buffers allocated from them. */
#include "internal.h"

static void free_command_buffers(uint32_t count, const VkCommandBuffer *buffers)
{
    for (uint32_t i = 0; i < count; i++)
        object_destroy_dispatchable(buffers[i], VK_OBJECT_TYPE_COMMAND_BUFFER);
}

VkResult null_AllocateCommandBuffers(VkDevice device,
                                     const VkCommandBufferAllocateInfo *pAllocateInfo,
                                     VkCommandBuffer *pCommandBuffers)
{
    struct object *pool = FIND(COMMAND_POOL, pAllocateInfo->commandPool);
    if (pool == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < pAllocateInfo->commandBufferCount; i++) {
        pCommandBuffers[i] =
            (VkCommandBuffer)object_create(pool, VK_OBJECT_TYPE_COMMAND_BUFFER, transfers_release);
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
    free_command_buffers(commandBufferCount, pCommandBuffers);
}
