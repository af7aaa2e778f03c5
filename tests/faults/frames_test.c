/* SPDX-License-Identifier: Apache-2.0 */
/* The memory that the layer takes for an application's frames, without a loader and below settings
 * of the environment. */
#include <malloc.h>
#include <string.h>

#include "tests/fixture/linked.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/player/play.h"
#include "tests/unit/unit_test.h"

static struct platform platform;
static struct program program;
static struct play play;

/* Opens the device of a program that has these lines. */
static void open_device(bool is_cpu, const char *const *lines)
{
    program.line_count = 0;
    program.used = 0;
    for (; *lines; lines++)
        program_add(&program, *lines, 1);
    linked_open(&platform, is_cpu);
    memset(&play, 0, sizeof(play));
    play.platform = &platform;
    assert_true(play_begin(&play, &program));
}

static void close_device(void)
{
    for (uint32_t i = 0; i < messages_kept(&play.fixture.messages); i++)
        print_error("%s\n", play.fixture.messages.items[i].text);
    assert_int_equal(play.fixture.messages.count, 0);
    play_end(&play);
    play_close(&play);
}

/* ---- bindings and push constants without builds */

static void record_bindings(VkCommandBuffer commands)
{
    static const uint32_t constants[4] = {1, 2, 3, 4};
    const STRUCT(VkCommandBufferBeginInfo, begin);
    GET(play.vk.BeginCommandBuffer(commands, &begin));
    play.vk.CmdPushConstants(commands, (VkPipelineLayout)(uintptr_t)1, VK_SHADER_STAGE_COMPUTE_BIT,
                             0, sizeof(constants), constants);
    play.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, (VkPipeline)(uintptr_t)1);
    GET(play.vk.EndCommandBuffer(commands));
}

TEST(bindings_without_builds_allocate_nothing)
{
    open_device(false, (const char *const[]){"setting level content", NULL});
    VkCommandPool pool = command_pool_create(&play.vk, play.device);
    VkCommandBuffer commands =
        commands_begin(&play.vk, play.device, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    record_bindings(commands);
    ALLOCATES_NOTHING(record_bindings(commands));
    GET(play.vk.ResetCommandBuffer(commands, VK_COMMAND_BUFFER_RESET_RELEASE_RESOURCES_BIT));
    WITHOUT_MEMORY(record_bindings(commands));
    play.vk.DestroyCommandPool(play.device, pool, NULL);
    close_device();
}

/* ---- objects of all kinds that live for one frame */

enum {
    MEMORY_SIZE = 1 << 18,
    STORAGE = MEMORY_SIZE / 2, /* the first half is read by builds, and is scratch memory */
    STRUCTURE_SIZE = 1 << 14,
    TRIANGLE = 4096, /* of the micromap */
    SCRATCH = STORAGE / 2,
    SCRATCH_SIZE = STORAGE / 8, /* of each build */
    BOTTOM = 0,
    TOP = 1,
    STRUCTURES_KHR = 2,
};

/* What a frame creates and destroys. */
struct frame {
    VkDeviceMemory memory;
    VkBuffer buffer;
    VkDeviceAddress address;
    VkAccelerationStructureKHR structures[STRUCTURES_KHR];
    VkAccelerationStructureNV nv;
    VkMicromapEXT micromap;
    VkCommandPool pool;
    VkCommandBuffer commands, secondary;
    VkSemaphore binary, timeline;
    VkFence fence;
    VkEvent event;
    VkQueryPool queries;
    VkDeferredOperationKHR operation;
    VkImage image;
    VkRenderPass render_pass;
};

static void name(VkObjectType type, uint64_t handle, const char *text)
{
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, info, .objectType = type, .objectHandle = handle,
                 .pObjectName = text);
    GET(play.vk.SetDebugUtilsObjectNameEXT(play.device, &info));
}
#define NAME(type, handle) name(VK_OBJECT_TYPE_##type, (uint64_t)(uintptr_t)(handle), #handle)

static void create_buffer(struct frame *frame)
{
    const STRUCT(VkMemoryAllocateFlagsInfo, flags, .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    const STRUCT(VkMemoryAllocateInfo, allocation, .pNext = &flags, .allocationSize = MEMORY_SIZE,
                 .memoryTypeIndex = 1);
    const STRUCT(VkBufferCreateInfo, info, .size = MEMORY_SIZE,
                 .usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                          VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT |
                          VK_BUFFER_USAGE_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT |
                          VK_BUFFER_USAGE_RAY_TRACING_BIT_NV | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                          VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    void *bytes;
    GET(play.vk.AllocateMemory(play.device, &allocation, NULL, &frame->memory));
    GET(play.vk.CreateBuffer(play.device, &info, NULL, &frame->buffer));
    GET(play.vk.BindBufferMemory(play.device, frame->buffer, frame->memory, 0));
    GET(play.vk.MapMemory(play.device, frame->memory, 0, VK_WHOLE_SIZE, 0, &bytes));
    memset(bytes, 0, MEMORY_SIZE);
    const VkMicromapTriangleEXT triangle = {.format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    memcpy((char *)bytes + TRIANGLE, &triangle, sizeof(triangle));
    frame->address = buffer_address(&play.vk, play.device, frame->buffer);
    NAME(BUFFER, frame->buffer);
    NAME(DEVICE_MEMORY, frame->memory);
}

static void create_nv(struct frame *frame)
{
    const STRUCT(VkGeometryNV, geometry, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_NV,
                 .geometry = {.triangles = MAKE(VkGeometryTrianglesNV, .vertexCount = 3,
                                                .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                                                .vertexStride = 12, .vertexData = frame->buffer,
                                                .indexType = VK_INDEX_TYPE_NONE_NV),
                              .aabbs = MAKE(VkGeometryAABBNV, .pNext = NULL)});
    const STRUCT(VkAccelerationStructureCreateInfoNV, info,
                 .info = MAKE(VkAccelerationStructureInfoNV,
                              .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
                              .geometryCount = 1, .pGeometries = &geometry));
    uint64_t reference;
    GET(play.vk.CreateAccelerationStructureNV(play.device, &info, NULL, &frame->nv));
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, bind, .accelerationStructure = frame->nv,
                 .memory = frame->memory, .memoryOffset = STORAGE + 3 * STRUCTURE_SIZE);
    GET(play.vk.BindAccelerationStructureMemoryNV(play.device, 1, &bind));
    GET(play.vk.GetAccelerationStructureHandleNV(play.device, frame->nv, sizeof(reference),
                                                 &reference));
    play.vk.CmdBuildAccelerationStructureNV(frame->commands, &info.info, VK_NULL_HANDLE, 0,
                                            VK_FALSE, frame->nv, VK_NULL_HANDLE, frame->buffer,
                                            SCRATCH + 3 * SCRATCH_SIZE);
}

static void create_micromap(struct frame *frame)
{
    const STRUCT(VkMicromapCreateInfoEXT, info, .buffer = frame->buffer,
                 .offset = STORAGE + 2 * STRUCTURE_SIZE, .size = STRUCTURE_SIZE,
                 .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
    GET(play.vk.CreateMicromapEXT(play.device, &info, NULL, &frame->micromap));
    const VkMicromapUsageEXT usage = {1, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    const STRUCT(VkMicromapBuildInfoEXT, build, .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
                 .dstMicromap = frame->micromap, .usageCountsCount = 1, .pUsageCounts = &usage,
                 .data = {.deviceAddress = frame->address},
                 .scratchData = {.deviceAddress = frame->address + SCRATCH + 2 * SCRATCH_SIZE},
                 .triangleArray = {.deviceAddress = frame->address + TRIANGLE},
                 .triangleArrayStride = sizeof(VkMicromapTriangleEXT));
    play.vk.CmdBuildMicromapsEXT(frame->commands, 1, &build);
    NAME(MICROMAP_EXT, frame->micromap);
}

static void create_structures(struct frame *frame)
{
    for (uint32_t i = 0; i < STRUCTURES_KHR; i++) {
        const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = frame->buffer,
                     .offset = STORAGE + i * STRUCTURE_SIZE, .size = STRUCTURE_SIZE,
                     .type = i == TOP ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                      : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
        GET(play.vk.CreateAccelerationStructureKHR(play.device, &info, NULL,
                                                   &frame->structures[i]));
        structure_address(&play.vk, play.device, frame->structures[i]);
        NAME(ACCELERATION_STRUCTURE_KHR, frame->structures[i]);
    }
}

static void build(struct frame *frame, uint32_t i)
{
    const bool is_top = i == TOP;
    STRUCT(VkAccelerationStructureGeometryKHR, geometry);
    geometry.geometryType = is_top ? VK_GEOMETRY_TYPE_INSTANCES_KHR : VK_GEOMETRY_TYPE_AABBS_KHR;
    if (is_top)
        geometry.geometry.instances = MAKE(VkAccelerationStructureGeometryInstancesDataKHR,
                                           .data = {.deviceAddress = frame->address});
    else
        geometry.geometry.aabbs =
            MAKE(VkAccelerationStructureGeometryAabbsDataKHR,
                 .data = {.deviceAddress = frame->address}, .stride = sizeof(VkAabbPositionsKHR));
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 1}, *ranges = &range;
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info,
                 .type = is_top ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
                          VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
                 .dstAccelerationStructure = frame->structures[i], .geometryCount = 1,
                 .pGeometries = &geometry,
                 .scratchData = {.deviceAddress = frame->address + SCRATCH + i * SCRATCH_SIZE});
    play.vk.CmdBuildAccelerationStructuresKHR(frame->commands, 1, &info, &ranges);
    commands_barrier(&play.vk, frame->commands);
}

static void create_sync(struct frame *frame)
{
    const STRUCT(VkSemaphoreCreateInfo, binary);
    const STRUCT(VkEventCreateInfo, event);
    GET(play.vk.CreateSemaphore(play.device, &binary, NULL, &frame->binary));
    GET(play.vk.CreateEvent(play.device, &event, NULL, &frame->event));
    GET(play.vk.CreateDeferredOperationKHR(play.device, NULL, &frame->operation));
    frame->timeline = timeline_create(&play.vk, play.device);
    frame->fence = fence_create(&play.vk, play.device);
    frame->queries = query_pool_create(&play.vk, play.device,
                                       VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, 4);
}

/* Setting hazards tracks both. */
static void create_for_hazards(struct frame *frame)
{
    static const VkSubpassDependency dependency = {.srcSubpass = VK_SUBPASS_EXTERNAL};
    static const VkSubpassDescription subpass;
    const STRUCT(VkImageCreateInfo, image, .imageType = VK_IMAGE_TYPE_2D,
                 .format = VK_FORMAT_R8G8B8A8_UNORM, .extent = {16, 16, 1}, .mipLevels = 1,
                 .arrayLayers = 1, .samples = VK_SAMPLE_COUNT_1_BIT,
                 .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    const STRUCT(VkRenderPassCreateInfo, pass, .subpassCount = 1, .pSubpasses = &subpass,
                 .dependencyCount = 1, .pDependencies = &dependency);
    GET(play.vk.CreateImage(play.device, &image, NULL, &frame->image));
    GET(play.vk.CreateRenderPass(play.device, &pass, NULL, &frame->render_pass));
}

/* A secondary command buffer, which pushes constants and sets the event. */
static void execute_secondary(struct frame *frame)
{
    static const uint32_t constant;
    const STRUCT(VkCommandBufferInheritanceInfo, inheritance);
    frame->secondary = commands_begin(&play.vk, play.device, frame->pool,
                                      VK_COMMAND_BUFFER_LEVEL_SECONDARY, 0, &inheritance);
    play.vk.CmdPushConstants(frame->secondary, (VkPipelineLayout)(uintptr_t)1,
                             VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(constant), &constant);
    play.vk.CmdSetEvent(frame->secondary, frame->event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    GET(play.vk.EndCommandBuffer(frame->secondary));
    play.vk.CmdExecuteCommands(frame->commands, 1, &frame->secondary);
}

static void record(struct frame *frame)
{
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = "frame");
    frame->pool = command_pool_create(&play.vk, play.device);
    frame->commands = commands_begin(&play.vk, play.device, frame->pool,
                                     VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    NAME(COMMAND_POOL, frame->pool);
    NAME(COMMAND_BUFFER, frame->commands);
    NAME(DEFERRED_OPERATION_KHR, frame->operation);
    play.vk.CmdBeginDebugUtilsLabelEXT(frame->commands, &label);
    play.vk.CmdResetQueryPool(frame->commands, frame->queries, 0, 4);
    build(frame, BOTTOM);
    build(frame, TOP);
    play.vk.CmdWriteAccelerationStructuresPropertiesKHR(
        frame->commands, 1, frame->structures,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, frame->queries, 0);
    create_micromap(frame);
    create_nv(frame);
    execute_secondary(frame);
    play.vk.CmdEndDebugUtilsLabelEXT(frame->commands);
    GET(play.vk.EndCommandBuffer(frame->commands));
}

/* Each frame waits for the one before on a semaphore of its own. */
static void submit(const struct frame *frame, const struct frame *before)
{
    static const VkPipelineStageFlags stages = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const uint64_t values[] = {0, 1};
    const VkSemaphore signals[] = {frame->binary, frame->timeline};
    const STRUCT(VkTimelineSemaphoreSubmitInfo, timeline, .signalSemaphoreValueCount = 2,
                 .pSignalSemaphoreValues = values);
    const STRUCT(VkSubmitInfo, info, .pNext = &timeline, .waitSemaphoreCount = before ? 1 : 0,
                 .pWaitSemaphores = before ? &before->binary : NULL, .pWaitDstStageMask = &stages,
                 .commandBufferCount = 1, .pCommandBuffers = &frame->commands,
                 .signalSemaphoreCount = 2, .pSignalSemaphores = signals);
    const uint64_t reached = 1, next = 2;
    const STRUCT(VkSemaphoreWaitInfo, wait, .semaphoreCount = 1, .pSemaphores = &frame->timeline,
                 .pValues = &reached);
    const STRUCT(VkSemaphoreSignalInfo, signal, .semaphore = frame->timeline, .value = next);
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = "queue");
    uint64_t sizes[4];
    play.vk.QueueBeginDebugUtilsLabelEXT(play.queues[0], &label);
    GET(play.vk.QueueSubmit(play.queues[0], 1, &info, frame->fence));
    play.vk.QueueEndDebugUtilsLabelEXT(play.queues[0]);
    GET(play.vk.WaitForFences(play.device, 1, &frame->fence, VK_TRUE, UINT64_MAX));
    GET(play.vk.WaitSemaphores(play.device, &wait, UINT64_MAX));
    GET(play.vk.SignalSemaphore(play.device, &signal));
    play.vk.GetQueryPoolResults(play.device, frame->queries, 0, 1, sizeof(sizes), sizes,
                                sizeof(sizes[0]), VK_QUERY_RESULT_64_BIT);
}

static void destroy(const struct frame *frame)
{
    for (uint32_t i = 0; i < STRUCTURES_KHR; i++)
        play.vk.DestroyAccelerationStructureKHR(play.device, frame->structures[i], NULL);
    play.vk.DestroyAccelerationStructureNV(play.device, frame->nv, NULL);
    play.vk.DestroyMicromapEXT(play.device, frame->micromap, NULL);
    play.vk.DestroyCommandPool(play.device, frame->pool, NULL);
    play.vk.DestroySemaphore(play.device, frame->binary, NULL);
    play.vk.DestroySemaphore(play.device, frame->timeline, NULL);
    play.vk.DestroyFence(play.device, frame->fence, NULL);
    play.vk.DestroyEvent(play.device, frame->event, NULL);
    play.vk.DestroyQueryPool(play.device, frame->queries, NULL);
    play.vk.DestroyDeferredOperationKHR(play.device, frame->operation, NULL);
    play.vk.DestroyImage(play.device, frame->image, NULL);
    play.vk.DestroyRenderPass(play.device, frame->render_pass, NULL);
    play.vk.DestroyBuffer(play.device, frame->buffer, NULL);
    play.vk.FreeMemory(play.device, frame->memory, NULL);
}

static void play_frames(uint32_t count)
{
    struct frame before = {0};
    for (uint32_t i = 0; i < count; i++) {
        struct frame frame = {0};
        create_buffer(&frame);
        create_structures(&frame);
        create_sync(&frame);
        create_for_hazards(&frame);
        record(&frame);
        submit(&frame, before.fence ? &before : NULL);
        if (before.fence)
            destroy(&before);
        before = frame;
    }
    GET(play.vk.DeviceWaitIdle(play.device));
    destroy(&before);
}

/* ---- what stays behind them */

/* More destructions than the layer remembers, and then so many frames that one block for each is
 * more than the noise of tables whose size depends on addresses. */
enum { FIRST_FRAMES = 1100, FRAMES = 500, BLOCKS_MAX = 50, BYTES_MAX = 20000 };

static size_t bytes_now(void)
{
#ifdef __GLIBC__
    return mallinfo2().uordblks;
#else
    return 0;
#endif
}

static void expect_flat(bool is_cpu, const char *const *lines)
{
    open_device(is_cpu, lines);
    play_frames(FIRST_FRAMES);
    const int blocks = allocations_now();
    const size_t bytes = bytes_now();
    play_frames(FRAMES);
    print_message("%s%s: %d blocks more, %ld bytes more\n", play.instance_key, is_cpu ? " cpu" : "",
                  allocations_now() - blocks, (long)(bytes_now() - bytes));
    assert_true(allocations_now() - blocks < BLOCKS_MAX);
    assert_true((long)(bytes_now() - bytes) < BYTES_MAX);
    close_device();
}

/* Without settings, and with them. */
#define EXPECT_FLAT(is_cpu, level, driver, ...)                                                    \
    do {                                                                                           \
        expect_flat(is_cpu, (const char *const[]){NV, level, driver, NULL});                       \
        expect_flat(is_cpu, (const char *const[]){NV, level, driver, "setting hazards true",       \
                                                  "setting call_sites full", __VA_ARGS__});        \
    } while (0)
#define NV "with VK_NV_ray_tracing"
#define GUARD "setting guard references"

TEST(frames_leave_nothing_behind)
{
    EXPECT_FLAT(false, "setting level execution", "driver recycles handles", NULL);
    EXPECT_FLAT(false, "setting level content", "driver recycles handles", GUARD, NULL);
    EXPECT_FLAT(false, "setting level content", "driver recycles", GUARD, NULL);
    EXPECT_FLAT(true, "setting level content", "driver recycles handles", NULL);
}
