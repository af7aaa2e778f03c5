/* SPDX-License-Identifier: Apache-2.0 */
/* What the application records and submits: valid builds, then mistakes. */
#include "application_parts.h"
#include "tests/fixture/copies.h"

#define ID(tail) "VUID-vkCmdBuildAccelerationStructuresKHR-" tail

/* A call under construction. */
struct call {
    VkAccelerationStructureBuildGeometryInfoKHR infos[BUILDS];
    VkAccelerationStructureGeometryKHR geometries[GEOMETRIES];
    VkAccelerationStructureBuildRangeInfoKHR ranges[GEOMETRIES];
    const VkAccelerationStructureBuildRangeInfoKHR *range_arrays[BUILDS];
    uint32_t count;
};

static void start_call(const struct application *app, struct call *call)
{
    *call = (struct call){.count = 0};
    for (unsigned i = 0; i < GEOMETRIES; i++) {
        call->geometries[i] = describe_triangles(
            (VkDeviceOrHostAddressConstKHR){.deviceAddress = app->input_address}, NULL);
        call->ranges[i].primitiveCount = 1;
    }
}

/* Adds a build, with scratch of its own. */
static VkAccelerationStructureBuildGeometryInfoKHR *add_build(const struct application *app,
                                                              struct call *call,
                                                              VkAccelerationStructureKHR dst,
                                                              VkAccelerationStructureKHR src)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &call->infos[call->count];
    *info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
                 .mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                             : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                 .srcAccelerationStructure = src, .dstAccelerationStructure = dst,
                 .geometryCount = 1, .pGeometries = call->geometries,
                 .scratchData.deviceAddress = app->scratch_address + call->count * SCRATCH_SIZE);
    call->range_arrays[call->count++] = call->ranges;
    return info;
}

static void send(const struct application *app, VkCommandBuffer command_buffer,
                 const struct call *call)
{
    app->vk.CmdBuildAccelerationStructuresKHR(command_buffer, call->count, call->infos,
                                              call->range_arrays);
}

static void begin(struct application *app, VkCommandBuffer command_buffer)
{
    GET(app, "vkBeginCommandBuffer", begin_commands(app, command_buffer));
}

static void end(struct application *app, VkCommandBuffer command_buffer)
{
    CALL(app, EndCommandBuffer, command_buffer);
}

static void submit(struct application *app, VkCommandBuffer command_buffer, bool waits,
                   bool signals)
{
    static const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkSubmitInfo info = MAKE(
        VkSubmitInfo, .waitSemaphoreCount = waits, .pWaitSemaphores = &app->semaphore,
        .pWaitDstStageMask = &stage, .commandBufferCount = 1, .pCommandBuffers = &command_buffer,
        .signalSemaphoreCount = signals, .pSignalSemaphores = &app->semaphore);
    CALL(app, QueueSubmit, app->queue, 1, &info, VK_NULL_HANDLE);
}

static void open_labels(const struct application *app, VkCommandBuffer command_buffer, int count)
{
    static const char *const names[] = {"frame", "scene", "", "trees", "a rather long label", "x"};
    for (int i = 0; i < count; i++) {
        const VkDebugUtilsLabelEXT label = MAKE(VkDebugUtilsLabelEXT, .pLabelName = names[i % 6]);
        app->vk.CmdBeginDebugUtilsLabelEXT(command_buffer, &label);
        app->vk.CmdInsertDebugUtilsLabelEXT(command_buffer, &label);
    }
}

static void close_labels(const struct application *app, VkCommandBuffer command_buffer, int count)
{
    while (count-- > 0)
        app->vk.CmdEndDebugUtilsLabelEXT(command_buffer);
}

/* ---- valid */

/* Builds of many geometries, which need an array for their counts: one across sparse pages, and two
 * of structures whose unused ends overlap. */
static void record_large_builds(struct application *app, VkCommandBuffer command_buffer)
{
    struct call call;
    start_call(app, &call);
    add_build(app, &call, app->in_pages, VK_NULL_HANDLE);
    add_build(app, &call, app->with_tails[0], VK_NULL_HANDLE);
    add_build(app, &call, app->with_tails[1], VK_NULL_HANDLE);
    for (unsigned i = 0; i < call.count; i++)
        call.infos[i].geometryCount = GEOMETRIES;
    send(app, command_buffer, &call);
}

/* Builds in descending order of handles, large ones, and updates, some in place and some from one
 * source. */
static void record_builds(struct application *app, VkCommandBuffer command_buffer)
{
    struct call call;
    begin(app, command_buffer);
    open_labels(app, command_buffer, 9);
    start_call(app, &call);
    for (unsigned i = 0; i < BUILDS; i++)
        add_build(app, &call, app->sets[BUILDS - 1 - i].accel, VK_NULL_HANDLE);
    send(app, command_buffer, &call);
    record_large_builds(app, command_buffer);
    start_call(app, &call);
    for (unsigned i = 0; i < BUILDS; i++)
        add_build(app, &call, app->sets[i % 3 ? i + BUILDS : i].accel,
                  app->sets[i % 3 ? 0 : i].accel);
    call.infos[0].srcAccelerationStructure = call.infos[0].dstAccelerationStructure =
        app->sets[BUILDS - 1].accel;
    send(app, command_buffer, &call);
    record_nv(app, command_buffer);
    record_micromaps(app, command_buffer);
    close_labels(app, command_buffer, 9);
    end(app, command_buffer);
}

static void record_copies(struct application *app, VkCommandBuffer command_buffer)
{
    struct call call;
    begin(app, command_buffer);
    for (unsigned i = 0; i < 4; i++) {
        const VkCopyAccelerationStructureInfoKHR copy =
            copy_info(app->sets[i].accel, app->sets[2 * BUILDS + i].accel,
                      VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
        app->vk.CmdCopyAccelerationStructureKHR(command_buffer, &copy);
    }
    start_call(app, &call);
    add_build(app, &call, app->sets[2 * BUILDS].accel, app->sets[2 * BUILDS].accel);
    send(app, command_buffer, &call);
    end(app, command_buffer);
}

/* Compacted sizes of what was built, read as soon as they are there. */
static void query_sizes(struct application *app, VkCommandBuffer command_buffer)
{
    uint64_t sizes[QUERIES];
    VkAccelerationStructureKHR accels[QUERIES];
    for (unsigned i = 0; i < QUERIES; i++)
        accels[i] = app->sets[i].accel;
    app->vk.ResetQueryPool(app->device, app->queries, 0, QUERIES);
    begin(app, command_buffer);
    app->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        command_buffer, QUERIES, accels, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        app->queries, 0);
    end(app, command_buffer);
    submit(app, command_buffer, false, false);
    CALL(app, GetQueryPoolResults, app->device, app->queries, 0, QUERIES, sizeof(sizes), sizes,
         sizeof(sizes[0]), VK_QUERY_RESULT_64_BIT);
}

/* A primary that executes two secondary command buffers, one of which updates what the other
 * builds. */
static void record_secondaries(struct application *app, const struct set *builds,
                               const struct set *updates)
{
    VkAccelerationStructureKHR accel = app->sets[2 * BUILDS + 4].accel;
    const VkCommandBuffer secondaries[] = {builds->secondary, updates->secondary};
    for (unsigned i = 0; i < 2; i++) {
        struct call call;
        begin(app, secondaries[i]);
        start_call(app, &call);
        add_build(app, &call, accel, i ? accel : VK_NULL_HANDLE);
        send(app, secondaries[i], &call);
        end(app, secondaries[i]);
    }
    begin(app, builds->primary);
    app->vk.CmdExecuteCommands(builds->primary, 2, secondaries);
    end(app, builds->primary);
}

/* ---- mistakes, one at a time */

static void make_mistake(struct application *app, const struct set *set, const struct call *call,
                         const char *id)
{
    expect(app, id);
    begin(app, set->primary);
    open_labels(app, set->primary, 2);
    send(app, set->primary, call);
    end(app, set->primary);
    submit(app, set->primary, false, false);
    expect_nothing_more(app);
}

static void make_mistakes(struct application *app)
{
    const struct set *sets = app->sets;
    VkAccelerationStructureBuildGeometryInfoKHR *info;
    struct call call;

    start_call(app, &call);
    info = add_build(app, &call, sets[1].accel, VK_NULL_HANDLE);
    info->scratchData.deviceAddress += 16;
    make_mistake(app, &sets[5], &call, ID("pInfos-03710"));

    start_call(app, &call);
    add_build(app, &call, sets[1].accel, VK_NULL_HANDLE);
    info = add_build(app, &call, sets[2].accel, VK_NULL_HANDLE);
    info->scratchData.deviceAddress = call.infos[0].scratchData.deviceAddress;
    make_mistake(app, &sets[6], &call, ID("scratchData-03704"));

    start_call(app, &call);
    add_build(app, &call, sets[1].accel, VK_NULL_HANDLE);
    add_build(app, &call, sets[1].accel, VK_NULL_HANDLE);
    make_mistake(app, &sets[7], &call, ID("dstAccelerationStructure-03698"));

    start_call(app, &call);
    info = add_build(app, &call, sets[1].accel, VK_NULL_HANDLE);
    info->scratchData.deviceAddress = app->scratch_address + SETS * SCRATCH_SIZE - 256;
    make_mistake(app, &sets[8], &call, ID("pInfos-03671"));

    expect(app, "VUID-vkCmdBuildAccelerationStructureNV-dst-02488");
    begin(app, sets[9].primary);
    mistake_nv(app, sets[9].primary);
    end(app, sets[9].primary);
    expect_nothing_more(app);
}

void record_all(struct application *app)
{
    const struct set *sets = app->sets;
    record_builds(app, sets[0].primary);
    submit(app, sets[0].primary, false, true);
    query_sizes(app, sets[4].primary);
    record_copies(app, sets[1].primary);
    submit(app, sets[1].primary, true, false);
    record_secondaries(app, &sets[2], &sets[3]);
    submit(app, sets[2].primary, false, false);
    app->vk.DeviceWaitIdle(app->device);

    submit(app, sets[0].primary, false, true); /* again */
    submit(app, sets[1].primary, true, false);
    app->vk.DeviceWaitIdle(app->device);
    CALL(app, ResetCommandPool, app->device, sets[0].pool, 0);
    record_builds(app, sets[0].primary);
    submit(app, sets[0].primary, false, false);
    work_on_host(app);
    make_mistakes(app);
}
