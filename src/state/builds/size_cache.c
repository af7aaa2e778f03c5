/* SPDX-License-Identifier: Apache-2.0 */
/* The cache of build sizes: direct-mapped, an entry a set, a mutex a stripe of entries. */
#include "src/state/builds/size_cache.h"

#include <pthread.h>
#include <stdlib.h>

#include "src/state/builds/build_info.h"
#include "src/state/builds/small_shape.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { ENTRIES = 1024, STRIPES = 16 };

struct size_cache {
    struct size_stripe {
        pthread_mutex_t mutex;
        struct {
            struct build_shape shape;
            struct size_facts sizes;
        } entries[ENTRIES / STRIPES];
    } stripes[STRIPES];
};

VkResult size_cache_create(struct size_cache **cache)
{
    *cache = calloc(1, sizeof(**cache));
    if (!*cache)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (unsigned i = 0; i < STRIPES; i++)
        pthread_mutex_init(&(*cache)->stripes[i].mutex, NULL);
    return VK_SUCCESS;
}

void size_cache_destroy(struct size_cache *cache)
{
    if (!cache)
        return;
    for (unsigned i = 0; i < STRIPES; i++)
        pthread_mutex_destroy(&cache->stripes[i].mutex);
    free(cache);
}

static struct build_shape shape_from(XXH128_hash_t hash)
{
    return (struct build_shape){.low = hash.low64, .high = hash.high64};
}

bool build_shape_of(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                    const uint32_t *primitive_counts,
                    VkAccelerationStructureBuildTypeKHR build_type, struct build_shape *shape)
{
    struct small_shape small;
    if (!small_shape_of(info, primitive_counts, build_type, &small))
        return false;
    XXH128_hash_t hash = XXH3_128bits(&small, sizeof(small));

    /* Chain the hashes of the others: one geometry is the common case. */
    for (uint32_t i = 1; i < info->geometryCount; i++) {
        struct {
            XXH128_hash_t before;
            struct shape_geometry geometry;
        } next = {.before = hash};
        if (!shape_of_geometry(build_geometry(info, i), primitive_counts[i], &next.geometry))
            return false;
        hash = XXH3_128bits(&next, sizeof(next));
    }
    *shape = shape_from(hash);
    return true;
}

static bool same_shape(const struct build_shape *a, const struct build_shape *b)
{
    return a->low == b->low && a->high == b->high;
}

bool size_cache_find(struct size_cache *cache, const struct build_shape *shape,
                     struct size_facts *sizes)
{
    struct size_stripe *stripe = &cache->stripes[shape->low % STRIPES];
    size_t at = shape->low / STRIPES % (ENTRIES / STRIPES);
    pthread_mutex_lock(&stripe->mutex);
    bool found = stripe->entries[at].sizes.known && same_shape(&stripe->entries[at].shape, shape);
    if (found)
        *sizes = stripe->entries[at].sizes;
    pthread_mutex_unlock(&stripe->mutex);
    return found;
}

void size_cache_add(struct size_cache *cache, const struct build_shape *shape,
                    const struct size_facts *sizes)
{
    struct size_stripe *stripe = &cache->stripes[shape->low % STRIPES];
    size_t at = shape->low / STRIPES % (ENTRIES / STRIPES);
    pthread_mutex_lock(&stripe->mutex);
    stripe->entries[at].shape = *shape;
    stripe->entries[at].sizes = *sizes;
    pthread_mutex_unlock(&stripe->mutex);
}
