/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers that vkCmdBuildAccelerationStructureNV may read. VK_BUFFER_USAGE_TRANSFER_SRC_BIT is
 * added to their usage, so that their data can be copied. Other builds read by address, and a
 * shader of the layer's own copies their data. */
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/chain_copy.h"

/* ---- which */

static VkBufferUsageFlags2 usage_of(const VkBufferCreateInfo *info)
{
    const VkBufferUsageFlags2CreateInfo *flags2 =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO);
    return flags2 ? flags2->usage : info->usage;
}

/* Whether the layer may change a buffer's usage. External memory is shared with other processes,
 * and capture and replay need the same usage. Sparse and protected buffers are not copied, so they
 * need no usage. */
static bool may_change_usage(const VkBufferCreateInfo *info)
{
    const VkBufferCreateFlags special = VK_BUFFER_CREATE_SPARSE_BINDING_BIT |
                                        VK_BUFFER_CREATE_PROTECTED_BIT |
                                        VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT |
                                        VK_BUFFER_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT;
    const VkExternalMemoryBufferCreateInfo *external =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO);
    return !(info->flags & special) && !(external && external->handleTypes);
}

static bool is_nv_input(const struct layer_device *device, VkBufferUsageFlags2 usage)
{
    return device->facts.extension.ray_tracing_nv &&
           (usage & VK_BUFFER_USAGE_2_SHADER_BINDING_TABLE_BIT_KHR);
}

static bool needs_usage(const struct layer_device *device, const VkBufferCreateInfo *info)
{
    VkBufferUsageFlags2 usage = usage_of(info);
    return !(usage & VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT) && may_change_usage(info) &&
           is_nv_input(device, usage);
}

/* Copies the creation parameters and adds the usage. The caller ends the copy of the chain. Returns
 * false without memory. */
static bool add_usage(const VkBufferCreateInfo *info, VkBufferCreateInfo *below,
                      struct chain_copy *copy)
{
    *below = *info;
    if (chain_copy_begin(copy, info->pNext, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO) !=
        VK_SUCCESS)
        return false;
    VkBufferUsageFlags2CreateInfo *flags2 = copy->found;
    if (flags2)
        flags2->usage |= VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT;
    else
        below->usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    below->pNext = copy->first;
    return true;
}

/* ---- which can be copied from */

static void note(struct snapshots *snapshots, VkBuffer buffer, bool is_copyable)
{
    uint64_t handle = (uint64_t)(uintptr_t)buffer;
    pthread_mutex_lock(&snapshots->buffers_lock);
    if (is_copyable)
        handle_table_set(&snapshots->copyable, handle, snapshots);
    else
        handle_table_remove(&snapshots->copyable, handle);
    pthread_mutex_unlock(&snapshots->buffers_lock);
}

bool snapshots_can_copy(struct snapshots *snapshots, VkBuffer buffer)
{
    if (snapshots->are_for_backend)
        return true;
    pthread_mutex_lock(&snapshots->buffers_lock);
    bool can = handle_table_find(&snapshots->copyable, (uint64_t)(uintptr_t)buffer);
    pthread_mutex_unlock(&snapshots->buffers_lock);
    return can;
}

static bool can_copy(const VkBufferCreateInfo *info)
{
    const VkBufferCreateFlags special =
        VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_PROTECTED_BIT;
    return (usage_of(info) & VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT) && !(info->flags & special);
}

VkResult snapshots_create_buffer(struct layer_device *device, PFN_vkCreateBuffer create,
                                 const VkBufferCreateInfo *info,
                                 const VkAllocationCallbacks *allocator, VkBuffer *buffer)
{
    VkBufferCreateInfo below;
    struct chain_copy copy = {0};
    if (needs_usage(device, info) && add_usage(info, &below, &copy))
        info = &below;
    VkResult result = create(device->handle, info, allocator, buffer);
    if (result == VK_SUCCESS && can_copy(info))
        note(device->snapshots, *buffer, true);
    chain_copy_end(&copy);
    return result;
}

void snapshots_forget_buffer(struct layer_device *device, VkBuffer buffer)
{
    note(device->snapshots, buffer, false);
}

void snapshots_get_requirements(struct layer_device *device,
                                PFN_vkGetDeviceBufferMemoryRequirements get,
                                const VkDeviceBufferMemoryRequirements *info,
                                VkMemoryRequirements2 *requirements)
{
    VkDeviceBufferMemoryRequirements own = *info;
    VkBufferCreateInfo below;
    struct chain_copy copy = {0};
    if (needs_usage(device, info->pCreateInfo) && add_usage(info->pCreateInfo, &below, &copy))
        own.pCreateInfo = &below;
    get(device->handle, &own, requirements);
    chain_copy_end(&copy);
}
