/* SPDX-License-Identifier: Apache-2.0 */
/* Staging memory. Each chunk is a buffer with its own allocation. Mapped chunks are mapped as long
 * as they exist. */
#include "layer/snapshots/copies/staging.h"

#include <pthread.h>
#include <stdlib.h>

/* A chunk is large enough for a command buffer of small builds. Chunks that are given back are kept
 * up to RETAINED_MAX bytes. */
#define CHUNK_SIZE ((uint64_t)256 << 10)
#define RETAINED_MAX ((uint64_t)64 << 20)
/* A kept chunk is reused only if it is at most this many times as large as a new one. */
#define KEPT_FACTOR 4

struct staging {
    struct layer_device *device;
    pthread_mutex_t lock; /* guards the members below; no call is made with it held */
    struct staging_chunk *kept;
    uint64_t kept_size;
    uint64_t size; /* of all chunks */
    uint64_t budget;
    VkBufferUsageFlags usage; /* usage and is_mapped never change */
    bool is_mapped;
};

VkResult staging_create(struct layer_device *device, uint64_t budget, VkBufferUsageFlags usage,
                        bool is_mapped, struct staging **staging)
{
    *staging = calloc(1, sizeof(**staging));
    if (!*staging)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*staging)->device = device;
    (*staging)->budget = budget;
    (*staging)->usage = usage;
    (*staging)->is_mapped = is_mapped;
    pthread_mutex_init(&(*staging)->lock, NULL);
    return VK_SUCCESS;
}

static void free_chunk(const struct layer_device *device, struct staging_chunk *chunk)
{
    const struct own_device own = snapshots_own_device(device->snapshots);
    own_buffer_free(&own, &chunk->buffer);
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

static struct staging_chunk *create_chunk(const struct staging *staging, uint64_t size)
{
    const struct layer_device *device = staging->device;
    const struct own_device own = snapshots_own_device(device->snapshots);
    struct staging_chunk *chunk = calloc(1, sizeof(*chunk));
    if (!chunk)
        return NULL;
    const VkBufferUsageFlags usage =
        staging->usage |
        (device->snapshots->has_addresses ? VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT : 0);
    if (own_buffer_create(&own, usage, size, staging->is_mapped, &chunk->buffer) == VK_SUCCESS) {
        chunk->chunk.size = size;
        chunk->chunk.bytes = chunk->buffer.bytes;
        return chunk;
    }
    free_chunk(device, chunk);
    return NULL;
}

/* Takes the first kept chunk of `size` to `size_max` bytes. Called with the lock held. */
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

/* Makes room in the budget for a new chunk: removes kept chunks, which the caller frees. Returns
 * false if the budget has no room. Called with the lock held. */
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
    *chunk = create_chunk(staging, new_size);
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
    bool is_kept = chunk->chunk.size <= RETAINED_MAX - staging->kept_size;
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
