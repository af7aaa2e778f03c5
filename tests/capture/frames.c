/* SPDX-License-Identifier: Apache-2.0 */
/* frames MESHES INSTANCES FRAMES [FOLDER]: a scene of so many meshes and instances, as an engine
 * has it. Before the first frame all meshes are built, and every fourth is compacted. Each frame
 * refits some meshes and builds the top level again, of which every eighth instance has moved;
 * every other frame the device writes the instances. At the end the structures are written to
 * FOLDER/NAME.bin, serialized. The environment names driver and layers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scripts/tools/gpu.h"

enum { CORNERS = 12, VERTICES = CORNERS * CORNERS, TRIANGLES = 2 * (CORNERS - 1) * (CORNERS - 1) };
enum { INDICES = 3 * TRIANGLES, BUILDS_A_CALL = 64, REFITS_A_FRAME = 8, NAME_SIZE = 64 };

#define INPUT VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR
#define ADDRESS VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT

struct scene {
    struct gpu gpu;
    uint32_t meshes, instances;
    struct gpu_buffer vertices, indices, scratch, staged, written;
    struct gpu_structure *bottom, top;
    VkDeviceSize bottom_size, scratch_size;
};

/* ---- meshes: a grid each, whose heights are waves */

static void write_vertices(const struct scene *scene, uint32_t mesh, float time)
{
    float *at = (float *)scene->vertices.data + (size_t)mesh * VERTICES * 3;
    for (uint32_t i = 0; i < VERTICES; i++) {
        const float x = (float)(i % CORNERS), y = (float)(i / CORNERS);
        *at++ = x;
        *at++ = y;
        *at++ = sinf(x * 0.7f + (float)mesh + time) + cosf(y * 0.9f - time);
    }
}

static void write_indices(const struct scene *scene)
{
    uint16_t *at = scene->indices.data;
    for (uint32_t y = 0; y + 1 < CORNERS; y++)
        for (uint32_t x = 0; x + 1 < CORNERS; x++) {
            const uint16_t corner = (uint16_t)(y * CORNERS + x);
            const uint16_t quad[] = {corner,
                                     (uint16_t)(corner + 1),
                                     (uint16_t)(corner + CORNERS),
                                     (uint16_t)(corner + 1),
                                     (uint16_t)(corner + CORNERS + 1),
                                     (uint16_t)(corner + CORNERS)};
            memcpy(at, quad, sizeof(quad));
            at += 6;
        }
}

static bool is_refitted(uint32_t mesh)
{
    return mesh % 4 == 1;
}

static bool is_compacted(uint32_t mesh)
{
    return mesh % 4 == 2;
}

static VkBuildAccelerationStructureFlagsKHR flags_of(uint32_t mesh)
{
    return (is_refitted(mesh) ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR : 0u) |
           (is_compacted(mesh) ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR : 0u);
}

static VkDeviceSize largest(VkDeviceSize a, VkDeviceSize b)
{
    return a > b ? a : b;
}

static VkAccelerationStructureGeometryKHR describe_mesh(const struct scene *scene, uint32_t mesh)
{
    return MAKE(VkAccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
                .geometry.triangles =
                    MAKE(VkAccelerationStructureGeometryTrianglesDataKHR,
                         .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                         .vertexData.deviceAddress =
                             scene->vertices.address + (VkDeviceSize)mesh * VERTICES * 12,
                         .vertexStride = 12, .maxVertex = VERTICES - 1,
                         .indexType = VK_INDEX_TYPE_UINT16,
                         .indexData.deviceAddress = scene->indices.address),
                .flags = mesh % 2 ? VK_GEOMETRY_OPAQUE_BIT_KHR : 0);
}

static VkAccelerationStructureBuildGeometryInfoKHR
describe_build(uint32_t mesh, const VkAccelerationStructureGeometryKHR *geometry)
{
    return MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, .flags = flags_of(mesh),
                .geometryCount = 1, .pGeometries = geometry);
}

static VkAccelerationStructureBuildSizesInfoKHR
sizes_of(const struct scene *scene, const VkAccelerationStructureBuildGeometryInfoKHR *info,
         uint32_t count)
{
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    scene->gpu.calls.GetAccelerationStructureBuildSizesKHR(
        scene->gpu.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, info, &count, &sizes);
    return sizes;
}

/* Builds or updates meshes [begin, end), at most BUILDS_A_CALL, `step` apart. */
static void build_meshes(struct scene *scene, VkCommandBuffer commands, uint32_t begin,
                         uint32_t end, uint32_t step, bool updates)
{
    static const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = TRIANGLES};
    VkAccelerationStructureGeometryKHR geometries[BUILDS_A_CALL];
    VkAccelerationStructureBuildGeometryInfoKHR infos[BUILDS_A_CALL];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[BUILDS_A_CALL];
    uint32_t count = 0;
    for (uint32_t mesh = begin; mesh < end; mesh += step, count++) {
        geometries[count] = describe_mesh(scene, mesh);
        infos[count] = describe_build(mesh, &geometries[count]);
        infos[count].dstAccelerationStructure = scene->bottom[mesh].handle;
        if (updates) {
            infos[count].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
            infos[count].srcAccelerationStructure = scene->bottom[mesh].handle;
        }
        infos[count].scratchData.deviceAddress =
            gpu_scratch_address(&scene->gpu, &scene->scratch) + count * scene->scratch_size;
        ranges[count] = &range;
    }
    scene->gpu.calls.CmdBuildAccelerationStructuresKHR(commands, count, infos, ranges);
    gpu_barrier(&scene->gpu, commands, VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR |
                    VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR,
                VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR |
                    VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR);
}

static void create_meshes(struct scene *scene)
{
    struct gpu *gpu = &scene->gpu;
    const VkAccelerationStructureGeometryKHR geometry = describe_mesh(scene, 0);
    VkAccelerationStructureBuildGeometryInfoKHR info = describe_build(0, &geometry);
    /* Sizes differ by flags, and fewer flags may need more. */
    for (uint32_t mesh = 0; mesh < 4; mesh++) {
        info.flags = flags_of(mesh);
        const VkAccelerationStructureBuildSizesInfoKHR sizes = sizes_of(scene, &info, TRIANGLES);
        scene->bottom_size = largest(scene->bottom_size, sizes.accelerationStructureSize);
        scene->scratch_size = largest(scene->scratch_size, sizes.buildScratchSize);
        scene->scratch_size = largest(scene->scratch_size, sizes.updateScratchSize);
    }
    scene->scratch_size = gpu_align(scene->scratch_size, 256);
    for (uint32_t mesh = 0; mesh < scene->meshes; mesh++) {
        char name[NAME_SIZE];
        snprintf(name, sizeof(name), "mesh-%u", mesh);
        write_vertices(scene, mesh, 0);
        scene->bottom[mesh] = gpu_create_structure(
            gpu, name, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene->bottom_size);
    }
}

static void build_all(struct scene *scene)
{
    VkCommandBuffer commands = gpu_begin(&scene->gpu);
    for (uint32_t mesh = 0; mesh < scene->meshes; mesh += BUILDS_A_CALL)
        build_meshes(scene, commands, mesh,
                     mesh + BUILDS_A_CALL < scene->meshes ? mesh + BUILDS_A_CALL : scene->meshes, 1,
                     false);
    gpu_submit(&scene->gpu, commands);
}

/* ---- compaction, and serialization */

static VkDeviceSize query_size(struct scene *scene, VkAccelerationStructureKHR structure,
                               VkQueryType type)
{
    struct gpu *gpu = &scene->gpu;
    VkQueryPool pool;
    VkDeviceSize size = 0;
    TOOL_CALL(gpu->calls, CreateQueryPool, gpu->device,
              &MAKE(VkQueryPoolCreateInfo, .queryType = type, .queryCount = 1), NULL, &pool);
    VkCommandBuffer commands = gpu_begin(gpu);
    gpu->calls.CmdResetQueryPool(commands, pool, 0, 1);
    gpu->calls.CmdWriteAccelerationStructuresPropertiesKHR(commands, 1, &structure, type, pool, 0);
    gpu_submit(gpu, commands);
    TOOL_CALL(gpu->calls, GetQueryPoolResults, gpu->device, pool, 0, 1, sizeof(size), &size,
              sizeof(size), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    gpu->calls.DestroyQueryPool(gpu->device, pool, NULL);
    return size;
}

static void compact(struct scene *scene, uint32_t mesh)
{
    struct gpu *gpu = &scene->gpu;
    char name[NAME_SIZE];
    snprintf(name, sizeof(name), "compacted-%u", mesh);
    const VkDeviceSize size = query_size(scene, scene->bottom[mesh].handle,
                                         VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR);
    const struct gpu_structure small =
        gpu_create_structure(gpu, name, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, size);
    VkCommandBuffer commands = gpu_begin(gpu);
    gpu->calls.CmdCopyAccelerationStructureKHR(
        commands,
        &MAKE(VkCopyAccelerationStructureInfoKHR, .src = scene->bottom[mesh].handle,
              .dst = small.handle, .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR));
    gpu_submit(gpu, commands);
    gpu_destroy_structure(gpu, &scene->bottom[mesh]);
    scene->bottom[mesh] = small;
}

static void serialize(struct scene *scene, const struct gpu_structure *structure, const char *path)
{
    struct gpu *gpu = &scene->gpu;
    const VkDeviceSize size = query_size(
        scene, structure->handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR);
    struct gpu_buffer buffer =
        gpu_create_buffer(gpu, "serialized", GPU_PLACE_HOST,
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | ADDRESS, size + 256);
    const VkDeviceSize offset = gpu_align(buffer.address, 256) - buffer.address;
    VkCommandBuffer commands = gpu_begin(gpu);
    gpu->calls.CmdCopyAccelerationStructureToMemoryKHR(
        commands, &MAKE(VkCopyAccelerationStructureToMemoryInfoKHR, .src = structure->handle,
                        .dst.deviceAddress = buffer.address + offset,
                        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR));
    gpu_submit(gpu, commands);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite((char *)buffer.data + offset, 1, size, file) != size || fclose(file) != 0)
        tool_fail("%s cannot be written", path);
    gpu_destroy_buffer(gpu, &buffer);
}

static void serialize_all(struct scene *scene, const char *folder)
{
    char path[4096];
    for (uint32_t mesh = 0; mesh < scene->meshes; mesh++) {
        snprintf(path, sizeof(path), "%s/%s-%u.bin", folder,
                 is_compacted(mesh) ? "compacted" : "mesh", mesh);
        serialize(scene, &scene->bottom[mesh], path);
    }
    snprintf(path, sizeof(path), "%s/top.bin", folder);
    serialize(scene, &scene->top, path);
}

/* ---- instances and frames */

static void write_instances(struct scene *scene, uint32_t frame)
{
    VkAccelerationStructureInstanceKHR *at = scene->staged.data;
    for (uint32_t i = 0; i < scene->instances; i++) {
        const float moved = i % 8 == 0 ? (float)frame : 0;
        at[i] = (VkAccelerationStructureInstanceKHR){
            .transform.matrix = {{1, 0, 0, (float)(i % 100) * 14 + moved},
                                 {0, 1, 0, (float)(i / 100) * 14},
                                 {0, 0, i % 3 ? 1.f : -1.f, moved}},
            .instanceCustomIndex = i,
            .mask = 0xff,
            .accelerationStructureReference =
                gpu_structure_address(&scene->gpu, &scene->bottom[i % scene->meshes]),
        };
    }
}

static VkAccelerationStructureGeometryKHR describe_instances(const struct gpu_buffer *from)
{
    return MAKE(VkAccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
                .geometry.instances = MAKE(VkAccelerationStructureGeometryInstancesDataKHR,
                                           .data.deviceAddress = from->address));
}

static VkAccelerationStructureBuildGeometryInfoKHR
describe_top(const VkAccelerationStructureGeometryKHR *geometry)
{
    return MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, .geometryCount = 1,
                .pGeometries = geometry);
}

static void create_top(struct scene *scene)
{
    const VkAccelerationStructureGeometryKHR geometry = describe_instances(&scene->staged);
    const VkAccelerationStructureBuildGeometryInfoKHR info = describe_top(&geometry);
    const VkAccelerationStructureBuildSizesInfoKHR sizes = sizes_of(scene, &info, scene->instances);
    scene->top =
        gpu_create_structure(&scene->gpu, "top", VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                             sizes.accelerationStructureSize);
    scene->scratch =
        gpu_create_scratch(&scene->gpu, "scratch",
                           largest(sizes.buildScratchSize, BUILDS_A_CALL * scene->scratch_size));
}

static void build_top(struct scene *scene, VkCommandBuffer commands, bool by_device)
{
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = scene->instances};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    const VkAccelerationStructureGeometryKHR geometry =
        describe_instances(by_device ? &scene->written : &scene->staged);
    VkAccelerationStructureBuildGeometryInfoKHR info = describe_top(&geometry);
    info.dstAccelerationStructure = scene->top.handle;
    info.scratchData.deviceAddress = gpu_scratch_address(&scene->gpu, &scene->scratch);
    if (by_device) {
        scene->gpu.calls.CmdCopyBuffer(commands, scene->staged.handle, scene->written.handle, 1,
                                       &(VkBufferCopy){.size = scene->staged.size});
        gpu_barrier(
            &scene->gpu, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, VK_ACCESS_SHADER_READ_BIT);
    }
    scene->gpu.calls.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

static void play_frame(struct scene *scene, uint32_t frame)
{
    const uint32_t kinds =
        (scene->meshes + 2) / 4; /* meshes that are refitted: 1, 5, 9 and so on */
    const uint32_t first = kinds ? frame * REFITS_A_FRAME % kinds : 0;
    const uint32_t last = first + REFITS_A_FRAME < kinds ? first + REFITS_A_FRAME : kinds;
    for (uint32_t i = first; i < last; i++)
        write_vertices(scene, 1 + 4 * i, (float)(frame + 1) * 0.1f);
    write_instances(scene, frame);
    VkCommandBuffer commands = gpu_begin(&scene->gpu);
    if (first < last)
        build_meshes(scene, commands, 1 + 4 * first, 4 * last, 4, true);
    build_top(scene, commands, frame % 2);
    gpu_submit(&scene->gpu, commands);
}

int main(int count, char **arguments)
{
    if (count < 4)
        tool_fail("usage: frames MESHES INSTANCES FRAMES [FOLDER]");
    struct scene scene = {.meshes = (uint32_t)atoi(arguments[1]),
                          .instances = (uint32_t)atoi(arguments[2])};
    struct gpu *gpu = &scene.gpu;
    const VkDeviceSize instances_size =
        scene.instances * sizeof(VkAccelerationStructureInstanceKHR);
    gpu_open(gpu, NULL, &MAKE(VkDebugUtilsMessengerCreateInfoEXT), false);
    scene.bottom = tool_alloc(scene.meshes, sizeof(*scene.bottom));
    scene.vertices = gpu_create_buffer(gpu, "vertices", GPU_PLACE_HOST, INPUT | ADDRESS,
                                       (VkDeviceSize)scene.meshes * VERTICES * 12);
    scene.indices = gpu_create_buffer(gpu, "indices", GPU_PLACE_HOST, INPUT | ADDRESS, INDICES * 2);
    scene.staged =
        gpu_create_buffer(gpu, "instances", GPU_PLACE_HOST,
                          INPUT | ADDRESS | VK_BUFFER_USAGE_TRANSFER_SRC_BIT, instances_size);
    scene.written =
        gpu_create_buffer(gpu, "instances of the device", GPU_PLACE_DEVICE,
                          INPUT | ADDRESS | VK_BUFFER_USAGE_TRANSFER_DST_BIT, instances_size);
    write_indices(&scene);
    create_meshes(&scene);
    create_top(&scene);
    build_all(&scene);
    for (uint32_t mesh = 2; mesh < scene.meshes; mesh += 4)
        compact(&scene, mesh);
    for (int frame = 0; frame < atoi(arguments[3]); frame++)
        play_frame(&scene, (uint32_t)frame);
    if (count > 4)
        serialize_all(&scene, arguments[4]);
    for (uint32_t mesh = 0; mesh < scene.meshes; mesh++)
        gpu_destroy_structure(gpu, &scene.bottom[mesh]);
    gpu_destroy_structure(gpu, &scene.top);
    gpu_destroy_buffer(gpu, &scene.vertices);
    gpu_destroy_buffer(gpu, &scene.indices);
    gpu_destroy_buffer(gpu, &scene.staged);
    gpu_destroy_buffer(gpu, &scene.written);
    gpu_destroy_buffer(gpu, &scene.scratch);
    gpu_close(gpu);
    free(scene.bottom);
    return EXIT_SUCCESS;
}
