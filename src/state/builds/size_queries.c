/* SPDX-License-Identifier: Apache-2.0 */
/* A table of queries by their hash; a query takes the place of another one that has its hash. Of
 * each it keeps what the sizes depend on, of the first GEOMETRIES_KEPT geometries. */
#include "src/state/builds/size_queries.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "src/model/geometry_shape.h"
#include "src/platform/threads.h"
#include "src/state/facts.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { GEOMETRIES_KEPT = 64, ROUNDED_UP = 256, BUILD_MEMBERS = SIZED_GEOMETRY_TYPE };
enum { GEOMETRY_MEMBERS = SIZED_STRIDE + 1 - BUILD_MEMBERS };

/* A build, and what its query has returned. */
struct sized_build {
    VkDeviceSize sizes[QUERIED_SIZES];
    uint64_t build[BUILD_MEMBERS];
    uint64_t geometries[GEOMETRIES_KEPT][GEOMETRY_MEMBERS]; /* as many as there are */
};

struct size_queries {
    pthread_mutex_t lock;                        /* guards the next member */
    struct sized_build *kept[SIZE_QUERIES_KEPT]; /* owned; NULL: none */
    _Atomic uint32_t greatest[ASKED_COUNTS];
};

VkResult size_queries_create(struct size_queries **queries)
{
    *queries = calloc(1, sizeof(**queries));
    if (!*queries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&(*queries)->lock, NULL);
    return VK_SUCCESS;
}

void size_queries_destroy(struct size_queries *queries)
{
    if (!queries)
        return;
    for (uint32_t i = 0; i < SIZE_QUERIES_KEPT; i++)
        free(queries->kept[i]);
    pthread_mutex_destroy(&queries->lock);
    free(queries);
}

/* ---- builds */

static void describe_geometry(const VkAccelerationStructureGeometryKHR *geometry, uint32_t count,
                              uint64_t members[GEOMETRY_MEMBERS])
{
    const struct geometry_shape shape = geometry_shape_of(geometry, &count);
#define SET(member, value) members[SIZED_##member - BUILD_MEMBERS] = (uint64_t)(value)
    SET(GEOMETRY_TYPE, shape.type);
    SET(GEOMETRY_FLAGS, shape.flags);
    SET(PRIMITIVE_COUNT, shape.primitive_count);
    SET(VERTEX_FORMAT, shape.vertex_format);
    SET(MAX_VERTEX, shape.max_vertex);
    SET(INDEX_TYPE, shape.index_type);
    SET(TRANSFORM, shape.has_transform);
    SET(STRIDE, shape.stride);
#undef SET
}

/* Returns the size of what is described, in bytes. */
static size_t describe_build(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                             const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                             struct sized_build *build)
{
    const uint64_t kept = smaller_of(info->geometryCount, GEOMETRIES_KEPT);
    const size_t size =
        offsetof(struct sized_build, geometries) + kept * sizeof(*build->geometries);
    memset(build, 0, size);
    build->build[SIZED_BUILD_TYPE] = (uint64_t)build_type;
    build->build[SIZED_TYPE] = (uint64_t)info->type;
    build->build[SIZED_FLAGS] = info->flags;
    build->build[SIZED_GEOMETRY_COUNT] = info->geometryCount;
    for (uint32_t i = 0; i < kept; i++)
        describe_geometry(build_geometry(info, i), counts[i], build->geometries[i]);
    return size;
}

/* ---- the table */

void size_queries_add(struct size_queries *queries,
                      const VkAccelerationStructureBuildGeometryInfoKHR *info,
                      const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                      const VkAccelerationStructureBuildSizesInfoKHR *sizes)
{
    struct sized_build query;
    const size_t size = describe_build(info, counts, build_type, &query);
    query.sizes[SIZE_OF_STRUCTURE] = sizes->accelerationStructureSize;
    query.sizes[SIZE_OF_BUILD_SCRATCH] = sizes->buildScratchSize;
    query.sizes[SIZE_OF_UPDATE_SCRATCH] = sizes->updateScratchSize;
    struct sized_build *kept = malloc(size);
    if (!kept)
        return;
    memcpy(kept, &query, size);
    pthread_mutex_lock(&queries->lock);
    struct sized_build **slot = &queries->kept[XXH3_64bits(kept, size) % SIZE_QUERIES_KEPT];
    free(*slot);
    *slot = kept;
    pthread_mutex_unlock(&queries->lock);
}

/* ---- differences */

static void compare_members(const uint64_t *queried, const uint64_t *built, uint32_t count,
                            enum size_member first, uint32_t geometry,
                            struct size_differences *differences)
{
    for (uint32_t i = 0; i < count; i++)
        if (queried[i] != built[i] && differences->count++ < SIZE_DIFFERENCES)
            differences->items[differences->count - 1] = (struct size_difference){
                (enum size_member)(first + i), geometry, queried[i], built[i]};
}

/* Counts all differences, and lists the first ones. */
static void compare_builds(const struct sized_build *query, const struct sized_build *built,
                           struct size_differences *differences)
{
    const uint64_t count =
        smaller_of(query->build[SIZED_GEOMETRY_COUNT], built->build[SIZED_GEOMETRY_COUNT]);
    compare_members(query->build, built->build, BUILD_MEMBERS, SIZED_BUILD_TYPE, 0, differences);
    for (uint32_t i = 0; i < count && i < GEOMETRIES_KEPT; i++)
        compare_members(query->geometries[i], built->geometries[i], GEOMETRY_MEMBERS,
                        SIZED_GEOMETRY_TYPE, i, differences);
}

/* An equal size outweighs fewer differences. */
static bool is_better(const struct size_differences *a, const struct size_differences *b)
{
    if (!a->count || !b->count)
        return a->count;
    return a->size != b->size ? a->size > b->size : a->count < b->count;
}

void size_queries_find(struct size_queries *queries,
                       const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       enum queried_size which, VkDeviceSize size,
                       struct size_differences *differences)
{
    struct sized_build built;
    struct size_differences best = {.count = 0};
    describe_build(info, counts, build_type, &built);
    pthread_mutex_lock(&queries->lock);
    for (uint32_t i = 0; i < SIZE_QUERIES_KEPT; i++) {
        const struct sized_build *query = queries->kept[i];
        struct size_differences next = {.size = query ? query->sizes[which] : 0};
        if (!next.size || next.size > size || size - next.size >= ROUNDED_UP)
            continue;
        compare_builds(query, &built, &next);
        if (is_better(&next, &best))
            best = next;
    }
    pthread_mutex_unlock(&queries->lock);
    best.count = best.count < SIZE_DIFFERENCES ? best.count : SIZE_DIFFERENCES;
    best.build = differences->build;
    best.which = which;
    *differences = best;
}

/* ---- counts of clusters and partitioned structures */

void size_queries_note_count(struct size_queries *queries, enum asked_count of, uint32_t count)
{
    uint32_t known = atomic_load(&queries->greatest[of]);
    while (known < count && !atomic_compare_exchange_weak(&queries->greatest[of], &known, count))
        ;
}

uint32_t size_queries_greatest(const struct size_queries *queries, enum asked_count of)
{
    return atomic_load(&queries->greatest[of]);
}
