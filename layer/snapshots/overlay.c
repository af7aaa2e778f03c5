/* SPDX-License-Identifier: Apache-2.0 */
/* The overlay on a device: creation, destruction, and the commands that it replaces. */
#include "layer/snapshots/snapshots.h"

#include <stdlib.h>
#include <string.h>

#include "layer/assay.h"
#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/executions.h"
#include "layer/snapshots/guard/references.h"
#include "layer/snapshots/marks.h"
#include "observers.h"
#include "src/base/chain.h"

/* The loader's function for dispatchable objects that a layer creates for itself. */
static PFN_vkSetDeviceLoaderData find_loader_data_setter(const VkDeviceCreateInfo *create_info)
{
    for (const VkBaseInStructure *s = create_info->pNext; s; s = s->pNext) {
        const VkLayerDeviceCreateInfo *info = (const VkLayerDeviceCreateInfo *)s;
        if (s->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO &&
            info->function == VK_LOADER_DATA_CALLBACK)
            return info->u.pfnSetDeviceLoaderData;
    }
    return NULL;
}

static bool enables_addresses(const VkDeviceCreateInfo *create_info)
{
    const VkPhysicalDeviceVulkan12Features *core =
        chain_find(create_info->pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
    const VkPhysicalDeviceBufferDeviceAddressFeatures *own = chain_find(
        create_info->pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES);
    return (core && core->bufferDeviceAddress) || (own && own->bufferDeviceAddress);
}

/* Whether level content needs snapshots. Device groups are excluded: each device of the group would
 * copy to the same host memory. */
static bool level_needs_snapshots(const struct layer_device *device)
{
    bool builds =
        device->facts.extension.acceleration_structure || device->facts.extension.ray_tracing_nv;
    if (device->level < LEVEL_CONTENT || !builds)
        return false;
    if (device->facts.is_group)
        reporter_warn(device->instance->reporter,
                      "assay_validation.level = content does not check the input data of device "
                      "builds on a group of physical devices.");
    return !device->facts.is_group;
}

VkResult snapshots_create(struct layer_device *device, const VkDeviceCreateInfo *create_info,
                          const VkuDeviceDispatchTable *below_backend)
{
    const struct settings *settings = reporter_settings(device->instance->reporter);
    if (!below_backend && !level_needs_snapshots(device))
        return VK_SUCCESS;
    const uint64_t budget =
        below_backend ? UINT64_MAX : (uint64_t)settings->content_budget_mib << 20;
    struct snapshots *snapshots = calloc(1, sizeof(*snapshots));
    if (!snapshots)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&snapshots->queue_lock, NULL);
    pthread_mutex_init(&snapshots->executions_lock, NULL);
    pthread_mutex_init(&snapshots->tickets_lock, NULL);
    pthread_mutex_init(&snapshots->buffers_lock, NULL);
    pthread_mutex_init(&snapshots->pools_lock, NULL);
    snapshots->device = device;
    snapshots->are_for_backend = below_backend;
    snapshots->are_for_rules = !below_backend && !settings->capture;
    snapshots->next = below_backend ? *below_backend : device->vk;
    snapshots->submits_itself = below_backend || settings->compare_rays;
    snapshots->has_addresses =
        enables_addresses(create_info) &&
        (device->vk.GetBufferDeviceAddress || device->vk.GetBufferDeviceAddressKHR);
    snapshots->set_loader_data = find_loader_data_setter(create_info);
    device->snapshots = snapshots;
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                                     VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    if (staging_create(device, budget, usage, true, &snapshots->staging) != VK_SUCCESS ||
        guard_create(device, budget, &snapshots->guard) != VK_SUCCESS ||
        word_pool_create(device, &snapshots->words) != VK_SUCCESS ||
        own_shaders_create(device, &snapshots->shaders) != VK_SUCCESS)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    snapshots->down = device->vk;
    commands_cover_with_snapshots(&device->vk);
    return VK_SUCCESS;
}

void snapshots_destroy(struct snapshots *snapshots)
{
    if (!snapshots)
        return;
    warn_missed(snapshots->device, &(struct missed_executions){.held = snapshots->held});
    tickets_destroy(snapshots);
    staging_destroy(snapshots->staging);
    word_pool_destroy(snapshots->words);
    own_shaders_destroy(snapshots->shaders);
    guard_destroy(snapshots->guard);
    snapshots_release_queues(snapshots);
    handle_table_release(&snapshots->copyable);
    handle_table_release(&snapshots->uncounting_pools);
    pthread_mutex_destroy(&snapshots->buffers_lock);
    pthread_mutex_destroy(&snapshots->pools_lock);
    pthread_mutex_destroy(&snapshots->queue_lock);
    pthread_mutex_destroy(&snapshots->executions_lock);
    pthread_mutex_destroy(&snapshots->tickets_lock);
    free(snapshots);
}

VKAPI_ATTR void VKAPI_CALL snapshots_GetCountersASSAY(VkDevice device, size_t size,
                                                      AssayCounters *counters)
{
    const AssayCounters now = {.bytesSnapshot = atomic_load(&snapshots_of(device)->bytes_copied)};
    memset(counters, 0, size);
    memcpy(counters, &now, size < sizeof(now) ? size : sizeof(now));
}
