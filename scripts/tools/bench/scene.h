/* SPDX-License-Identifier: Apache-2.0 */
/* A scene of BLAS, each with one indexed geometry of twelve triangles, and the arrays of a call
 * that builds them. What isn't executed needs no data: see recorder_clear_inputs. */
#ifndef BENCH_SCENE_H
#define BENCH_SCENE_H

#include "side.h"

enum buffers {
    BUFFERS_SHARED,  /* all vertices in one buffer, all indices, structures and scratch likewise */
    BUFFERS_SEPARATE /* four buffers a build */
};

enum order {
    ORDER_CREATED, /* builds in the order in which their structures and buffers were created */
    ORDER_SHUFFLED
};

const char *buffers_name(enum buffers buffers);
const char *order_name(enum order order);

enum scene_part { PART_VERTICES, PART_INDICES, PART_STRUCTURE, PART_SCRATCH, PART_COUNT };

/* The ranges of one kind: one a build, one behind the other in one memory. */
struct scene_ranges {
    VkDeviceMemory memory;
    VkBuffer *buffers; /* buffer_count; one, or one a build */
    uint32_t buffer_count;
    VkDeviceAddress *addresses; /* one a build; 0 for PART_STRUCTURE */
    VkDeviceSize size, stride;
};

struct scene {
    const struct side *side;
    uint32_t count; /* of builds */
    struct scene_ranges parts[PART_COUNT];
    VkAccelerationStructureKHR *structures;

    /* The arrays of the call, count elements each. Any run of them is a valid call. */
    VkAccelerationStructureBuildGeometryInfoKHR *infos;
    VkAccelerationStructureGeometryKHR *geometries;
    VkAccelerationStructureBuildRangeInfoKHR *ranges;
    const VkAccelerationStructureBuildRangeInfoKHR **range_pointers;
};

void scene_create(struct scene *scene, const struct side *side, enum buffers buffers,
                  enum order order, uint32_t count);
void scene_destroy(struct scene *scene);

/* Gives all builds the dst and the scratch of the first, so that each conflicts with all others. */
static inline void scene_conflict(const struct scene *scene)
{
    for (uint32_t i = 1; i < scene->count; i++) {
        scene->infos[i].dstAccelerationStructure = scene->infos[0].dstAccelerationStructure;
        scene->infos[i].scratchData = scene->infos[0].scratchData;
    }
}

#endif
