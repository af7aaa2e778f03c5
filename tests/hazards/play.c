/* SPDX-License-Identifier: Apache-2.0 */
/* The device of a case, and its lines. */
#include "play.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Noreturn void play_fail(const struct play *play, const char *what)
{
    fprintf(stderr, "%s.cases:%u: %s\n", play->program->group,
            play->program->lines[play->at].number, what);
    exit(2);
}

/* ---- the device */

struct device_features {
    VkPhysicalDeviceFeatures2 core;
    VkPhysicalDeviceVulkan12Features core_12;
    VkPhysicalDeviceVulkan13Features core_13;
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures;
    VkPhysicalDeviceRayTracingMaintenance1FeaturesKHR maintenance;
    VkPhysicalDeviceOpacityMicromapFeaturesEXT micromaps;
};

/* Whether the program has a line of these two words. */
static bool has_line(const struct hazard_case *program, const char *first, const char *second)
{
    bool found = false;
    for (unsigned i = 0; i < program->line_count; i++)
        found |= play_is(program->lines[i].words[0], first) &&
                 play_is(program->lines[i].words[1], second);
    return found;
}

/* Enables all features that the device has, and the program does not disable. */
static void find_features(struct play *play, struct device_features *features)
{
    const struct instance_fixture *fixture = play->fixture;
    features->core = MAKE(VkPhysicalDeviceFeatures2, .pNext = &features->core_12);
    features->core_12 = MAKE(VkPhysicalDeviceVulkan12Features, .pNext = &features->core_13);
    features->core_13 = MAKE(VkPhysicalDeviceVulkan13Features, .pNext = &features->structures);
    features->structures = MAKE(VkPhysicalDeviceAccelerationStructureFeaturesKHR);
    features->maintenance = MAKE(VkPhysicalDeviceRayTracingMaintenance1FeaturesKHR);
    features->micromaps = MAKE(VkPhysicalDeviceOpacityMicromapFeaturesEXT);
    if (play->has_copy_stage) {
        features->maintenance.pNext = features->structures.pNext;
        features->structures.pNext = &features->maintenance;
    }
    if (play->has_micromaps) {
        features->micromaps.pNext = features->structures.pNext;
        features->structures.pNext = &features->micromaps;
    }
    fixture->vk.GetPhysicalDeviceFeatures2(fixture->physical, &features->core);
    features->core.features.robustBufferAccess = VK_FALSE;
    features->structures.accelerationStructureCaptureReplay = VK_FALSE;
    if (has_line(play->program, "without", "maintenance1"))
        features->maintenance.rayTracingMaintenance1 = VK_FALSE;
    if (has_line(play->program, "without", "synchronization2"))
        features->core_13.synchronization2 = VK_FALSE;
    play->has_indirect = features->structures.accelerationStructureIndirectBuild;
    play->has_host = features->structures.accelerationStructureHostCommands;
}

/* Chooses the queues: two of family 0, one of family 1, as far as there are. */
static uint32_t choose_queues(const struct play *play, VkDeviceQueueCreateInfo infos[2])
{
    static const float priorities[] = {1, 1};
    VkQueueFamilyProperties families[8];
    uint32_t count = ARRAY_COUNT(families);
    play->fixture->vk.GetPhysicalDeviceQueueFamilyProperties(play->fixture->physical, &count,
                                                             families);
    infos[0] = MAKE(VkDeviceQueueCreateInfo, .queueCount = families[0].queueCount > 1 ? 2 : 1,
                    .pQueuePriorities = priorities);
    infos[1] = MAKE(VkDeviceQueueCreateInfo, .queueFamilyIndex = 1, .queueCount = 1,
                    .pQueuePriorities = priorities);
    return count > 1 && families[1].queueFlags & VK_QUEUE_COMPUTE_BIT ? 2 : 1;
}

static void create_device(struct play *play)
{
    const struct instance_fixture *fixture = play->fixture;
    static const char *const optional[] = {VK_KHR_RAY_TRACING_MAINTENANCE_1_EXTENSION_NAME,
                                           VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
                                           VK_AMD_BUFFER_MARKER_EXTENSION_NAME};
    const char *extensions[2 + ARRAY_COUNT(optional)] = {
        VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
        VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
    bool *const has[] = {&play->has_copy_stage, &play->has_micromaps, &play->has_markers};
    struct device_features features;
    VkDeviceQueueCreateInfo queues[2];
    uint32_t count = 2;
    for (size_t i = 0; i < ARRAY_COUNT(optional); i++) {
        *has[i] = instance_fixture_count_extension(fixture, optional[i]) > 0;
        if (*has[i])
            extensions[count++] = optional[i];
    }
    find_features(play, &features);
    const STRUCT(VkDeviceCreateInfo, info, .pNext = &features.core,
                 .queueCreateInfoCount = choose_queues(play, queues), .pQueueCreateInfos = queues,
                 .enabledExtensionCount = count, .ppEnabledExtensionNames = extensions);
    GET(fixture->vk.CreateDevice(fixture->physical, &info, NULL, &play->device));
    vkuInitDeviceDispatchTable(play->device, &play->vk, fixture->get_device_proc_addr);
    for (uint32_t i = 0; i < info.queueCreateInfoCount; i++) {
        for (uint32_t j = 0; j < queues[i].queueCount; j++)
            play->vk.GetDeviceQueue(play->device, i, j, &play->queues[2 * i + j]);
        const STRUCT(VkCommandPoolCreateInfo, pool, .queueFamilyIndex = i);
        GET(play->vk.CreateCommandPool(play->device, &pool, NULL, &play->pools[i]));
    }
}

static void create_shared(struct play *play)
{
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    const STRUCT(VkBufferCreateInfo, scratch, .size = 4 * 1024 * 1024, .usage = usage);
    const STRUCT(VkBufferCreateInfo, instances, .size = PLAY_BUFFER_SIZE, .usage = usage);
    play->scratch = buffer_create(&play->vk, play->device, play->memory_type, &scratch);
    play->instances = buffer_create(&play->vk, play->device, play->memory_type, &instances);
    play->fence = fence_create(&play->vk, play->device);
}

static void close_device(struct play *play)
{
    const VkuDeviceDispatchTable *vk = &play->vk;
    for (int i = 0; i < 2; i++)
        vk->DestroyCommandPool(play->device, play->pools[i], NULL);
    vk->DestroyFramebuffer(play->device, play->framebuffer, NULL);
    vk->DestroyRenderPass(play->device, play->render_pass, NULL);
    vk->DestroyFence(play->device, play->fence, NULL);
    play_destroy_objects(play);
    if (play->scratch.handle)
        buffer_destroy(vk, play->device, &play->scratch);
    if (play->instances.handle)
        buffer_destroy(vk, play->device, &play->instances);
    vk->DestroyDevice(play->device, NULL);
}

/* ---- the program */

static bool has_word(const struct hazard_case *program, const char *word)
{
    for (unsigned i = 0; i < program->line_count; i++)
        for (char *const *at = program->lines[i].words; *at; at++)
            if (strncmp(*at, word, strlen(word)) == 0)
                return true;
    return false;
}

static bool has_host_work(const struct hazard_case *program)
{
    static const char *const others[] = {"wait", "poll", "signal", "set"};
    bool found = false;
    for (unsigned i = 0; i < program->line_count; i++) {
        char *const *words = program->lines[i].words;
        bool is_other = !play_is(words[0], "host");
        for (size_t j = 0; j < ARRAY_COUNT(others); j++)
            is_other |= play_is(words[1], others[j]);
        found |= !is_other;
    }
    return found;
}

/* Returns what the program needs and the device lacks. */
static const char *missing(const struct play *play)
{
    const struct hazard_case *program = play->program;
    const struct {
        const char *word, *what;
        bool is_there;
    } needs[] = {
        {"only", "the null driver", play->fixture->platform->is_null},
        {"q1", "a second queue", play->queues[1]},
        {"q2", "a second queue family", play->queues[2]},
        {"indirect", "indirect builds", play->has_indirect},
        {"micromap", "micromaps", play->has_micromaps},
        {"marker", "VK_AMD_buffer_marker", play->has_markers},
        {"accel_copy", "VK_KHR_ray_tracing_maintenance1", play->has_copy_stage},
    };
    for (size_t i = 0; i < ARRAY_COUNT(needs); i++)
        if (!needs[i].is_there && has_word(program, needs[i].word))
            return needs[i].what;
    return has_host_work(program) && !play->has_host ? "builds on the host" : NULL;
}

static void play_line(struct play *play, const struct case_line *line)
{
    char *words[CASE_WORDS + 1];
    memcpy(words, line->words, sizeof(words));
    if (play_is(words[0], "only") || play_is(words[0], "without"))
        return;
    if (play_is(words[0], "alias"))
        play_alias(play, words);
    else if (play_is(words[0], "place"))
        play_put(play, words);
    else if (play_is(words[0], "init"))
        play_init(play, words);
    else if (!play_submit(play, words) && !play_sync(play, words) && !play_copy(play, words) &&
             !play_build(play, words))
        play_fail(play, "unknown command");
}

static void play_lines(struct play *play)
{
    const struct hazard_case *program = play->program;
    create_shared(play);
    for (play->at = 0; play->at < program->line_count; play->at++)
        if (program->lines[play->at].mark != (play->is_repaired ? '-' : '+'))
            play_line(play, &program->lines[play->at]);
    play->at = program->line_count - 1;
    play_finish(play);
}

const char *play_case(struct instance_fixture *fixture, const struct hazard_case *program,
                      bool is_repaired)
{
    struct play play = {.fixture = fixture,
                        .program = program,
                        .is_repaired = is_repaired,
                        .memory_type = instance_fixture_memory_type(fixture)};
    create_device(&play);
    const char *reason = missing(&play);
    if (!reason)
        play_lines(&play);
    close_device(&play);
    return reason;
}
