/* SPDX-License-Identifier: Apache-2.0 */
/* accuracy_effects EFFECT USE TIMES: for callgrind, which collects in counted_runs() alone. Records
 * and submits a scene of BUILDS builds that many times, with the layer at its default level on the
 * null driver, and prints how many builds that were. USE is one of
 *
 *   never   plain meshes, where the effect is off, or nothing of it has ever been done
 *   unused  the same meshes, where it is on, and a scene that used it has come and gone
 *   used    builds that use it
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "probes.h"
#include "tests/fixture/make.h"
#include "tests/player/scene/scene.h"

enum { BUILDS = 24, FIRST = SCENE_BASE_BUILDS };

enum use { NEVER, UNUSED, USED, USES };
static const char *const use_names[USES] = {"never", "unused", "used"};

/* A scene, the builds of which are alike, and what follows them in the command buffer. */
struct run {
    struct scene *scene;
    uint32_t family;
    VkCommandBuffer command_buffer;
    VkQueryPool queries; /* of compacted sizes; null: none are asked for */
    VkAccelerationStructureKHR compacted[BUILDS];
};

struct effect {
    const char *name;
    const char *with, *never; /* of setups: where it isn't `never`, and where it is; or NULL */
    enum build_command command;
    void (*use)(struct run *run); /* before the first run; builds are plain as yet */
};

/* ---- effects */

/* The builds like `model`, each with a dst and scratch of its own. */
static void become(struct run *run, uint32_t model)
{
    struct scene *scene = run->scene;
    scene->info_count = FIRST;
    for (uint32_t i = 0; i < BUILDS; i++)
        scene_add_build(scene, model);
}

static void record(struct run *run);

static void use_update(struct run *run)
{
    struct scene *scene = run->scene;
    for (uint32_t i = FIRST; i < FIRST + BUILDS; i++)
        scene->infos[i].flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    record(run);
    for (uint32_t i = FIRST; i < FIRST + BUILDS; i++) {
        scene->infos[i].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        scene->infos[i].srcAccelerationStructure = scene->infos[i].dstAccelerationStructure;
    }
}

SCENE_CREATES(create_queries, QueryPool, VkQueryPool, VkQueryPoolCreateInfo)

static void use_compaction(struct run *run)
{
    struct scene *scene = run->scene;
    const VkQueryPoolCreateInfo create_info = MAKE(
        VkQueryPoolCreateInfo, .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        .queryCount = BUILDS);
    run->queries = create_queries(scene, &create_info);
    for (uint32_t i = 0; i < BUILDS; i++) {
        scene->infos[FIRST + i].flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
        run->compacted[i] = scene_accel_for(scene, FIRST + i);
    }
}

static void use_instances(struct run *run)
{
    become(run, TLAS);
}

static void use_motion(struct run *run)
{
    struct scene *scene = run->scene;
    scene->motion = MAKE(VkAccelerationStructureGeometryMotionTrianglesDataNV,
                         .vertexData.deviceAddress = scene_address(scene, &scene->vertices, 0));
    for (uint32_t i = FIRST; i < FIRST + BUILDS; i++) {
        const VkAccelerationStructureCreateInfoKHR create_info = MAKE(
            VkAccelerationStructureCreateInfoKHR,
            .createFlags = VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV,
            .buffer = scene->dst_buffers[i].handle,
            .size = scene_sizes(scene, i).accelerationStructureSize, .type = scene->infos[i].type);
        scene->infos[i].flags = VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
        scene->infos[i].dstAccelerationStructure = scene_create_accel(scene, &create_info);
        scene->geometries[i][0].geometry.triangles.pNext = &scene->motion;
    }
}

static void use_micromap(struct run *run)
{
    struct scene *scene = run->scene;
    const VkCommandBuffer own = scene->command_buffer;
    scene_use_micromap(scene);
    scene_begin(scene, run->command_buffer, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    scene->command_buffer = run->command_buffer;
    scene->micromaps.opacity.micromap = scene_record_micromap(scene, 4);
    scene->command_buffer = own;
    scene_end(scene, run->command_buffer);
    scene_submit(scene, run->family, run->command_buffer);
    for (uint32_t i = FIRST; i < FIRST + BUILDS; i++)
        scene->geometries[i][0].geometry.triangles.pNext = &scene->micromaps.opacity;
}

static void use_spheres(struct run *run)
{
    struct scene *scene = run->scene;
    scene->info_count = FIRST;
    scene_add_spheres(scene);
    for (uint32_t i = 1; i < BUILDS; i++)
        scene_add_build(scene, FIRST);
}

static const struct effect effects[] = {
    {"update", NULL, NULL, COMMAND_DEVICE, use_update},
    {"compaction", NULL, NULL, COMMAND_DEVICE, use_compaction},
    {"instances", NULL, NULL, COMMAND_DEVICE, use_instances},
    {"motion", WITH_MOTION, NULL, COMMAND_DEVICE, use_motion},
    {"micromap", WITH_MICROMAP_KHR, NULL, COMMAND_DEVICE, use_micromap},
    {"spheres", WITH_SPHERES, NULL, COMMAND_DEVICE, use_spheres},
    {"indirect", NULL, "-accelerationStructureIndirectBuild", COMMAND_INDIRECT, NULL},
};
enum { EFFECTS = sizeof(effects) / sizeof(effects[0]) };

/* ---- running a scene */

static void compact(struct run *run)
{
    struct scene *scene = run->scene;
    VkAccelerationStructureKHR built[BUILDS];
    for (uint32_t i = 0; i < BUILDS; i++)
        built[i] = scene->infos[FIRST + i].dstAccelerationStructure;
    scene->vk->CmdResetQueryPool(run->command_buffer, run->queries, 0, BUILDS);
    scene->vk->CmdWriteAccelerationStructuresPropertiesKHR(
        run->command_buffer, BUILDS, built, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        run->queries, 0);
    for (uint32_t i = 0; i < BUILDS; i++) {
        const VkCopyAccelerationStructureInfoKHR copy =
            MAKE(VkCopyAccelerationStructureInfoKHR, .src = built[i], .dst = run->compacted[i],
                 .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
        scene->vk->CmdCopyAccelerationStructureKHR(run->command_buffer, &copy);
    }
}

static void record(struct run *run)
{
    struct scene *scene = run->scene;
    scene_begin(scene, run->command_buffer, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    scene->infos_argument = &scene->infos[FIRST];
    scene->ranges_argument = &scene->range_pointers[FIRST];
    scene->counts_argument = &scene->count_pointers[FIRST];
    scene->indirect_addresses_argument = &scene->indirect_addresses[FIRST];
    scene->indirect_strides_argument = &scene->indirect_strides[FIRST];
    scene->info_count = BUILDS;
    const VkCommandBuffer own = scene->command_buffer;
    scene->command_buffer = run->command_buffer;
    scene_call(scene);
    scene->command_buffer = own;
    if (run->queries != VK_NULL_HANDLE)
        compact(run);
    scene_end(scene, run->command_buffer);
    scene_submit(scene, run->family, run->command_buffer);
}

__attribute__((noipa)) void counted_runs(struct run *run, uint32_t times);
void counted_runs(struct run *run, uint32_t times)
{
    for (uint32_t i = 0; i < times; i++)
        record(run);
}

static void open_run(struct run *run, struct fixture *fixture, const struct effect *effect)
{
    const bool is_used = effect != NULL;
    *run = (struct run){.scene = scene_open(fixture, is_used ? effect->command : COMMAND_DEVICE),
                        .family = fixture_find_family(fixture, VK_QUEUE_COMPUTE_BIT, 0)};
    run->command_buffer = scene_command_buffer(run->scene, run->family);
    run->scene->infos[INDEXED].flags = 0;
    run->scene->infos[TLAS].flags = 0;
    run->scene->infos[UNINDEXED].flags = 0;
    become(run, INDEXED);
    if (is_used && effect->use != NULL)
        effect->use(run);
}

/* ---- the program */

enum { WARM_UPS = 3 };

static int run_effect(const struct effect *effect, enum use use, uint32_t times)
{
    static struct platform platform;
    static struct fixture fixture;
    struct run run, other;
    const struct setup setup = {.with = use == NEVER ? effect->never : effect->with};
    const char *missing = platform_open(&platform, "null");
    if (missing == NULL)
        missing = fixture_open(&fixture, &platform, &setup);
    if (missing != NULL) {
        fprintf(stderr, "accuracy_effects: %s\n", missing);
        return EXIT_FAILURE;
    }
    open_run(&run, &fixture, use == USED ? effect : NULL);
    open_run(&other, &fixture, use == UNUSED ? effect : NULL);
    record(&other);
    scene_close(other.scene);
    probes_advance_clock();            /* else a slow machine counts more probes */
    for (int i = 0; i < WARM_UPS; i++) /* what is kept has its place then */
        record(&run);
    counted_runs(&run, times);
    printf("%u builds\n", times * BUILDS);
    scene_close(run.scene);
    const bool is_silent = fixture.instance.messages.count == 0;
    if (!is_silent)
        fprintf(stderr, "accuracy_effects: %s\n", fixture.instance.messages.items[0].text);
    fixture_close(&fixture);
    return is_silent ? EXIT_SUCCESS : EXIT_FAILURE;
}

int main(int count, char **arguments)
{
    const uint32_t times = count == 4 ? (uint32_t)strtoul(arguments[3], NULL, 10) : 0;
    for (int effect = 0; effect < EFFECTS && times > 0; effect++)
        for (int use = 0; use < USES; use++)
            if (strcmp(arguments[1], effects[effect].name) == 0 &&
                strcmp(arguments[2], use_names[use]) == 0)
                return run_effect(&effects[effect], (enum use)use, times);
    fputs("usage: accuracy_effects EFFECT never|unused|used TIMES; effects:", stderr);
    for (int effect = 0; effect < EFFECTS; effect++)
        fprintf(stderr, " %s", effects[effect].name);
    fputc('\n', stderr);
    return 2;
}
