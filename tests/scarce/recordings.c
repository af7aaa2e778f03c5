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

static void start_call(struct call *call)
{
    *call = (struct call){.count = 0};
    for (unsigned i = 0; i < GEOMETRIES; i++) {
        call->geometries[i] = describe_triangles(
            (VkDeviceOrHostAddressConstKHR){.deviceAddress = app.input_address}, NULL);
        call->ranges[i].primitiveCount = 1;
    }
}

/* Adds a build, with scratch of its own. */
static VkAccelerationStructureBuildGeometryInfoKHR *
add_build(struct call *call, VkAccelerationStructureKHR dst, VkAccelerationStructureKHR src)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &call->infos[call->count];
    *info = describe_build(dst, src, 1, call->geometries);
    info->scratchData.deviceAddress = app.scratch_address + call->count * SCRATCH_SIZE;
    call->range_arrays[call->count++] = call->ranges;
    return info;
}

static void send(VkCommandBuffer command_buffer, const struct call *call)
{
    vk.CmdBuildAccelerationStructuresKHR(command_buffer, call->count, call->infos,
                                         call->range_arrays);
}

static void begin(VkCommandBuffer command_buffer)
{
    GET("vkBeginCommandBuffer", begin_commands(command_buffer));
}

static void end(VkCommandBuffer command_buffer)
{
    CALL(EndCommandBuffer, command_buffer);
}

static void submit(VkCommandBuffer command_buffer, bool waits, bool signals)
{
    static const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const STRUCT(VkSubmitInfo, info, .waitSemaphoreCount = waits, .pWaitSemaphores = &app.semaphore,
                 .pWaitDstStageMask = &stage, .commandBufferCount = 1,
                 .pCommandBuffers = &command_buffer, .signalSemaphoreCount = signals,
                 .pSignalSemaphores = &app.semaphore);
    CALL(QueueSubmit, queue, 1, &info, VK_NULL_HANDLE);
}

static void open_labels(VkCommandBuffer command_buffer, int count)
{
    static const char *const names[] = {"frame", "scene", "", "trees", "a rather long label", "x"};
    for (int i = 0; i < count; i++) {
        const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = names[i % 6]);
        vk.CmdBeginDebugUtilsLabelEXT(command_buffer, &label);
        vk.CmdInsertDebugUtilsLabelEXT(command_buffer, &label);
    }
}

/* ---- valid */

/* Builds of many geometries, which need an array for their counts: one across sparse pages, and two
 * of structures whose unused ends overlap. */
static void record_large_builds(VkCommandBuffer command_buffer)
{
    struct call call;
    start_call(&call);
    add_build(&call, app.in_pages, VK_NULL_HANDLE);
    add_build(&call, app.with_tails[0], VK_NULL_HANDLE);
    add_build(&call, app.with_tails[1], VK_NULL_HANDLE);
    for (unsigned i = 0; i < call.count; i++)
        call.infos[i].geometryCount = GEOMETRIES;
    send(command_buffer, &call);
}

/* Builds in descending order of handles, large ones, and updates, some in place and some from one
 * source. */
static void record_builds(VkCommandBuffer command_buffer)
{
    struct call call;
    begin(command_buffer);
    open_labels(command_buffer, 9);
    start_call(&call);
    for (unsigned i = 0; i < BUILDS; i++)
        add_build(&call, app.sets[BUILDS - 1 - i].accel, VK_NULL_HANDLE);
    send(command_buffer, &call);
    record_large_builds(command_buffer);
    start_call(&call);
    for (unsigned i = 0; i < BUILDS; i++)
        add_build(&call, app.sets[i % 3 ? i + BUILDS : i].accel, app.sets[i % 3 ? 0 : i].accel);
    call.infos[0].srcAccelerationStructure = call.infos[0].dstAccelerationStructure =
        app.sets[BUILDS - 1].accel;
    send(command_buffer, &call);
    record_nv(command_buffer);
    record_micromaps(command_buffer);
    for (int i = 0; i < 9; i++)
        vk.CmdEndDebugUtilsLabelEXT(command_buffer);
    end(command_buffer);
}

static void record_copies(VkCommandBuffer command_buffer)
{
    struct call call;
    begin(command_buffer);
    for (unsigned i = 0; i < 4; i++) {
        const VkCopyAccelerationStructureInfoKHR copy =
            copy_info(app.sets[i].accel, app.sets[2 * BUILDS + i].accel,
                      VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
        vk.CmdCopyAccelerationStructureKHR(command_buffer, &copy);
    }
    start_call(&call);
    add_build(&call, app.sets[2 * BUILDS].accel, app.sets[2 * BUILDS].accel);
    send(command_buffer, &call);
    end(command_buffer);
}

/* Compacted sizes of what was built, read as soon as they are there. */
static void query_sizes(VkCommandBuffer command_buffer)
{
    uint64_t sizes[QUERIES];
    VkAccelerationStructureKHR accels[QUERIES];
    for (unsigned i = 0; i < QUERIES; i++)
        accels[i] = app.sets[i].accel;
    vk.ResetQueryPool(device, app.queries, 0, QUERIES);
    begin(command_buffer);
    vk.CmdWriteAccelerationStructuresPropertiesKHR(
        command_buffer, QUERIES, accels, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        app.queries, 0);
    end(command_buffer);
    submit(command_buffer, false, false);
    CALL(GetQueryPoolResults, device, app.queries, 0, QUERIES, sizeof(sizes), sizes,
         sizeof(sizes[0]), VK_QUERY_RESULT_64_BIT);
}

/* A primary that executes two secondary command buffers, one of which updates what the other
 * builds. */
static void record_secondaries(const struct set *builds, const struct set *updates)
{
    VkAccelerationStructureKHR accel = app.sets[2 * BUILDS + 4].accel;
    const VkCommandBuffer secondaries[] = {builds->secondary, updates->secondary};
    for (unsigned i = 0; i < 2; i++) {
        struct call call;
        begin(secondaries[i]);
        start_call(&call);
        add_build(&call, accel, i ? accel : VK_NULL_HANDLE);
        send(secondaries[i], &call);
        end(secondaries[i]);
    }
    begin(builds->primary);
    vk.CmdExecuteCommands(builds->primary, 2, secondaries);
    end(builds->primary);
}

/* ---- mistakes, one at a time */

static void make_mistake(const struct set *set, const struct call *call, const char *id)
{
    expect(id);
    begin(set->primary);
    open_labels(set->primary, 2);
    send(set->primary, call);
    end(set->primary);
    submit(set->primary, false, false);
    expect_nothing_more();
}

static void make_mistakes(void)
{
    const struct set *sets = app.sets;
    VkAccelerationStructureBuildGeometryInfoKHR *info;
    struct call call;

    start_call(&call);
    info = add_build(&call, sets[1].accel, VK_NULL_HANDLE);
    info->scratchData.deviceAddress += 16;
    make_mistake(&sets[5], &call, ID("pInfos-03710"));

    start_call(&call);
    add_build(&call, sets[1].accel, VK_NULL_HANDLE);
    info = add_build(&call, sets[2].accel, VK_NULL_HANDLE);
    info->scratchData.deviceAddress = call.infos[0].scratchData.deviceAddress;
    make_mistake(&sets[6], &call, ID("scratchData-03704"));

    start_call(&call);
    add_build(&call, sets[1].accel, VK_NULL_HANDLE);
    add_build(&call, sets[1].accel, VK_NULL_HANDLE);
    make_mistake(&sets[7], &call, ID("dstAccelerationStructure-03698"));

    start_call(&call);
    info = add_build(&call, sets[1].accel, VK_NULL_HANDLE);
    info->scratchData.deviceAddress = app.scratch_address + SETS * SCRATCH_SIZE - 256;
    make_mistake(&sets[8], &call, ID("pInfos-03671"));

    expect("VUID-vkCmdBuildAccelerationStructureNV-dst-02488");
    begin(sets[9].primary);
    mistake_nv(sets[9].primary);
    end(sets[9].primary);
    expect_nothing_more();
}

void record_all(void)
{
    const struct set *sets = app.sets;
    record_builds(sets[0].primary);
    submit(sets[0].primary, false, true);
    query_sizes(sets[4].primary);
    record_copies(sets[1].primary);
    submit(sets[1].primary, true, false);
    record_secondaries(&sets[2], &sets[3]);
    submit(sets[2].primary, false, false);
    vk.DeviceWaitIdle(device);

    submit(sets[0].primary, false, true); /* again */
    submit(sets[1].primary, true, false);
    vk.DeviceWaitIdle(device);
    CALL(ResetCommandPool, device, sets[0].pool, 0);
    record_builds(sets[0].primary);
    submit(sets[0].primary, false, false);
    work_on_host();
    make_mistakes();
    vk.DeviceWaitIdle(device);
    for (unsigned i = 1; i < SETS; i += 2) { /* those of the others go with their pools */
        vk.FreeCommandBuffers(device, sets[i].pool, 1, &sets[i].primary);
        vk.FreeCommandBuffers(device, sets[i].pool, 1, &sets[i].secondary);
    }
}
