/* SPDX-License-Identifier: Apache-2.0 */
/* Devices, buffers and command buffers. */
#include "tests/snapshots/fixture.h"

#include <string.h>

/* ---- the device */

static void create_instance(struct fixture *fixture, const struct fixture_setup *setup)
{
    const char *level = setup->level ? setup->level : "content";
    VkLayerSettingEXT settings[] = {
        {LAYER_NAME, "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &level},
        {LAYER_NAME, "content_budget_mib", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &setup->budget_mib},
        {LAYER_NAME, "content_when_full", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &setup->when_full},
    };
    const VkLayerSettingsCreateInfoEXT given = {
        .sType = VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
        .settingCount = setup->budget_mib ? setup->when_full ? 3 : 2 : 1,
        .pSettings = settings,
    };
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_3};
    const char *layer = LAYER_NAME, *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = &given,
        .pApplicationInfo = &application,
        .enabledLayerCount = setup->has_layer,
        .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = setup->has_layer,
        .ppEnabledExtensionNames = &extension,
    };
    const PFN_vkGetInstanceProcAddr proc_addr = fixture->platform->get_instance_proc_addr;
    const PFN_vkCreateInstance create = (PFN_vkCreateInstance)proc_addr(NULL, "vkCreateInstance");
    const VkDebugUtilsMessengerCreateInfoEXT messenger = messages_messenger(&fixture->messages);
    GET(create(&info, NULL, &fixture->instance));
    vkuInitInstanceDispatchTable(fixture->instance, &fixture->instance_vk, proc_addr);
    fixture->instance_vk.CreateDevice =
        (PFN_vkCreateDevice)proc_addr(fixture->instance, "vkCreateDevice");
    fixture->get_device_proc_addr =
        (PFN_vkGetDeviceProcAddr)proc_addr(fixture->instance, "vkGetDeviceProcAddr");
    if (setup->has_layer)
        GET(fixture->instance_vk.CreateDebugUtilsMessengerEXT(fixture->instance, &messenger, NULL,
                                                              &fixture->messenger));
}

static bool has_conditional_rendering(const struct fixture *fixture)
{
    VkExtensionProperties properties[512];
    uint32_t count = sizeof(properties) / sizeof(properties[0]);
    fixture->instance_vk.EnumerateDeviceExtensionProperties(fixture->physical, NULL, &count,
                                                            properties);
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(properties[i].extensionName, VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME) == 0)
            return true;
    return false;
}

static void create_device(struct fixture *fixture)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME};
    VkPhysicalDeviceConditionalRenderingFeaturesEXT conditional = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT,
        .conditionalRendering = VK_TRUE,
    };
    fixture->has_conditional_rendering = has_conditional_rendering(fixture);
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
        .pNext = fixture->has_conditional_rendering ? &conditional : NULL,
        .accelerationStructure = VK_TRUE,
    };
    const VkPhysicalDeviceVulkan12Features core = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
        .pNext = &structures,
        .timelineSemaphore = VK_TRUE,
        .bufferDeviceAddress = VK_TRUE,
    };
    const VkPhysicalDeviceFeatures features = {.pipelineStatisticsQuery = VK_TRUE};
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &core,
        .pEnabledFeatures = &features,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue,
        .enabledExtensionCount = fixture->has_conditional_rendering ? 3 : 2,
        .ppEnabledExtensionNames = extensions,
    };
    GET(fixture->instance_vk.CreateDevice(fixture->physical, &info, NULL, &fixture->device));
    vkuInitDeviceDispatchTable(fixture->device, &fixture->vk, fixture->get_device_proc_addr);
}

static void find_memory_type(struct fixture *fixture)
{
    const VkMemoryPropertyFlags wanted =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkPhysicalDeviceMemoryProperties memory;
    fixture->instance_vk.GetPhysicalDeviceMemoryProperties(fixture->physical, &memory);
    while ((memory.memoryTypes[fixture->memory_type].propertyFlags & wanted) != wanted)
        assert_true(++fixture->memory_type < memory.memoryTypeCount);
}

void fixture_open(struct fixture *fixture, const struct platform *platform,
                  const struct fixture_setup *setup)
{
    uint32_t count = 1;
    memset(fixture, 0, sizeof(*fixture));
    fixture->platform = platform;
    create_instance(fixture, setup);
    fixture->instance_vk.EnumeratePhysicalDevices(fixture->instance, &count, &fixture->physical);
    assert_int_equal(count, 1);
    create_device(fixture);
    find_memory_type(fixture);
    const VkCommandPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
    };
    fixture->vk.GetDeviceQueue(fixture->device, 0, 0, &fixture->queue);
    GET(fixture->vk.CreateCommandPool(fixture->device, &pool, NULL, &fixture->pool));
}

void fixture_close(struct fixture *fixture)
{
    fixture->vk.DestroyCommandPool(fixture->device, fixture->pool, NULL);
    fixture->vk.DestroyDevice(fixture->device, NULL);
    if (fixture->messenger)
        fixture->instance_vk.DestroyDebugUtilsMessengerEXT(fixture->instance, fixture->messenger,
                                                           NULL);
    fixture->instance_vk.DestroyInstance(fixture->instance, NULL);
}

/* ---- objects */

struct fixture_buffer fixture_buffer(struct fixture *fixture, VkDeviceSize size,
                                     VkBufferUsageFlags usage)
{
    const VkuDeviceDispatchTable *vk = &fixture->vk;
    struct fixture_buffer buffer = {.size = size};
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    };
    GET(vk->CreateBuffer(fixture->device, &info, NULL, &buffer.handle));
    VkMemoryRequirements requirements;
    vk->GetBufferMemoryRequirements(fixture->device, buffer.handle, &requirements);
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .pNext = &flags,
                                         .allocationSize = requirements.size,
                                         .memoryTypeIndex = fixture->memory_type};
    GET(vk->AllocateMemory(fixture->device, &memory, NULL, &buffer.memory));
    GET(vk->BindBufferMemory(fixture->device, buffer.handle, buffer.memory, 0));
    GET(vk->MapMemory(fixture->device, buffer.memory, 0, VK_WHOLE_SIZE, 0, (void **)&buffer.bytes));
    memset(buffer.bytes, 0, size);
    const VkBufferDeviceAddressInfo address = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer.handle};
    buffer.address = vk->GetBufferDeviceAddress(fixture->device, &address);
    return buffer;
}

void fixture_destroy_buffer(struct fixture *fixture, struct fixture_buffer *buffer)
{
    fixture->vk.DestroyBuffer(fixture->device, buffer->handle, NULL);
    fixture->vk.FreeMemory(fixture->device, buffer->memory, NULL);
}

VkAccelerationStructureKHR fixture_structure(struct fixture *fixture,
                                             const struct fixture_buffer *buffer,
                                             VkDeviceSize offset, VkDeviceSize size,
                                             VkAccelerationStructureTypeKHR type)
{
    const VkAccelerationStructureCreateInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
        .buffer = buffer->handle,
        .offset = offset,
        .size = size,
        .type = type,
    };
    VkAccelerationStructureKHR structure;
    GET(fixture->vk.CreateAccelerationStructureKHR(fixture->device, &info, NULL, &structure));
    return structure;
}

VkFence fixture_fence(struct fixture *fixture)
{
    const VkFenceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkFence fence;
    GET(fixture->vk.CreateFence(fixture->device, &info, NULL, &fence));
    return fence;
}

/* ---- command buffers */

VkCommandBuffer fixture_begin(struct fixture *fixture, VkCommandBufferUsageFlags flags)
{
    const VkCommandBufferAllocateInfo allocate = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = fixture->pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1,
    };
    const VkCommandBufferBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = flags,
    };
    VkCommandBuffer commands;
    GET(fixture->vk.AllocateCommandBuffers(fixture->device, &allocate, &commands));
    GET(fixture->vk.BeginCommandBuffer(commands, &begin));
    return commands;
}

VkResult fixture_submit(struct fixture *fixture, VkCommandBuffer commands, VkFence fence)
{
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &commands,
    };
    return fixture->vk.QueueSubmit(fixture->queue, 1, &info, fence);
}

void fixture_finish(struct fixture *fixture, VkCommandBuffer commands)
{
    VkFence fence = fixture_fence(fixture);
    GET(fixture->vk.EndCommandBuffer(commands));
    GET(fixture_submit(fixture, commands, fence));
    GET(fixture->vk.WaitForFences(fixture->device, 1, &fence, VK_TRUE, UINT64_MAX));
    fixture->vk.DestroyFence(fixture->device, fence, NULL);
    fixture->vk.FreeCommandBuffers(fixture->device, fixture->pool, 1, &commands);
}

VkSemaphore fixture_timeline(struct fixture *fixture)
{
    const VkSemaphoreTypeCreateInfo type = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                            .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    const VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO,
                                        .pNext = &type};
    VkSemaphore timeline;
    GET(fixture->vk.CreateSemaphore(fixture->device, &info, NULL, &timeline));
    return timeline;
}

void fixture_submit_waiting(struct fixture *fixture, VkCommandBuffer commands, VkSemaphore timeline,
                            VkFence fence)
{
    static const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const uint64_t value = 1;
    const VkTimelineSemaphoreSubmitInfo values = {
        .sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO,
        .waitSemaphoreValueCount = 1,
        .pWaitSemaphoreValues = &value,
    };
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .pNext = &values,
        .waitSemaphoreCount = 1,
        .pWaitSemaphores = &timeline,
        .pWaitDstStageMask = &stages,
        .commandBufferCount = 1,
        .pCommandBuffers = &commands,
    };
    GET(fixture->vk.QueueSubmit(fixture->queue, 1, &info, fence));
}

void fixture_barrier(struct fixture *fixture, VkCommandBuffer commands)
{
    const VkMemoryBarrier memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
    };
    fixture->vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                   VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &memory, 0, NULL, 0,
                                   NULL);
}

void fixture_build_boxes(struct fixture *fixture, VkCommandBuffer commands,
                         VkAccelerationStructureKHR dst, VkDeviceAddress boxes, uint32_t count,
                         VkDeviceAddress scratch)
{
    const VkAccelerationStructureGeometryKHR geometry = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = VK_GEOMETRY_TYPE_AABBS_KHR,
        .geometry.aabbs = {.sType =
                               VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
                           .data.deviceAddress = boxes,
                           .stride = sizeof(VkAabbPositionsKHR)},
    };
    const VkAccelerationStructureBuildGeometryInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .dstAccelerationStructure = dst,
        .geometryCount = 1,
        .pGeometries = &geometry,
        .scratchData.deviceAddress = scratch,
    };
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = count},
                                                   *ranges = &range;
    fixture->vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

void fixture_expect_silence(const struct fixture *fixture)
{
    if (fixture->messages.count)
        fail_msg("%s: %s", fixture->messages.items[0].id, fixture->messages.items[0].text);
}
