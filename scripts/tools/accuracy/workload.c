/* SPDX-License-Identifier: Apache-2.0 */
/* Making scenes, and building them. */
#include "workload.h"
#include "tests/fixture/geometry.h"

#include <stdlib.h>
#include <string.h>

#include "tests/builder/fixture.h"

enum { ALIGNMENT = 256 };

const char *const workload_names[WORKLOAD_KINDS] = {[WORKLOAD_MESH] = "one mesh",
                                                    [WORKLOAD_SMALL] = "1,000 small meshes",
                                                    [WORKLOAD_INSTANCES] = "100,000 instances"};

static VkDeviceSize aligned(VkDeviceSize size, VkDeviceSize alignment)
{
    return (size + alignment - 1) / alignment * alignment;
}

/* ---- inputs */

/* A mesh for each build, one behind the other. */
static void give_meshes(struct workload *workload, uint32_t side)
{
    static const float center[3] = {0, 0, 0};
    struct scene *scene = workload->scene;
    struct fixture_mesh mesh = fixture_sphere(side, 1, center);
    const VkDeviceSize vertices = 12 * (VkDeviceSize)mesh.vertex_count;
    const VkDeviceSize indices = 12 * (VkDeviceSize)mesh.triangle_count;
    const VkDeviceSize vertex_step = aligned(vertices, 16), index_step = aligned(indices, 16);
    const struct device_buffer vertex_buffer =
        scene_buffer(scene, workload->count * vertex_step, INPUT_USAGE);
    const struct device_buffer index_buffer =
        scene_buffer(scene, workload->count * index_step, INPUT_USAGE);

    for (uint32_t i = 0; i < workload->count; i++) {
        memcpy(vertex_buffer.bytes + i * vertex_step, mesh.positions, vertices);
        memcpy(index_buffer.bytes + i * index_step, mesh.indices, indices);
        workload->geometries[i] = triangles_geometry(
            scene_address(scene, &vertex_buffer, i * vertex_step), mesh.vertex_count - 1,
            VK_INDEX_TYPE_UINT32, scene_address(scene, &index_buffer, i * index_step));
        workload->ranges[i].primitiveCount = mesh.triangle_count;
    }
    fixture_mesh_free(&mesh);
}

static void give_instances(struct workload *workload, uint64_t reference, uint32_t count)
{
    struct scene *scene = workload->scene;
    const struct device_buffer buffer =
        scene_buffer(scene, count * sizeof(VkAccelerationStructureInstanceKHR), INPUT_USAGE);
    VkAccelerationStructureInstanceKHR *instances = (void *)buffer.bytes;

    for (uint32_t i = 0; i < count; i++) {
        const uint32_t row = i / 400;
        instances[i] = (VkAccelerationStructureInstanceKHR){
            .transform.matrix = {{1, 0, 0, 3 * (float)(i % 400)},
                                 {0, 1, 0, 3 * (float)row},
                                 {0, 0, 1, 0}},
            .mask = 0xff,
            .accelerationStructureReference = reference};
    }
    workload->geometries[0] = instances_geometry(scene_address(scene, &buffer, 0), false);
    workload->ranges[0].primitiveCount = count;
}

/* ---- builds */

static VkAccelerationStructureBuildSizesInfoKHR sizes_of(const struct workload *workload)
{
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    workload->scene->vk->GetAccelerationStructureBuildSizesKHR(
        workload->scene->fixture->device,
        workload->scene->command == COMMAND_HOST ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                                                 : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
        &workload->infos[0], &workload->ranges[0].primitiveCount, &sizes);
    return sizes;
}

/* All builds of a call are alike, but for their places. */
static void make_builds(struct workload *workload, VkAccelerationStructureTypeKHR type)
{
    struct scene *scene = workload->scene;
    for (uint32_t i = 0; i < workload->count; i++) {
        workload->infos[i] = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = type,
                                  .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                                  .geometryCount = 1, .pGeometries = &workload->geometries[i]);
        workload->range_pointers[i] = &workload->ranges[i];
    }
    const VkAccelerationStructureBuildSizesInfoKHR sizes = sizes_of(workload);
    const VkDeviceSize step = aligned(sizes.accelerationStructureSize, ALIGNMENT);
    const VkDeviceSize scratch_step = aligned(sizes.buildScratchSize + 1, ALIGNMENT);
    const struct device_buffer storage = scene_buffer(scene, workload->count * step, ACCEL_USAGE);
    const struct device_buffer scratch =
        scene_buffer(scene, workload->count * scratch_step, SCRATCH_USAGE);

    for (uint32_t i = 0; i < workload->count; i++) {
        const STRUCT(VkAccelerationStructureCreateInfoKHR, create_info, .buffer = storage.handle,
                     .offset = i * step, .size = sizes.accelerationStructureSize, .type = type);
        GET(scene->vk->CreateAccelerationStructureKHR(
            scene->fixture->device, &create_info, NULL,
            &workload->infos[i].dstAccelerationStructure));
        workload->infos[i].scratchData.deviceAddress =
            scene_address(scene, &scratch, i * scratch_step);
    }
}

void workload_run(const struct workload *workload)
{
    struct scene *scene = workload->scene;
    if (scene->command == COMMAND_HOST) {
        GET(scene->vk->BuildAccelerationStructuresKHR(scene->fixture->device, VK_NULL_HANDLE,
                                                      workload->count, workload->infos,
                                                      workload->range_pointers));
        return;
    }
    scene_begin(scene, workload->command_buffer, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    scene->vk->CmdBuildAccelerationStructuresKHR(workload->command_buffer, workload->count,
                                                 workload->infos, workload->range_pointers);
    scene_end(scene, workload->command_buffer);
    scene_submit(scene, workload->family, workload->command_buffer);
}

/* ---- the whole */

static void reserve(struct workload *workload, struct scene *scene, uint32_t count)
{
    *workload = (struct workload){.scene = scene, .count = count};
    workload->infos = fixture_allocate(count * sizeof(*workload->infos));
    workload->geometries = fixture_allocate(count * sizeof(*workload->geometries));
    workload->ranges = fixture_allocate(count * sizeof(*workload->ranges));
    workload->range_pointers = fixture_allocate(count * sizeof(void *));
    workload->family = fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
    workload->command_buffer = scene_command_buffer(scene, workload->family);
}

static void release(struct workload *workload)
{
    free(workload->infos);
    free(workload->geometries);
    free(workload->ranges);
    free(workload->range_pointers);
}

SCENE_DESTROYS(destroy_accel, DestroyAccelerationStructureKHR, VkAccelerationStructureKHR)

/* A BLAS of the scene, built, for its instances. */
static uint64_t build_instanced(struct scene *scene)
{
    struct workload blas;
    reserve(&blas, scene, 1);
    give_meshes(&blas, 1);
    make_builds(&blas, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    workload_run(&blas);
    const VkAccelerationStructureKHR accel = blas.infos[0].dstAccelerationStructure;
    scene_defer(scene, scene->fixture->device, (uint64_t)accel, destroy_accel);
    release(&blas);
    return scene_reference(scene, accel);
}

void workload_open(struct workload *workload, struct scene *scene, enum workload_kind kind,
                   bool is_quick)
{
    const uint32_t share = is_quick ? 100 : 1;

    switch (kind) {
    case WORKLOAD_MESH:
    case WORKLOAD_SMALL:
        reserve(workload, scene, kind == WORKLOAD_MESH ? 1 : 1000 / share);
        give_meshes(workload, kind == WORKLOAD_SMALL ? 1 : is_quick ? 7 : 76);
        make_builds(workload, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
        break;
    case WORKLOAD_INSTANCES:
        reserve(workload, scene, 1);
        give_instances(workload, build_instanced(scene), 100000 / share);
        make_builds(workload, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
        break;
    case WORKLOAD_KINDS:
        abort();
    }
}

void workload_close(struct workload *workload)
{
    struct scene *scene = workload->scene;
    for (uint32_t i = 0; i < workload->count; i++)
        destroy_accel(scene, scene->fixture->device,
                      (uint64_t)workload->infos[i].dstAccelerationStructure);
    release(workload);
}
