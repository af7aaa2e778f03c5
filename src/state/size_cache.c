/* SPDX-License-Identifier: Apache-2.0 */
/* The cache of build sizes: direct-mapped, an entry a set, a mutex a stripe of entries. */
#include "state/size_cache.h"

#include <pthread.h>
#include <stdlib.h>

#include "state/build_info.h"

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

static inline bool describe(const VkAccelerationStructureGeometryKHR *geometry,
                            uint32_t primitive_count, struct shape_geometry *shape)
{
    *shape = (struct shape_geometry){.type = (uint32_t)geometry->geometryType,
                                     .flags = geometry->flags,
                                     .primitive_count = primitive_count};
    if (geometry->pNext)
        return false;
    if (geometry->geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR) {
        const VkAccelerationStructureGeometryTrianglesDataKHR *t = &geometry->geometry.triangles;
        shape->stride = t->vertexStride;
        shape->vertex_format = (uint32_t)t->vertexFormat;
        shape->max_vertex = t->maxVertex;
        shape->index_type = (uint32_t)t->indexType;
        shape->has_transform = t->transformData.deviceAddress != 0;
        return !t->pNext;
    }
    if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR) {
        shape->stride = geometry->geometry.aabbs.stride;
        return !geometry->geometry.aabbs.pNext;
    }
    if (geometry->geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR) {
        shape->array_of_pointers = geometry->geometry.instances.arrayOfPointers != 0;
        return !geometry->geometry.instances.pNext;
    }
    return false;
}

/* The build without its geometries behind the first. */
static inline bool describe_small(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                  const uint32_t *primitive_counts,
                                  VkAccelerationStructureBuildTypeKHR build_type,
                                  struct small_shape *shape)
{
    *shape = (struct small_shape){.build_type = (uint32_t)build_type,
                                  .type = (uint32_t)info->type,
                                  .flags = info->flags,
                                  .geometry_count = info->geometryCount};
    if (info->pNext)
        return false;
    return !info->geometryCount ||
           describe(build_geometry(info, 0), primitive_counts[0], &shape->first);
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
    if (!describe_small(info, primitive_counts, build_type, &small))
        return false;
    XXH128_hash_t hash = XXH3_128bits(&small, sizeof(small));

    /* Chain the hashes of the others: one geometry is the common case. */
    for (uint32_t i = 1; i < info->geometryCount; i++) {
        struct {
            XXH128_hash_t before;
            struct shape_geometry geometry;
        } next = {.before = hash};
        if (!describe(build_geometry(info, i), primitive_counts[i], &next.geometry))
            return false;
        hash = XXH3_128bits(&next, sizeof(next));
    }
    *shape = shape_from(hash);
    return true;
}

/* Member by member, so that a shape that is only compared need not be written. */
static inline bool is_same_shape(const struct small_shape *a, const struct small_shape *b)
{
    const struct shape_geometry *x = &a->first, *y = &b->first;
    uint32_t different =
        (a->build_type ^ b->build_type) | (a->type ^ b->type) | (a->flags ^ b->flags) |
        (a->geometry_count ^ b->geometry_count) | (x->type ^ y->type) | (x->flags ^ y->flags) |
        (x->primitive_count ^ y->primitive_count) | (x->vertex_format ^ y->vertex_format) |
        (x->max_vertex ^ y->max_vertex) | (x->index_type ^ y->index_type) |
        (x->has_transform ^ y->has_transform) | (x->array_of_pointers ^ y->array_of_pointers);
    return !different && x->stride == y->stride;
}

bool recent_sizes_find(const struct recent_sizes *recent,
                       const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       uint32_t primitive_count, VkAccelerationStructureBuildTypeKHR build_type,
                       struct size_facts *sizes)
{
    struct small_shape shape;
    if (!recent->sizes.known || !describe_small(info, &primitive_count, build_type, &shape) ||
        !is_same_shape(&shape, &recent->shape))
        return false;
    *sizes = recent->sizes;
    return true;
}

void recent_sizes_set(struct recent_sizes *recent,
                      const VkAccelerationStructureBuildGeometryInfoKHR *info,
                      uint32_t primitive_count, VkAccelerationStructureBuildTypeKHR build_type,
                      const struct size_facts *sizes)
{
    recent->sizes = *sizes;
    if (!describe_small(info, &primitive_count, build_type, &recent->shape))
        recent->sizes.known = false;
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
