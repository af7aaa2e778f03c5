/* SPDX-License-Identifier: Apache-2.0 */
/* Valid programs that other validation has called wrong, or that are easily called so. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

/* Returns the compacted size of a build that the scene has executed. Only a command of the host
 * gets it from the driver at once. */
static VkDeviceSize compacted_size(struct scene *scene, uint32_t build)
{
    VkDeviceSize size = place_size(scene, build) / 2;
    if (command_is_on_host(scene->command))
        GET(scene->vk->WriteAccelerationStructuresPropertiesKHR(
            scene->fixture->device, 1, &scene->infos[build].dstAccelerationStructure,
            VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, sizeof(size), &size,
            sizeof(size)));
    return size;
}

#include "silent.inc"
