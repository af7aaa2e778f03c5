/* SPDX-License-Identifier: Apache-2.0 */
#include "frames.h"

#include <stdlib.h>
#include <string.h>

#include "scripts/tools/measure.h"
#include "tests/fixture/geometry.h"

enum { REFERRED = 1000 }; /* structures that instances refer to */

struct frames {
    struct frame_kind kind;
    struct gpu *gpu;
    struct gpu_buffer vertices, indices, instances, scratch, storage;
    struct gpu_structure *structures;               /* kind.builds */
    struct frames *referred;                        /* of a top-level structure */
    VkAccelerationStructureGeometryKHR *geometries; /* kind.builds */
    VkAccelerationStructureBuildGeometryInfoKHR *infos;
    VkAccelerationStructureBuildRangeInfoKHR range;
    const VkAccelerationStructureBuildRangeInfoKHR **ranges;
    struct recorder recorder;
    VkQueryPool timestamps; /* two, or null */
    bool is_built;
};

/* ---- inputs */

static uint32_t count_inputs(const struct frames *frames)
{
    return frames->kind.has_own_inputs ? frames->kind.builds : 1;
}

/* Memory that builds of the host read or write, as if it were a buffer. */
static struct gpu_buffer host_memory(VkDeviceSize size)
{
    char *data = tool_alloc(1, size);
    return (struct gpu_buffer){.size = size, .address = (uintptr_t)data, .data = data};
}

/* Makes an input of `count` times the same bytes. Fills a buffer of the device's by a copy, as an
 * application does. */
static struct gpu_buffer upload(struct frames *frames, const char *name, const void *bytes,
                                VkDeviceSize size)
{
    struct gpu *gpu = frames->gpu;
    const uint32_t count = count_inputs(frames);
    struct gpu_buffer from =
        frames->kind.by_host ? host_memory(count * size)
                             : gpu_create_buffer(gpu, "upload", GPU_PLACE_HOST,
                                                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT, count * size);
    for (uint32_t i = 0; i < count; i++)
        memcpy((char *)from.data + i * size, bytes, size);
    if (frames->kind.by_host)
        return from;
    struct gpu_buffer to = gpu_create_buffer(
        gpu, name, GPU_PLACE_DEVICE,
        VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
        count * size);
    VkCommandBuffer commands = gpu_begin(gpu);
    const VkBufferCopy region = {.size = count * size};
    gpu->calls.CmdCopyBuffer(commands, from.handle, to.handle, 1, &region);
    gpu_barrier(gpu, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, VK_ACCESS_SHADER_READ_BIT);
    gpu_submit(gpu, commands);
    gpu_destroy_buffer(gpu, &from);
    return to;
}

/* A strip of triangles: triangle i has the vertices i, i + 1, i + 2. */
static void open_triangles(struct frames *frames)
{
    const uint32_t count = frames->kind.primitives;
    float(*vertices)[3] = tool_alloc(count + 2, sizeof(*vertices));
    uint32_t(*indices)[3] = tool_alloc(count, sizeof(*indices));
    for (uint32_t i = 0; i < count + 2; i++)
        memcpy(vertices[i], (float[3]){(float)(i / 2), (float)(i % 2), (float)(i % 7)}, 12);
    for (uint32_t i = 0; i < count; i++)
        memcpy(indices[i], (uint32_t[3]){i, i + 1, i + 2}, 12);
    const VkDeviceSize vertices_size = (count + 2) * sizeof(*vertices);
    const VkDeviceSize indices_size = count * sizeof(*indices);
    frames->vertices = upload(frames, "vertices", vertices, vertices_size);
    frames->indices = upload(frames, "indices", indices, indices_size);
    free(vertices);
    free(indices);
    for (uint32_t i = 0; i < frames->kind.builds; i++) {
        const uint32_t at = i % count_inputs(frames);
        frames->geometries[i] =
            triangles_geometry(frames->vertices.address + at * vertices_size, count + 1,
                               VK_INDEX_TYPE_UINT32, frames->indices.address + at * indices_size);
    }
}

/* Instances refer to many structures, in no order. */
static void open_instances(struct frames *frames, struct side *side)
{
    const struct frame_kind kind = {
        .builds = REFERRED, .primitives = 12, .by_host = frames->kind.by_host};
    const uint32_t count = frames->kind.primitives;
    VkAccelerationStructureInstanceKHR *instances = tool_alloc(count, sizeof(*instances));
    frames->referred = frames_open(&kind, side);
    frames_run(frames->referred);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t referred = (uint32_t)((i * UINT64_C(2654435761)) >> 7) % REFERRED;
        instances[i] = (VkAccelerationStructureInstanceKHR){
            .transform = {{{1, 0, 0, (float)i}, {0, 2, 0, 0}, {0, 0.5F, 1, 0}}},
            .instanceCustomIndex = i & 0xffffff,
            .mask = 0xff,
            .accelerationStructureReference =
                kind.by_host
                    ? (uint64_t)frames->referred->structures[referred].handle
                    : gpu_structure_address(frames->gpu, &frames->referred->structures[referred])};
    }
    frames->instances = upload(frames, "instances", instances, count * sizeof(*instances));
    free(instances);
    frames->geometries[0] = instances_geometry(frames->instances.address, false);
}

/* ---- structures */

static VkAccelerationStructureTypeKHR type_of(const struct frames *frames)
{
    return frames->kind.is_top_level ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                     : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
}

static void open_structures(struct frames *frames)
{
    struct gpu *gpu = frames->gpu;
    const uint32_t builds = frames->kind.builds;
    VkAccelerationStructureBuildSizesInfoKHR sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    VkAccelerationStructureBuildGeometryInfoKHR info = MAKE(
        VkAccelerationStructureBuildGeometryInfoKHR, .type = type_of(frames),
        .flags = frames->kind.updates ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR
                                      : VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR,
        .geometryCount = 1, .pGeometries = frames->geometries);
    const bool by_host = frames->kind.by_host;
    gpu->calls.GetAccelerationStructureBuildSizesKHR(
        gpu->device,
        by_host ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
        &info, &frames->kind.primitives, &sizes);
    const VkDeviceSize scratch =
        gpu_align(sizes.buildScratchSize > sizes.updateScratchSize ? sizes.buildScratchSize
                                                                   : sizes.updateScratchSize,
                  256);
    const VkDeviceSize size = gpu_align(sizes.accelerationStructureSize, 256);
    frames->scratch = by_host ? host_memory(scratch * builds)
                              : gpu_create_scratch(gpu, "scratch", scratch * builds);
    frames->storage =
        gpu_create_buffer(gpu, "structures", by_host ? GPU_PLACE_HOST : GPU_PLACE_DEVICE,
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                              VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
                          size * builds);
    frames->structures = tool_alloc(builds, sizeof(*frames->structures));
    frames->infos = tool_alloc(builds, sizeof(*frames->infos));
    frames->ranges = tool_alloc(builds, sizeof(*frames->ranges));
    for (uint32_t i = 0; i < builds; i++) {
        frames->structures[i] = gpu_create_structure_in(gpu, "structure", type_of(frames),
                                                        frames->storage.handle, i * size, size);
        frames->infos[i] = info;
        frames->infos[i].pGeometries = &frames->geometries[i];
        frames->infos[i].dstAccelerationStructure = frames->structures[i].handle;
        frames->infos[i].scratchData.deviceAddress =
            (by_host ? frames->scratch.address : gpu_scratch_address(gpu, &frames->scratch)) +
            i * scratch;
        frames->ranges[i] = &frames->range;
    }
    frames->range.primitiveCount = frames->kind.primitives;
}

struct frames *frames_open(const struct frame_kind *kind, struct side *side)
{
    struct frames *frames = tool_alloc(1, sizeof(*frames));
    frames->gpu = &side->gpu;
    frames->kind = *kind;
    frames->geometries = tool_alloc(kind->builds, sizeof(*frames->geometries));
    if (kind->is_top_level)
        open_instances(frames, side);
    else
        open_triangles(frames);
    open_structures(frames);
    recorder_open(&frames->recorder, side);
    if (kind->has_timestamps)
        TOOL_CALL(
            side->gpu.calls, CreateQueryPool, side->gpu.device,
            &MAKE(VkQueryPoolCreateInfo, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = 2),
            NULL, &frames->timestamps);
    return frames;
}

static void close_memory(const struct frames *frames, struct gpu_buffer *buffer)
{
    if (frames->kind.by_host)
        free(buffer->data);
    else
        gpu_destroy_buffer(frames->gpu, buffer);
}

void frames_close(struct frames *frames)
{
    if (!frames)
        return;
    struct gpu *gpu = frames->gpu;
    recorder_close(&frames->recorder);
    gpu->calls.DestroyQueryPool(gpu->device, frames->timestamps, NULL);
    for (uint32_t i = 0; i < frames->kind.builds; i++)
        gpu_destroy_structure(gpu, &frames->structures[i]);
    close_memory(frames, &frames->vertices);
    close_memory(frames, &frames->indices);
    close_memory(frames, &frames->instances);
    close_memory(frames, &frames->scratch);
    gpu_destroy_buffer(gpu, &frames->storage);
    frames_close(frames->referred);
    free(frames->structures);
    free(frames->geometries);
    free(frames->infos);
    free(frames->ranges);
    free(frames);
}

/* ---- frames */

static void choose_mode(struct frames *frames)
{
    const bool updates = frames->kind.updates && frames->is_built;
    for (uint32_t i = 0; i < frames->kind.builds; i++) {
        frames->infos[i].mode = updates ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                        : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
        frames->infos[i].srcAccelerationStructure =
            updates ? frames->structures[i].handle : VK_NULL_HANDLE;
    }
    frames->is_built = true;
}

static void record_barrier(struct frames *frames)
{
    struct gpu *gpu = frames->gpu;
    gpu_barrier(gpu, frames->recorder.commands,
                VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
                VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                    VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR);
}

static void record_timestamp(struct frames *frames, uint32_t number)
{
    const VkuDeviceDispatchTable *calls = &frames->gpu->calls;
    if (!frames->timestamps)
        return;
    if (number == 0)
        calls->CmdResetQueryPool(frames->recorder.commands, frames->timestamps, 0, 2);
    calls->CmdWriteTimestamp(frames->recorder.commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT,
                             frames->timestamps, number);
}

static double read_timestamps(const struct frames *frames)
{
    const struct gpu *gpu = frames->gpu;
    uint64_t ticks[2] = {0};
    if (frames->timestamps)
        TOOL_CALL(gpu->calls, GetQueryPoolResults, gpu->device, frames->timestamps, 0, 2,
                  sizeof(ticks), ticks, sizeof(ticks[0]), VK_QUERY_RESULT_64_BIT);
    return (double)(ticks[1] - ticks[0]) * (double)gpu->properties.limits.timestampPeriod;
}

static void record(struct frames *frames)
{
    struct gpu *gpu = frames->gpu;
    const struct frame_kind *kind = &frames->kind;
    const uint32_t a_call = kind->builds_a_call ? kind->builds_a_call : kind->builds;
    const uint32_t a_barrier = kind->builds_a_barrier ? kind->builds_a_barrier : kind->builds;
    recorder_begin(&frames->recorder, 0);
    record_timestamp(frames, 0);
    for (uint32_t i = 0; i < kind->builds; i += a_call) {
        const uint32_t left = kind->builds - i;
        if (i % a_barrier == 0)
            record_barrier(frames);
        gpu->calls.CmdBuildAccelerationStructuresKHR(frames->recorder.commands,
                                                     left < a_call ? left : a_call,
                                                     &frames->infos[i], &frames->ranges[i]);
    }
    if (frames->timestamps)
        record_barrier(frames);
    record_timestamp(frames, 1);
    recorder_end(&frames->recorder);
}

struct frame_times frames_run(struct frames *frames)
{
    const struct gpu *gpu = frames->gpu;
    choose_mode(frames);
    const double wall = read_clock(CLOCK_MONOTONIC), cpu = read_clock(CLOCK_PROCESS_CPUTIME_ID),
                 thread = thread_time();
    if (frames->kind.by_host) {
        TOOL_CALL(gpu->calls, BuildAccelerationStructuresKHR, gpu->device, VK_NULL_HANDLE,
                  frames->kind.builds, frames->infos, frames->ranges);
    } else {
        record(frames);
        recorder_submit_and_wait(&frames->recorder);
    }
    return (struct frame_times){.wall = read_clock(CLOCK_MONOTONIC) - wall,
                                .cpu = read_clock(CLOCK_PROCESS_CPUTIME_ID) - cpu,
                                .thread = thread_time() - thread,
                                .device = read_timestamps(frames)};
}
