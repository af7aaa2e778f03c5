/* SPDX-License-Identifier: Apache-2.0 */
/* Opening the device, and comparing inputs on it. */
#include "bench.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

/* ---- the device */

static const char *const extensions[] = {
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_KHR_RAY_QUERY_EXTENSION_NAME,
};

static VkResult create_device(struct bench *bench)
{
    VkPhysicalDeviceRayQueryFeaturesKHR query = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR, .rayQuery = VK_TRUE};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
        .pNext = &query,
        .accelerationStructure = VK_TRUE};
    VkPhysicalDeviceVulkan12Features features = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
        .pNext = &structures,
        .bufferDeviceAddress = VK_TRUE};
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueCount = 1,
        .pQueuePriorities = &priority,
    };
    const VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &features,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue,
        .enabledExtensionCount = sizeof(extensions) / sizeof(*extensions),
        .ppEnabledExtensionNames = extensions,
    };
    return vkCreateDevice(bench->physical, &info, NULL, &bench->device);
}

static VkResult create_instance(struct bench *bench)
{
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pApplicationInfo = &application};
    uint32_t count = 1;
    VkResult result = vkCreateInstance(&info, NULL, &bench->instance);
    if (result == VK_SUCCESS)
        result = vkEnumeratePhysicalDevices(bench->instance, &count, &bench->physical);
    return result == VK_SUCCESS || result == VK_INCOMPLETE ? VK_SUCCESS : result;
}

const char *bench_open(struct bench *bench)
{
    *bench = (struct bench){0};
    setenv("VK_LOADER_LAYERS_DISABLE", "~all~", 1);
    setenv("VK_DRIVER_FILES", LAVAPIPE_MANIFEST, 0);
    unsetenv("VK_INSTANCE_LAYERS");
    if (create_instance(bench) != VK_SUCCESS)
        return "no driver";
    if (create_device(bench) != VK_SUCCESS)
        return "the driver has no ray queries";
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
    VkPhysicalDeviceDriverProperties driver = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, .pNext = &limits};
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver};
    vkGetPhysicalDeviceProperties2(bench->physical, &properties);
    snprintf(bench->driver, sizeof(bench->driver), "%s", driver.driverInfo);
    vkGetPhysicalDeviceMemoryProperties(bench->physical, &bench->memory);
    vkuInitDeviceDispatchTable(bench->device, &bench->vk, vkGetDeviceProcAddr);
    vkGetDeviceQueue(bench->device, 0, 0, &bench->queue);
    pthread_mutex_init(&bench->queue_lock, NULL);
    bench->compare = (struct compare_device){
        .handle = bench->device,
        .vk = &bench->vk,
        .memory = &bench->memory,
        .scratch_alignment = limits.minAccelerationStructureScratchOffsetAlignment,
        .queue_lock = &bench->queue_lock,
    };
    return tracer_create(&bench->compare, &bench->tracer) == VK_SUCCESS ? NULL : "no pipeline";
}

void bench_close(struct bench *bench)
{
    tracer_destroy(bench->tracer);
    if (bench->device)
        vkDestroyDevice(bench->device, NULL);
    if (bench->instance)
        vkDestroyInstance(bench->instance, NULL);
}

/* ---- comparing */

void bench_compare(struct bench *bench, const struct subject *source, const struct subject *subject,
                   uint32_t count, struct tally *tally)
{
    struct reference reference;
    struct rays rays;
    assert_int_equal(reference_open(&subject->input, &reference), VK_SUCCESS);
    assert_int_equal(rays_create(&reference, count, &rays), VK_SUCCESS);
    struct compare_answer *answers = calloc(rays.count + 1ull, sizeof(*answers));
    assert_non_null(answers);
    struct tracer_job job = {
        .queue = bench->queue,
        .input_count = 1,
        .inputs = {subject->input},
        .ray_count = rays.count,
        .rays = rays.rays,
        .answers = answers,
    };
    if (source) {
        job.inputs[0] = source->input;
        job.inputs[job.input_count++] = subject->input;
    }
    assert_int_equal(tracer_run(bench->tracer, &job), VK_SUCCESS);
    tally_judge(tally, &reference, &rays, answers);
    free(answers);
    rays_free(&rays);
    reference_close(&reference);
}
