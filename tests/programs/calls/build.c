/* SPDX-License-Identifier: Apache-2.0 */
/* VkAccelerationStructureBuildGeometryInfoKHR: its members, structures, scratch and updates; and
 * valid programs that other validation has called wrong, or that are easily called so. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
static const VkBaseInStructure unknown = {.sType = (VkStructureType)2000000123};

enum { MANY_GEOMETRIES = 40 };

/* INDEXED, of so many geometries that each is alike; its dst and scratch as they were. */
static void give_many_geometries(struct scene *scene)
{
    static VkAccelerationStructureGeometryKHR geometries[MANY_GEOMETRIES];
    static VkAccelerationStructureBuildRangeInfoKHR ranges[MANY_GEOMETRIES];

    for (uint32_t i = 0; i < MANY_GEOMETRIES; i++) {
        geometries[i] = scene->geometries[INDEXED][0];
        ranges[i] = scene->ranges[INDEXED][0];
    }
    scene->infos[INDEXED].geometryCount = MANY_GEOMETRIES;
    scene->infos[INDEXED].pGeometries = geometries;
    scene->range_pointers[INDEXED] = ranges;
    const struct device_buffer scratch = scene_buffer(scene, 1 << 20, SCRATCH_USAGE);
    scene->infos[INDEXED].scratchData.deviceAddress = scene_address(scene, &scratch, 0);
}

static uint64_t alignment_of(const struct scene *scene)
{
    return scene->fixture->limits.minAccelerationStructureScratchOffsetAlignment;
}

#include "build.inc"
#include "silent.inc"
