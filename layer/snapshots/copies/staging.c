/* SPDX-License-Identifier: Apache-2.0 */
/* Staging memory. Each chunk is a buffer with its own allocation, or a part of one. Mapped chunks
 * are mapped as long as they exist. */
#include "layer/snapshots/copies/copies.h"

#include <stdlib.h>

#include "src/platform/threads.h"

/* The least size of an allocation. Small chunks share one, in units of UNIT_SIZE bytes. */
#define CHUNK_SIZE ((uint64_t)256 << 10)
enum { UNITS = 64, PART_UNITS_MAX = UNITS / 4, UNIT_SIZE = CHUNK_SIZE / UNITS };
/* A kept chunk of up to this size serves any smaller need. */
#define SMALL_SIZE ((uint64_t)1 << 20)

/* Chunks that are given back are kept, because drivers take long to allocate memory: an H200 takes
 * 20 ms for 64 MiB. Above KEPT_ALWAYS bytes, a chunk is freed if it was not taken for KEPT_PERIODS
 * times the usual number of submissions between two takes. */
#define KEPT_ALWAYS ((uint64_t)16 << 20)
enum { KEPT_PERIODS = 4 };

struct staging {
    struct layer_device *device;
    pthread_mutex_t lock;         /* guards the members below; no call is made with it held */
    struct staging_chunk *kept;   /* the one given back last comes first */
    struct staging_chunk *shared; /* those with parts and a free unit */
    uint64_t kept_size;
    uint64_t submissions, last_take; /* number of submissions, now and at the last take */
    uint64_t period;                 /* submissions between two takes */
    uint64_t size;                   /* of all chunks */
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

/* Removes the chunk that a link points to from the kept ones. Called with the lock held. */
static struct staging_chunk *unlink_kept(struct staging *staging, struct staging_chunk **link)
{
    struct staging_chunk *chunk = *link;
    *link = chunk->next;
    staging->kept_size -= chunk->chunk.size;
    return chunk;
}

/* Takes the smallest kept chunk of `size` to `size_max` bytes. Called with the lock held. */
static struct staging_chunk *take_kept(struct staging *staging, uint64_t size, uint64_t size_max)
{
    struct staging_chunk **best = NULL;
    for (struct staging_chunk **at = &staging->kept; *at; at = &(*at)->next)
        if ((*at)->chunk.size >= size && (*at)->chunk.size <= size_max &&
            (!best || (*at)->chunk.size < (*best)->chunk.size))
            best = at;
    if (!best)
        return NULL;
    struct staging_chunk *chunk = unlink_kept(staging, best);
    chunk->chunk.used = 0;
    return chunk;
}

/* Makes room in the budget for a new chunk: removes kept chunks, which the caller frees. Returns
 * false if the budget has no room. Called with the lock held. */
static bool make_room_in_chunks(struct staging *staging, uint64_t size,
                                struct staging_chunk **freed)
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

/* The size of a new chunk: `size`, rounded up by at most a sixteenth, so that it also serves
 * slightly larger inputs of later frames. */
static uint64_t size_of_new(uint64_t size)
{
    if (size <= CHUNK_SIZE)
        return CHUNK_SIZE;
    const uint64_t step = (UINT64_C(1) << (63 - __builtin_clzll(size))) / 16;
    return size > UINT64_MAX - step ? size : (size + step - 1) / step * step;
}

/* Measures how far apart takes are, in submissions. Called with the lock held. */
static void note_take(struct staging *staging)
{
    const uint64_t gap = staging->submissions - staging->last_take;
    const uint64_t decayed = staging->period - (staging->period + 7) / 8;
    if (gap)
        staging->period = gap > decayed ? gap : decayed;
    staging->last_take = staging->submissions;
}

/* Takes a whole chunk: a kept one of at most `kept_max` bytes, or a new one. */
static VkResult take_whole(struct staging *staging, uint64_t size, uint64_t kept_max,
                           struct staging_chunk **chunk)
{
    uint64_t new_size = size_of_new(size);
    struct staging_chunk *freed = NULL;
    bool has_room = true;
    pthread_mutex_lock(&staging->lock);
    note_take(staging);
    *chunk = take_kept(staging, size, new_size > kept_max ? new_size : kept_max);
    if (!*chunk && !make_room_in_chunks(staging, new_size, &freed)) {
        new_size = size > CHUNK_SIZE ? size : CHUNK_SIZE;
        has_room = make_room_in_chunks(staging, new_size, &freed);
    }
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

VkResult staging_take(struct staging *staging, uint64_t size, struct staging_chunk **chunk)
{
    return take_whole(staging, size, SMALL_SIZE, chunk);
}

/* ---- parts */

/* Returns the first `count` units in a row that are not taken, or 0 if there are none. */
static uint64_t find_units(uint64_t taken, uint64_t count)
{
    uint64_t units = (UINT64_C(1) << count) - 1;
    for (uint64_t i = 0; i + count <= UNITS; i++, units <<= 1)
        if (!(taken & units))
            return units;
    return 0;
}

/* Sets what the part is a part of. Called with the lock held. */
static void make_part(struct staging_chunk *part, struct staging_chunk *whole, uint64_t units)
{
    whole->units |= units;
    part->whole = whole;
    part->units = units;
    part->offset = (uint64_t)__builtin_ctzll(units) * UNIT_SIZE;
    part->buffer = whole->buffer;
    part->buffer.address += part->offset;
    if (part->buffer.bytes)
        part->buffer.bytes += part->offset;
    part->chunk.size = (uint64_t)__builtin_popcountll(units) * UNIT_SIZE;
    part->chunk.bytes = part->buffer.bytes;
}

/* Called with the lock held. */
static bool take_shared(struct staging *staging, uint64_t count, struct staging_chunk *part)
{
    for (struct staging_chunk **at = &staging->shared; *at; at = &(*at)->next) {
        struct staging_chunk *whole = *at;
        const uint64_t units = find_units(whole->units, count);
        if (!units)
            continue;
        make_part(part, whole, units);
        if (whole->units == UINT64_MAX)
            *at = whole->next;
        return true;
    }
    return false;
}

VkResult staging_take_part(struct staging *staging, uint64_t size, struct staging_chunk **chunk)
{
    const uint64_t count = (size + UNIT_SIZE - 1) / UNIT_SIZE;
    struct staging_chunk *whole;
    if (size > PART_UNITS_MAX * UNIT_SIZE)
        return staging_take(staging, size, chunk);
    struct staging_chunk *part = calloc(1, sizeof(*part));
    if (!part)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    *chunk = part;
    pthread_mutex_lock(&staging->lock);
    bool is_taken = take_shared(staging, count, part);
    pthread_mutex_unlock(&staging->lock);
    if (is_taken)
        return VK_SUCCESS;
    VkResult result = take_whole(staging, CHUNK_SIZE, CHUNK_SIZE, &whole);
    if (result != VK_SUCCESS) {
        free(part);
        return result;
    }
    pthread_mutex_lock(&staging->lock);
    make_part(part, whole, find_units(0, count));
    whole->next = staging->shared;
    staging->shared = whole;
    pthread_mutex_unlock(&staging->lock);
    return VK_SUCCESS;
}

/* Frees the units of a part. Returns the chunk that it was a part of if that is now unused, or
 * NULL. Called with the lock held. */
static struct staging_chunk *give_back_part(struct staging *staging,
                                            const struct staging_chunk *part)
{
    struct staging_chunk *whole = part->whole, **at = &staging->shared;
    if (whole->units == UINT64_MAX) {
        whole->next = staging->shared;
        staging->shared = whole;
    }
    whole->units &= ~part->units;
    if (whole->units)
        return NULL;
    while (*at != whole)
        at = &(*at)->next;
    *at = whole->next;
    return whole;
}

void staging_give_back(struct staging *staging, struct staging_chunk *chunk)
{
    struct staging_chunk *part = chunk->whole ? chunk : NULL;
    pthread_mutex_lock(&staging->lock);
    if (part)
        chunk = give_back_part(staging, part);
    if (chunk) {
        chunk->given_back = staging->submissions;
        chunk->next = staging->kept;
        staging->kept = chunk;
        staging->kept_size += chunk->chunk.size;
    }
    pthread_mutex_unlock(&staging->lock);
    free(part);
}

void staging_leave(struct staging *staging, struct staging_chunk *chunk)
{
    pthread_mutex_lock(&staging->lock);
    staging->size -= chunk->chunk.size;
    pthread_mutex_unlock(&staging->lock);
    free(chunk);
}

/* Removes the kept chunks that have not been taken for long. Called with the lock held. */
static struct staging_chunk *take_old(struct staging *staging)
{
    const uint64_t age_max = KEPT_PERIODS * (staging->period + 1);
    struct staging_chunk *old = NULL, **at = &staging->kept;
    while (*at && staging->kept_size > KEPT_ALWAYS) {
        if (staging->submissions - (*at)->given_back <= age_max) {
            at = &(*at)->next;
            continue;
        }
        struct staging_chunk *chunk = unlink_kept(staging, at);
        staging->size -= chunk->chunk.size;
        chunk->next = old;
        old = chunk;
    }
    return old;
}

void staging_note_submission(struct staging *staging)
{
    pthread_mutex_lock(&staging->lock);
    staging->submissions++;
    struct staging_chunk *old = take_old(staging);
    pthread_mutex_unlock(&staging->lock);
    free_chunks(staging, old);
}
