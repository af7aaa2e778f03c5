/* SPDX-License-Identifier: Apache-2.0 */
/* Staging memory: chunks of a buffer and an allocation each, mapped as long as they live. */
#include "snapshots/staging.h"

#include <pthread.h>
#include <stdlib.h>

/* Large enough that a command buffer of small builds needs one; kept when given back, up to: */
#define CHUNK_SIZE ((uint64_t)256 << 10)
#define KEPT_MAX ((uint64_t)64 << 20)
/* A kept chunk is used for what needs no less than a part of it. */
#define KEPT_FACTOR 4

struct staging {
    struct layer_device *device;
    pthread_mutex_t lock; /* guards the rest; nothing is called under it */
    struct staging_chunk *kept;
    uint64_t kept_size;
    uint64_t size; /* of all there are */
    uint64_t budget;
};

VkResult staging_create(struct layer_device *device, uint64_t budget, struct staging **staging)
{
    *staging = calloc(1, sizeof(**staging));
    if (!*staging)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*staging)->device = device;
    (*staging)->budget = budget;
    pthread_mutex_init(&(*staging)->lock, NULL);
    return VK_SUCCESS;
}

static void free_chunk(const struct layer_device *device, struct staging_chunk *chunk)
{
    const VkuDeviceDispatchTable *next = &device->snapshots->next;
    next->DestroyBuffer(device->handle, chunk->buffer, NULL);
    next->FreeMemory(device->handle, chunk->memory, NULL);
    free(chunk);
}

void staging_destroy(struct staging *staging)
{
    if (!staging)
        return;
    while (staging->kept) {
        struct staging_chunk *chunk = staging->kept;
        staging->kept = chunk->next;
        free_chunk(staging->device, chunk);
    }
    pthread_mutex_destroy(&staging->lock);
    free(staging);
}

/* A type that the host reads quickly, if there is one; a coherent one there always is. */
static uint32_t memory_type(const struct layer_device *device, uint32_t allowed)
{
    const VkMemoryPropertyFlags needed =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags wanted[] = {needed | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, needed};
    /* Others are of extensions, whose features the application may not have enabled. */
    const VkMemoryPropertyFlags known = wanted[0] | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    for (int w = 0; w < 2; w++)
        for (uint32_t i = 0; i < device->memory.memoryTypeCount; i++) {
            VkMemoryPropertyFlags flags = device->memory.memoryTypes[i].propertyFlags;
            if ((allowed >> i & 1) && (flags & wanted[w]) == wanted[w] && !(flags & ~known))
                return i;
        }
    return UINT32_MAX;
}

static VkDeviceAddress address_of(const struct layer_device *device, VkBuffer buffer)
{
    const VkuDeviceDispatchTable *next = &device->snapshots->next;
    const VkBufferDeviceAddressInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                            .buffer = buffer};
    PFN_vkGetBufferDeviceAddress get = next->GetBufferDeviceAddress
                                           ? next->GetBufferDeviceAddress
                                           : next->GetBufferDeviceAddressKHR;
    return get(device->handle, &info);
}

static VkResult allocate(const struct layer_device *device, struct staging_chunk *chunk)
{
    const VkuDeviceDispatchTable *next = &device->snapshots->next;
    VkMemoryRequirements requirements;
    next->GetBufferMemoryRequirements(device->handle, chunk->buffer, &requirements);
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo allocate_info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
        .pNext = device->snapshots->has_addresses ? &flags : NULL,
        .allocationSize = requirements.size,
        .memoryTypeIndex = memory_type(device, requirements.memoryTypeBits),
    };
    if (allocate_info.memoryTypeIndex == UINT32_MAX)
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    VkResult result = next->AllocateMemory(device->handle, &allocate_info, NULL, &chunk->memory);
    if (result == VK_SUCCESS)
        result = next->BindBufferMemory(device->handle, chunk->buffer, chunk->memory, 0);
    if (result == VK_SUCCESS)
        result = next->MapMemory(device->handle, chunk->memory, 0, VK_WHOLE_SIZE, 0,
                                 (void **)&chunk->chunk.bytes);
    if (result == VK_SUCCESS && device->snapshots->has_addresses)
        chunk->address = address_of(device, chunk->buffer);
    return result;
}

static struct staging_chunk *create_chunk(const struct layer_device *device, uint64_t size)
{
    struct staging_chunk *chunk = calloc(1, sizeof(*chunk));
    if (!chunk)
        return NULL;
    const VkBufferCreateInfo create_info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                 (device->snapshots->has_addresses ? VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT : 0),
    };
    chunk->chunk.size = size;
    if (device->snapshots->next.CreateBuffer(device->handle, &create_info, NULL, &chunk->buffer) ==
            VK_SUCCESS &&
        allocate(device, chunk) == VK_SUCCESS)
        return chunk;
    free_chunk(device, chunk);
    return NULL;
}

/* The first kept chunk that is large enough, and not much larger; with the lock held. */
static struct staging_chunk *take_kept(struct staging *staging, uint64_t size, uint64_t size_max)
{
    struct staging_chunk **at = &staging->kept;
    while (*at && ((*at)->chunk.size < size || (*at)->chunk.size > size_max))
        at = &(*at)->next;
    struct staging_chunk *chunk = *at;
    if (chunk) {
        *at = chunk->next;
        staging->kept_size -= chunk->chunk.size;
        chunk->chunk.used = 0;
    }
    return chunk;
}

/* Takes kept chunks out, to be freed, as far as a new one needs their room. False where there isn't
 * enough; with the lock held. */
static bool make_room(struct staging *staging, uint64_t size, struct staging_chunk **freed)
{
    *freed = NULL;
    if (size > staging->budget || staging->size - staging->kept_size > staging->budget - size)
        return false;
    while (staging->size > staging->budget - size) {
        struct staging_chunk *chunk = take_kept(staging, 0, UINT64_MAX);
        staging->size -= chunk->chunk.size;
        chunk->next = *freed;
        *freed = chunk;
    }
    staging->size += size;
    return true;
}

static void free_chunks(const struct staging *staging, struct staging_chunk *chunk)
{
    for (struct staging_chunk *next; chunk; chunk = next) {
        next = chunk->next;
        free_chunk(staging->device, chunk);
    }
}

VkResult staging_take(struct staging *staging, uint64_t size, struct staging_chunk **chunk)
{
    uint64_t new_size = size > CHUNK_SIZE ? size : CHUNK_SIZE;
    struct staging_chunk *freed = NULL;
    bool has_room = true;
    pthread_mutex_lock(&staging->lock);
    *chunk = take_kept(staging, size, KEPT_FACTOR * new_size);
    if (!*chunk)
        has_room = make_room(staging, new_size, &freed);
    pthread_mutex_unlock(&staging->lock);
    free_chunks(staging, freed);
    if (*chunk || !has_room)
        return *chunk ? VK_SUCCESS : VK_NOT_READY;
    *chunk = create_chunk(staging->device, new_size);
    if (*chunk)
        return VK_SUCCESS;
    pthread_mutex_lock(&staging->lock);
    staging->size -= new_size;
    pthread_mutex_unlock(&staging->lock);
    return VK_ERROR_OUT_OF_DEVICE_MEMORY;
}

void staging_give_back(struct staging *staging, struct staging_chunk *chunk)
{
    pthread_mutex_lock(&staging->lock);
    bool is_kept = chunk->chunk.size <= KEPT_MAX - staging->kept_size;
    if (is_kept) {
        chunk->next = staging->kept;
        staging->kept = chunk;
        staging->kept_size += chunk->chunk.size;
    } else {
        staging->size -= chunk->chunk.size;
    }
    pthread_mutex_unlock(&staging->lock);
    if (!is_kept)
        free_chunk(staging->device, chunk);
}
