/* SPDX-License-Identifier: Apache-2.0 */
/* A table of queries by a hash of all of it; a query takes the place of another one that has its
 * hash. Of each it keeps what the sizes depend on, of the first geometries only. */
#include "src/state/builds/size_queries.h"

#include <stdlib.h>

#include "src/platform/threads.h"
#include "src/state/builds/build_info.h"
#include "src/state/facts.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { GEOMETRIES_KEPT = 4, ROUNDED_UP = 256, BUILD_MEMBERS = SIZED_GEOMETRY_TYPE };
enum { GEOMETRY_MEMBERS = SIZED_STRIDE + 1 - BUILD_MEMBERS };

struct sized_build {
    uint64_t build[BUILD_MEMBERS];
    uint64_t geometries[GEOMETRIES_KEPT][GEOMETRY_MEMBERS];
};

struct size_query {
    VkDeviceSize size; /* 0: none */
    struct sized_build of;
};

struct size_queries {
    pthread_mutex_t lock;    /* guards the rest */
    struct size_query *kept; /* NULL: none yet, or no memory */
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
    free(queries->kept);
    pthread_mutex_destroy(&queries->lock);
    free(queries);
}

/* ---- builds */

static void set(uint64_t members[GEOMETRY_MEMBERS], enum size_member member, uint64_t value)
{
    members[member - BUILD_MEMBERS] = value;
}

static void describe_geometry(const VkAccelerationStructureGeometryKHR *geometry, uint32_t count,
                              uint64_t members[GEOMETRY_MEMBERS])
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &geometry->geometry.triangles;
    set(members, SIZED_GEOMETRY_TYPE, (uint64_t)geometry->geometryType);
    set(members, SIZED_GEOMETRY_FLAGS, geometry->flags);
    set(members, SIZED_PRIMITIVE_COUNT, count);
    if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR)
        set(members, SIZED_STRIDE, geometry->geometry.aabbs.stride);
    if (geometry->geometryType != VK_GEOMETRY_TYPE_TRIANGLES_KHR)
        return;
    set(members, SIZED_VERTEX_FORMAT, (uint64_t)triangles->vertexFormat);
    set(members, SIZED_MAX_VERTEX, triangles->maxVertex);
    set(members, SIZED_INDEX_TYPE, (uint64_t)triangles->indexType);
    set(members, SIZED_TRANSFORM, triangles->transformData.deviceAddress != 0);
    set(members, SIZED_STRIDE, triangles->vertexStride);
}

static void describe_build(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                           const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                           struct sized_build *build)
{
    *build = (struct sized_build){.build = {[SIZED_BUILD_TYPE] = (uint64_t)build_type,
                                            [SIZED_TYPE] = (uint64_t)info->type,
                                            [SIZED_FLAGS] = info->flags,
                                            [SIZED_GEOMETRY_COUNT] = info->geometryCount}};
    for (uint32_t i = 0; i < info->geometryCount && i < GEOMETRIES_KEPT; i++)
        describe_geometry(build_geometry(info, i), counts[i], build->geometries[i]);
}

/* ---- the table */

void size_queries_add(struct size_queries *queries,
                      const VkAccelerationStructureBuildGeometryInfoKHR *info,
                      const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                      VkDeviceSize size)
{
    struct size_query query = {.size = size};
    describe_build(info, counts, build_type, &query.of);
    pthread_mutex_lock(&queries->lock);
    if (!queries->kept)
        queries->kept = calloc(SIZE_QUERIES_KEPT, sizeof(*queries->kept));
    if (queries->kept)
        queries->kept[XXH3_64bits(&query, sizeof(query)) % SIZE_QUERIES_KEPT] = query;
    pthread_mutex_unlock(&queries->lock);
}

/* ---- differences */

static void compare_members(const uint64_t *asked, const uint64_t *built, uint32_t count,
                            enum size_member first, uint32_t geometry,
                            struct size_differences *differences)
{
    for (uint32_t i = 0; i < count; i++)
        if (asked[i] != built[i] && differences->count++ < SIZE_DIFFERENCES)
            differences->items[differences->count - 1] = (struct size_difference){
                (enum size_member)(first + i), geometry, asked[i], built[i]};
}

/* Counts all differences, and lists the first ones. */
static void compare_builds(const struct size_query *query, const struct sized_build *built,
                           struct size_differences *differences)
{
    const uint64_t asked_count = query->of.build[SIZED_GEOMETRY_COUNT];
    const uint64_t count = smaller_of(asked_count, built->build[SIZED_GEOMETRY_COUNT]);
    *differences = (struct size_differences){.size = query->size};
    compare_members(query->of.build, built->build, BUILD_MEMBERS, SIZED_BUILD_TYPE, 0, differences);
    for (uint32_t i = 0; i < count && i < GEOMETRIES_KEPT; i++)
        compare_members(query->of.geometries[i], built->geometries[i], GEOMETRY_MEMBERS,
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
                       VkDeviceSize size, struct size_differences *differences)
{
    struct sized_build built;
    struct size_differences best = {.count = 0}, next;
    describe_build(info, counts, build_type, &built);
    pthread_mutex_lock(&queries->lock);
    for (uint32_t i = 0; queries->kept && i < SIZE_QUERIES_KEPT; i++) {
        const struct size_query *query = &queries->kept[i];
        if (!query->size || query->size > size || size - query->size >= ROUNDED_UP)
            continue;
        compare_builds(query, &built, &next);
        if (is_better(&next, &best))
            best = next;
    }
    pthread_mutex_unlock(&queries->lock);
    best.count = best.count < SIZE_DIFFERENCES ? best.count : SIZE_DIFFERENCES;
    best.build = differences->build;
    *differences = best;
}
