/* SPDX-License-Identifier: Apache-2.0 */
/* Devices, buffers and command buffers. */
#include "stage.h"

#include <string.h>

/* ---- the device */

static void create_instance(struct stage *stage, const struct stage_setup *setup)
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
    const PFN_vkGetInstanceProcAddr proc_addr = stage->platform->get_instance_proc_addr;
    const PFN_vkCreateInstance create = (PFN_vkCreateInstance)proc_addr(NULL, "vkCreateInstance");
    const VkDebugUtilsMessengerCreateInfoEXT messenger = messages_messenger(&stage->messages);
    GET(create(&info, NULL, &stage->instance));
    vkuInitInstanceDispatchTable(stage->instance, &stage->instance_vk, proc_addr);
    stage->instance_vk.CreateDevice =
        (PFN_vkCreateDevice)proc_addr(stage->instance, "vkCreateDevice");
    stage->get_device_proc_addr =
        (PFN_vkGetDeviceProcAddr)proc_addr(stage->instance, "vkGetDeviceProcAddr");
    if (setup->has_layer)
        GET(stage->instance_vk.CreateDebugUtilsMessengerEXT(stage->instance, &messenger, NULL,
                                                            &stage->messenger));
}

static bool has_conditional_rendering(const struct stage *stage)
{
    VkExtensionProperties properties[512];
    uint32_t count = sizeof(properties) / sizeof(properties[0]);
    stage->instance_vk.EnumerateDeviceExtensionProperties(stage->physical, NULL, &count,
                                                          properties);
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(properties[i].extensionName, VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME) == 0)
            return true;
    return false;
}

static void create_device(struct stage *stage)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_EXT_CONDITIONAL_RENDERING_EXTENSION_NAME};
    VkPhysicalDeviceConditionalRenderingFeaturesEXT conditional = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT,
        .conditionalRendering = VK_TRUE,
    };
    stage->has_conditional_rendering = has_conditional_rendering(stage);
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
        .pNext = stage->has_conditional_rendering ? &conditional : NULL,
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
        .enabledExtensionCount = stage->has_conditional_rendering ? 3 : 2,
        .ppEnabledExtensionNames = extensions,
    };
    GET(stage->instance_vk.CreateDevice(stage->physical, &info, NULL, &stage->device));
    vkuInitDeviceDispatchTable(stage->device, &stage->vk, stage->get_device_proc_addr);
}

static void find_memory_type(struct stage *stage)
{
    const VkMemoryPropertyFlags wanted =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkPhysicalDeviceMemoryProperties memory;
    stage->instance_vk.GetPhysicalDeviceMemoryProperties(stage->physical, &memory);
    while ((memory.memoryTypes[stage->memory_type].propertyFlags & wanted) != wanted)
        assert_true(++stage->memory_type < memory.memoryTypeCount);
}

void stage_open(struct stage *stage, const struct platform *platform,
                const struct stage_setup *setup)
{
    uint32_t count = 1;
    memset(stage, 0, sizeof(*stage));
    stage->platform = platform;
    create_instance(stage, setup);
    stage->instance_vk.EnumeratePhysicalDevices(stage->instance, &count, &stage->physical);
    assert_int_equal(count, 1);
    create_device(stage);
    find_memory_type(stage);
    const VkCommandPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
    };
    stage->vk.GetDeviceQueue(stage->device, 0, 0, &stage->queue);
    GET(stage->vk.CreateCommandPool(stage->device, &pool, NULL, &stage->pool));
}

void stage_close(struct stage *stage)
{
    stage->vk.DestroyCommandPool(stage->device, stage->pool, NULL);
    stage->vk.DestroyDevice(stage->device, NULL);
    if (stage->messenger)
        stage->instance_vk.DestroyDebugUtilsMessengerEXT(stage->instance, stage->messenger, NULL);
    stage->instance_vk.DestroyInstance(stage->instance, NULL);
}

/* ---- objects */

struct stage_buffer stage_buffer(struct stage *stage, VkDeviceSize size, VkBufferUsageFlags usage)
{
    const VkuDeviceDispatchTable *vk = &stage->vk;
    struct stage_buffer buffer = {.size = size};
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
    };
    GET(vk->CreateBuffer(stage->device, &info, NULL, &buffer.handle));
    VkMemoryRequirements requirements;
    vk->GetBufferMemoryRequirements(stage->device, buffer.handle, &requirements);
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .pNext = &flags,
                                         .allocationSize = requirements.size,
                                         .memoryTypeIndex = stage->memory_type};
    GET(vk->AllocateMemory(stage->device, &memory, NULL, &buffer.memory));
    GET(vk->BindBufferMemory(stage->device, buffer.handle, buffer.memory, 0));
    GET(vk->MapMemory(stage->device, buffer.memory, 0, VK_WHOLE_SIZE, 0, (void **)&buffer.bytes));
    memset(buffer.bytes, 0, size);
    const VkBufferDeviceAddressInfo address = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer.handle};
    buffer.address = vk->GetBufferDeviceAddress(stage->device, &address);
    return buffer;
}

void stage_destroy_buffer(struct stage *stage, struct stage_buffer *buffer)
{
    stage->vk.DestroyBuffer(stage->device, buffer->handle, NULL);
    stage->vk.FreeMemory(stage->device, buffer->memory, NULL);
}

VkAccelerationStructureKHR stage_structure(struct stage *stage, const struct stage_buffer *buffer,
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
    GET(stage->vk.CreateAccelerationStructureKHR(stage->device, &info, NULL, &structure));
    return structure;
}

VkFence stage_fence(struct stage *stage)
{
    const VkFenceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkFence fence;
    GET(stage->vk.CreateFence(stage->device, &info, NULL, &fence));
    return fence;
}

/* ---- command buffers */

VkCommandBuffer stage_begin(struct stage *stage, VkCommandBufferUsageFlags flags)
{
    const VkCommandBufferAllocateInfo allocate = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = stage->pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1,
    };
    const VkCommandBufferBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = flags,
    };
    VkCommandBuffer commands;
    GET(stage->vk.AllocateCommandBuffers(stage->device, &allocate, &commands));
    GET(stage->vk.BeginCommandBuffer(commands, &begin));
    return commands;
}

VkResult stage_submit(struct stage *stage, VkCommandBuffer commands, VkFence fence)
{
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &commands,
    };
    return stage->vk.QueueSubmit(stage->queue, 1, &info, fence);
}

void stage_finish(struct stage *stage, VkCommandBuffer commands)
{
    VkFence fence = stage_fence(stage);
    GET(stage->vk.EndCommandBuffer(commands));
    GET(stage_submit(stage, commands, fence));
    GET(stage->vk.WaitForFences(stage->device, 1, &fence, VK_TRUE, UINT64_MAX));
    stage->vk.DestroyFence(stage->device, fence, NULL);
    stage->vk.FreeCommandBuffers(stage->device, stage->pool, 1, &commands);
}

VkSemaphore stage_timeline(struct stage *stage)
{
    const VkSemaphoreTypeCreateInfo type = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                            .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    const VkSemaphoreCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO,
                                        .pNext = &type};
    VkSemaphore timeline;
    GET(stage->vk.CreateSemaphore(stage->device, &info, NULL, &timeline));
    return timeline;
}

void stage_submit_waiting(struct stage *stage, VkCommandBuffer commands, VkSemaphore timeline,
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
    GET(stage->vk.QueueSubmit(stage->queue, 1, &info, fence));
}

void stage_barrier(struct stage *stage, VkCommandBuffer commands)
{
    const VkMemoryBarrier memory = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
    };
    stage->vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                 VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &memory, 0, NULL, 0,
                                 NULL);
}

void stage_build_boxes(struct stage *stage, VkCommandBuffer commands,
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
    stage->vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

void stage_expect_silence(const struct stage *stage)
{
    if (stage->messages.count)
        fail_msg("%s: %s", stage->messages.items[0].id, stage->messages.items[0].text);
}
