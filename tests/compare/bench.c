/* SPDX-License-Identifier: Apache-2.0 */
/* Opening the device, and comparing inputs on it. */
#include "bench.h"
#include "tests/fixture/messenger.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct bench bench;

/* ---- the device */

static const char *const extensions[] = {
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_KHR_RAY_QUERY_EXTENSION_NAME, /* these two: not both; not with the layer, which enables it
                                        itself */
    VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
};

static VkResult create_device(void)
{
    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query, .rayQuery = VK_TRUE);
    STRUCT(VkPhysicalDeviceRayTracingPipelineFeaturesKHR, pipelines, .rayTracingPipeline = VK_TRUE);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
           .accelerationStructure = VK_TRUE);
    STRUCT(VkPhysicalDeviceVulkan12Features, features, .pNext = &structures,
           .bufferDeviceAddress = VK_TRUE);
    const float priority = 1;
    const STRUCT(VkDeviceQueueCreateInfo, queue, .queueCount = 1, .pQueuePriorities = &priority);
    const char *names[] = {extensions[0], extensions[1], extensions[2]};
    if (bench.kind == BENCH_PIPELINES || bench.kind == BENCH_LAYER_PIPELINES)
        names[2] = extensions[3];
    if (bench.kind != BENCH_LAYER)
        structures.pNext = bench.kind == BENCH_QUERIES ? (void *)&query : (void *)&pipelines;
    const STRUCT(VkDeviceCreateInfo, info, .pNext = &features, .queueCreateInfoCount = 1,
                 .pQueueCreateInfos = &queue,
                 .enabledExtensionCount = bench.kind == BENCH_LAYER ? 2 : 3,
                 .ppEnabledExtensionNames = names);
    return vkCreateDevice(bench.physical, &info, NULL, &bench.device);
}

MESSENGER_CALLBACK(hear)
{
    struct heard *heard = user;
    heard->count++;
    snprintf(heard->last, sizeof(heard->last), "%s", data->pMessage);
    for (enum difference d = 0; d < DIFFERENCE_COUNT; d++)
        if (data->pMessageIdName && strcmp(data->pMessageIdName, difference_id(d)) == 0) {
            heard->counts[d]++;
            snprintf(heard->texts[d], sizeof(heard->texts[d]), "%s", data->pMessage);
        }
    return VK_FALSE;
}

static VkResult create_messenger(void)
{
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, info,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                    VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                                VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
                 .pfnUserCallback = hear, .pUserData = &bench.heard);
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(bench.instance,
                                                                  "vkCreateDebugUtilsMessengerEXT");
    return create(bench.instance, &info, NULL, &bench.messenger);
}

static VkResult create_instance(void)
{
    static const char *const layer = "VK_LAYER_ASSAY_validation";
    static const char *const extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const uint32_t has_layer = bench.kind >= BENCH_LAYER;
    const STRUCT(VkInstanceCreateInfo, info,
                 .pApplicationInfo = &MAKE(VkApplicationInfo, .apiVersion = VK_API_VERSION_1_3),
                 .enabledLayerCount = has_layer, .ppEnabledLayerNames = &layer,
                 .enabledExtensionCount = has_layer, .ppEnabledExtensionNames = &extension);
    uint32_t count = 1;
    VkResult result = vkCreateInstance(&info, NULL, &bench.instance);
    if (result == VK_SUCCESS)
        result = vkEnumeratePhysicalDevices(bench.instance, &count, &bench.physical);
    if (result == VK_INCOMPLETE)
        result = VK_SUCCESS;
    return result == VK_SUCCESS && has_layer ? create_messenger() : result;
}

const char *bench_open(enum bench_kind kind)
{
    bench = (struct bench){.kind = kind};
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    setenv("VK_LAYER_PATH", LAYER_FOLDER, 1);
    setenv("VK_DRIVER_FILES", LAVAPIPE_MANIFEST, 0);
    unsetenv("VK_INSTANCE_LAYERS");
    if (create_instance() != VK_SUCCESS)
        return "no driver";
    if (create_device() != VK_SUCCESS)
        return "the driver doesn't trace so";
    STRUCT(VkPhysicalDeviceAccelerationStructurePropertiesKHR, limits);
    STRUCT(VkPhysicalDeviceRayTracingPipelinePropertiesKHR, groups, .pNext = &limits);
    STRUCT(VkPhysicalDeviceDriverProperties, driver, .pNext = &groups);
    vkGetPhysicalDeviceProperties2(bench.physical,
                                   &MAKE(VkPhysicalDeviceProperties2, .pNext = &driver));
    snprintf(bench.driver, sizeof(bench.driver), "%s", driver.driverInfo);
    vkGetPhysicalDeviceMemoryProperties(bench.physical, &bench.memory);
    vkuInitDeviceDispatchTable(bench.device, &bench.vk, vkGetDeviceProcAddr);
    vkGetDeviceQueue(bench.device, 0, 0, &bench.queue);
    pthread_mutex_init(&bench.queue_lock, NULL);
    bench.compare = (struct compare_device){
        .handle = bench.device,
        .vk = &bench.vk,
        .memory = &bench.memory,
        .scratch_alignment = limits.minAccelerationStructureScratchOffsetAlignment,
        .queue_lock = &bench.queue_lock,
        .has_queries = kind == BENCH_QUERIES,
        .group_handle_size = groups.shaderGroupHandleSize,
        .group_handle_alignment = groups.shaderGroupHandleAlignment,
        .group_base_alignment = groups.shaderGroupBaseAlignment,
    };
    if (kind >= BENCH_LAYER) {
        bench.pool = command_pool_create(&bench.vk, bench.device);
        return NULL;
    }
    return tracer_create(&bench.compare, &bench.tracer) == VK_SUCCESS ? NULL : "no pipeline";
}

void bench_close(void)
{
    PFN_vkDestroyDebugUtilsMessengerEXT destroy =
        (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
            bench.instance, "vkDestroyDebugUtilsMessengerEXT");
    tracer_destroy(bench.tracer);
    if (bench.pool)
        vkDestroyCommandPool(bench.device, bench.pool, NULL);
    if (bench.device)
        vkDestroyDevice(bench.device, NULL);
    if (bench.messenger)
        destroy(bench.instance, bench.messenger, NULL);
    if (bench.instance)
        vkDestroyInstance(bench.instance, NULL);
}

const char *bench_open_tests(const char *argument, enum bench_kind queries,
                             enum bench_kind pipelines)
{
    const bool wants_pipelines = argument && strcmp(argument, "pipelines") == 0;
    const char *lacks = bench_open(wants_pipelines ? pipelines : queries);
    if (!lacks)
        print_message("%s\n", bench.driver);
    soup_fill();
    return lacks;
}

VkCommandBuffer bench_begin(void)
{
    return commands_begin(&bench.vk, bench.device, bench.pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0,
                          NULL);
}

void bench_submit(VkCommandBuffer commands)
{
    GET(vkEndCommandBuffer(commands));
    GET(commands_submit(&bench.vk, bench.queue, commands, VK_NULL_HANDLE));
}

void bench_finish(VkCommandBuffer commands)
{
    GET(vkQueueWaitIdle(bench.queue));
    vkFreeCommandBuffers(bench.device, bench.pool, 1, &commands);
}

/* ---- comparing */

void bench_compare(const struct subject *source, const struct subject *subject, uint32_t count,
                   struct tally *tally)
{
    struct reference reference;
    struct rays rays;
    struct input_copy *copy = input_copy_create(&subject->input);
    assert_non_null(copy);
    GET(reference_open(copy, &reference));
    GET(rays_create(&reference, count, &rays));
    struct compare_answer *answers = calloc(rays.count + 1ull, sizeof(*answers));
    assert_non_null(answers);
    struct compare_input inputs[2] = {subject->input, subject->input};
    if (source)
        inputs[0] = source->input;
    const struct tracer_job job = {
        .queue = bench.queue,
        .input_count = source ? 2 : 1,
        .inputs = inputs,
        .ray_count = rays.count,
        .rays = rays.rays,
        .answers = answers,
    };
    GET(tracer_run(bench.tracer, &job));
    tally_judge(tally, &reference, &rays, answers);
    free(answers);
    rays_free(&rays);
    reference_close(&reference);
    input_copy_free(copy);
}
