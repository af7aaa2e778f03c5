/* SPDX-License-Identifier: Apache-2.0 */
/* Opacity micromaps: their builds, and triangles that use them. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

static void add_second_data(struct scene *scene)
{
    static VkAccelerationStructureGeometryMicromapDataKHR second;
    scene_build_micromap(scene);
    second = scene->micromaps.data;
    scene->micromaps.data.pNext = &second;
}

enum {
    LOSSY = VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR,
    STATES_4 = VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR,
    /* MICROMAP_LIMITS, and what the null driver has. */
    LIMIT_2_STATE = 6,
    LIMIT_4_STATE = 5,
    LIMIT_LOSSY = 4,
    LIMIT_DISPLACEMENT = 5,
    LIMIT_TRIANGLES = 4096,
    LEVEL_OF_NONE = 13,
};

#include "micromap.inc"
#include "micromap_use.inc"
