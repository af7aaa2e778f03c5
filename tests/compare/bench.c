/* SPDX-License-Identifier: Apache-2.0 */
/* Opening the device, and submitting to it. */
#include "bench.h"

#include <stdlib.h>
#include <string.h>

struct bench bench;

/* ---- the device */

static VkResult create_device(void)
{
    const char *extensions[3] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                 VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
    STRUCT(VkPhysicalDeviceRayTracingPipelineFeaturesKHR, pipelines, .rayTracingPipeline = VK_TRUE);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
           .accelerationStructure = VK_TRUE);
    uint32_t count = 2;
    if (bench.kind == BENCH_PIPELINES) { /* else the layer enables what it needs itself */
        extensions[count++] = VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME;
        structures.pNext = &pipelines;
    }
    return instance_fixture_create_device(&bench.instance, &structures, extensions, count,
                                          &bench.device, &bench.vk);
}

/* One thread uses the queue. */
static bool begin_submission(void *queues, VkQueue queue)
{
    return !queues && queue;
}

static void end_submission(void *queues)
{
    (void)queues;
}

const char *bench_open(enum bench_kind kind)
{
    static const struct platform platform = {.get_instance_proc_addr = vkGetInstanceProcAddr};
    memset(&bench, 0, sizeof(bench));
    bench.kind = kind;
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    setenv("VK_LAYER_PATH", LAYER_FOLDER, 1);
    setenv("VK_DRIVER_FILES", LAVAPIPE_MANIFEST, 0);
    unsetenv("VK_INSTANCE_LAYERS");
    instance_fixture_create(&bench.instance, &platform, &(struct instance_settings){0});
    if (create_device() != VK_SUCCESS)
        return "the driver doesn't trace so";
    STRUCT(VkPhysicalDeviceAccelerationStructurePropertiesKHR, limits);
    STRUCT(VkPhysicalDeviceDriverProperties, driver, .pNext = &limits);
    const VkPhysicalDevice physical = bench.instance.physical;
    vkGetPhysicalDeviceProperties2(physical, &MAKE(VkPhysicalDeviceProperties2, .pNext = &driver));
    memcpy(bench.driver, driver.driverInfo, sizeof(bench.driver));
    vkGetPhysicalDeviceMemoryProperties(physical, &bench.memory);
    vkGetDeviceQueue(bench.device, 0, 0, &bench.queue);
    bench.compare = (struct compare_device){
        .handle = bench.device,
        .vk = &bench.vk,
        .memory = &bench.memory,
        .scratch_alignment = limits.minAccelerationStructureScratchOffsetAlignment,
        .begin_submission = begin_submission,
        .end_submission = end_submission,
    };
    bench.pool = command_pool_create(&bench.vk, bench.device);
    return NULL;
}

void bench_close(void)
{
    if (bench.pool)
        vkDestroyCommandPool(bench.device, bench.pool, NULL);
    if (bench.device)
        vkDestroyDevice(bench.device, NULL);
    instance_fixture_close(&bench.instance);
}

const char *bench_open_tests(const char *argument)
{
    const bool wants_pipelines = argument && strcmp(argument, "pipelines") == 0;
    const char *lacks = bench_open(wants_pipelines ? BENCH_PIPELINES : BENCH_PLAIN);
    if (!lacks)
        print_message("%s\n", bench.driver);
    soup_fill();
    return lacks;
}

uint32_t bench_count(enum difference difference)
{
    return messages_count(&bench.instance.messages, difference_id(difference), NULL);
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
