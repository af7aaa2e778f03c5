/* SPDX-License-Identifier: Apache-2.0 */
/* many_builds COUNT: so many builds, updates and copies of named structures, by two queues and now
 * and then by the host; one build in 1,000 has a mistake. The environment names driver and layer.
 */
#include <stdio.h>
#include <stdlib.h>

#include "tests/rules/scene/scene.h"

enum {
    USES_OF_A_STRUCTURE = 4,
    STRUCTURES_A_SUBMISSION = 5,
    BUILDS_A_SUBMISSION = USES_OF_A_STRUCTURE * STRUCTURES_A_SUBMISSION,
    ONE_MISTAKE_IN = 1000,
    QUEUES = 2,
};

static struct fixture fixture;
static struct scene *scene;
static struct device_buffer structures_buffer;
static VkDeviceSize structure_size;
static uint32_t families[QUEUES];
static VkCommandBuffer command_buffers[QUEUES];
static VkQueryPool query_pool;

static void open_scene(uint32_t structure_count)
{
    fixture_open_by_environment(&fixture, NULL);
    scene = scene_open(&fixture, COMMAND_DEVICE);
    scene->info_count = 1;
    scene->infos[0].flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
                            VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
    structure_size = SCENE_BUFFER_SIZE * 4;
    structures_buffer = scene_buffer(scene, structure_count * structure_size, ACCEL_USAGE);
    scene_end(scene, scene->command_buffer);
    families[0] = fixture_find_family(&fixture, VK_QUEUE_COMPUTE_BIT, 0);
    families[1] = fixture_find_family(&fixture, VK_QUEUE_COMPUTE_BIT, VK_QUEUE_GRAPHICS_BIT);
    for (uint32_t i = 0; i < QUEUES; i++) {
        if (families[i] == UINT32_MAX)
            families[i] = families[0];
        command_buffers[i] = scene_command_buffer(scene, families[i]);
    }
}

static void create_query_pool(void)
{
    const STRUCT(VkQueryPoolCreateInfo, info,
                 .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                 .queryCount = 1);
    GET(scene->vk->CreateQueryPool(fixture.device, &info, NULL, &query_pool));
}

static VkAccelerationStructureKHR create_structure(uint32_t i)
{
    char text[64];
    const STRUCT(VkAccelerationStructureCreateInfoKHR, create_info,
                 .buffer = structures_buffer.handle, .offset = i * structure_size,
                 .size = structure_size, .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    VkAccelerationStructureKHR structure;
    GET(scene->vk->CreateAccelerationStructureKHR(fixture.device, &create_info, NULL, &structure));
    snprintf(text, sizeof(text), "mesh %u", i);
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, name,
                 .objectType = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                 .objectHandle = (uint64_t)structure, .pObjectName = text);
    GET(scene->vk->SetDebugUtilsObjectNameEXT(fixture.device, &name));
    return structure;
}

/* A structure is built, updated in place, and then twice from the one before it. The last structure
 * of a submission ends as a compacted copy of the one before. */
static void record(VkAccelerationStructureKHR *structures, uint32_t i)
{
    const uint32_t dst = i / USES_OF_A_STRUCTURE, use = i % USES_OF_A_STRUCTURE;
    const uint32_t src = use >= 2 && dst % STRUCTURES_A_SUBMISSION != 0 ? dst - 1 : dst;
    VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[0];
    scene_barrier(scene, scene->command_buffer);
    if (use == 3 && dst % STRUCTURES_A_SUBMISSION == STRUCTURES_A_SUBMISSION - 1) {
        const STRUCT(VkCopyAccelerationStructureInfoKHR, copy, .src = structures[src],
                     .dst = structures[dst],
                     .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
        scene->vk->CmdCopyAccelerationStructureKHR(scene->command_buffer, &copy);
        return;
    }
    info->mode = use != 0 ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                          : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info->srcAccelerationStructure = use != 0 ? structures[src] : VK_NULL_HANDLE;
    info->dstAccelerationStructure = structures[dst];
    const VkDeviceAddress valid = info->scratchData.deviceAddress;
    if (i % ONE_MISTAKE_IN == ONE_MISTAKE_IN - 2)
        info->scratchData.deviceAddress++;
    scene_call(scene);
    info->scratchData.deviceAddress = valid;
}

/* Returns the number of the first build of the next submission. */
static uint32_t submit(VkAccelerationStructureKHR *structures, uint32_t first, uint32_t count)
{
    const uint32_t queue = first / BUILDS_A_SUBMISSION % QUEUES;
    uint32_t i = first;
    uint64_t size;
    scene->command_buffer = command_buffers[queue];
    scene_begin(scene, scene->command_buffer, 0);
    for (; i < count && i < first + BUILDS_A_SUBMISSION; i++)
        record(structures, i);
    scene_barrier(scene, scene->command_buffer);
    scene->vk->CmdResetQueryPool(scene->command_buffer, query_pool, 0, 1);
    scene->vk->CmdWriteAccelerationStructuresPropertiesKHR(
        scene->command_buffer, 1, &structures[first / USES_OF_A_STRUCTURE],
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, query_pool, 0);
    scene_end(scene, scene->command_buffer);
    scene_submit(scene, families[queue], scene->command_buffer);
    GET(scene->vk->GetQueryPoolResults(fixture.device, query_pool, 0, 1, sizeof(size), &size,
                                       sizeof(size), VK_QUERY_RESULT_64_BIT));
    return i;
}

int main(int argc, char **argv)
{
    const uint32_t count = argc > 1 ? (uint32_t)atoi(argv[1]) : 0;
    const uint32_t structure_count = (count + USES_OF_A_STRUCTURE - 1) / USES_OF_A_STRUCTURE;
    VkAccelerationStructureKHR *structures = calloc(structure_count, sizeof(*structures));
    if (structures == NULL)
        return 3;
    open_scene(structure_count);
    create_query_pool();
    for (uint32_t i = 0; i < structure_count; i++)
        structures[i] = create_structure(i);
    for (uint32_t i = 0; i < count;)
        i = submit(structures, i, count);
    for (uint32_t i = 0; i < structure_count; i++)
        scene->vk->DestroyAccelerationStructureKHR(fixture.device, structures[i], NULL);
    scene->vk->DestroyQueryPool(fixture.device, query_pool, NULL);
    free(structures);
    scene_close(scene);
    fixture_close(&fixture);
    return 0;
}
