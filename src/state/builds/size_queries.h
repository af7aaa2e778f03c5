/* SPDX-License-Identifier: Apache-2.0 */
/* The build sizes that the application has queried, up to SIZE_QUERIES_KEPT: a finding about a
 * structure or scratch memory that is too small says in what the query that returned its size
 * differs from the build. */
#ifndef ASSAY_STATE_BUILDS_SIZE_QUERIES_H
#define ASSAY_STATE_BUILDS_SIZE_QUERIES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

enum { SIZE_QUERIES_KEPT = 512, SIZE_DIFFERENCES = 3 };

/* What a query returns. */
enum queried_size {
    SIZE_OF_STRUCTURE,
    SIZE_OF_BUILD_SCRATCH,
    SIZE_OF_UPDATE_SCRATCH,
    QUERIED_SIZES
};

/* What the sizes depend on, in the order in which differences are listed. */
enum size_member {
    SIZED_BUILD_TYPE,
    SIZED_TYPE,
    SIZED_FLAGS,
    SIZED_GEOMETRY_COUNT,
    /* Members of a geometry: */
    SIZED_GEOMETRY_TYPE,
    SIZED_GEOMETRY_FLAGS,
    SIZED_PRIMITIVE_COUNT,
    SIZED_VERTEX_FORMAT,
    SIZED_MAX_VERTEX,
    SIZED_INDEX_TYPE,
    SIZED_TRANSFORM, /* whether there is one */
    SIZED_STRIDE,
};

struct size_differences {
    uint32_t build; /* index of the build in the call */
    enum queried_size which;
    VkDeviceSize size; /* that the query returned */
    uint32_t count;    /* 0: no such query is known */
    struct size_difference {
        enum size_member member;
        uint32_t geometry;
        uint64_t queried, built;
    } items[SIZE_DIFFERENCES];
};

/* Counts that queries for clusters and partitioned structures have: the greatest one is kept. */
enum asked_count {
    ASKED_CLUSTERS, /* + opType */
    ASKED_INSTANCES = ASKED_CLUSTERS + 6,
    ASKED_INSTANCES_PER_PARTITION,
    ASKED_PARTITIONS,
    ASKED_GLOBAL_INSTANCES,
    ASKED_COUNTS
};

struct size_queries; /* one per device; has its own lock */

VkResult size_queries_create(struct size_queries **queries);
void size_queries_destroy(struct size_queries *queries); /* accepts NULL */

/* The application has queried the sizes of such a build. All of `info` and `counts` must be
 * readable. If memory runs out, the query is not kept. */
void size_queries_add(struct size_queries *queries,
                      const VkAccelerationStructureBuildGeometryInfoKHR *info,
                      const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                      const VkAccelerationStructureBuildSizesInfoKHR *sizes);

/* Finds the query for which `which` was `size`, or up to 255 bytes less as an application rounds
 * sizes up, and that differs least from a build. Fills all but `build`. */
void size_queries_find(struct size_queries *queries,
                       const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       enum queried_size which, VkDeviceSize size,
                       struct size_differences *differences);

/* The application has queried sizes for a count. */
void size_queries_note_count(struct size_queries *queries, enum asked_count of, uint32_t count);
/* The greatest count that sizes were queried for; 0: none were. */
uint32_t size_queries_greatest(const struct size_queries *queries, enum asked_count of);

#endif
