/* SPDX-License-Identifier: Apache-2.0 */
/* The valid build call and its parts. */
#include "tests/player/scene/scene.h"
#include "tests/fixture/geometry.h"

#include <stdlib.h>
#include <string.h>

enum { SECOND_BOXES = 1024 /* of AABBS, in bytes */ };

#define GEOMETRY(scene, build, index) (&(scene)->geometries[build][index])

uint64_t scene_address(const struct scene *scene, const struct device_buffer *buffer,
                       VkDeviceSize offset)
{
    return command_is_on_host(scene->command) ? (uint64_t)(uintptr_t)(buffer->bytes + offset)
                                              : buffer->address + offset;
}

uint64_t scene_reference(const struct scene *scene, VkAccelerationStructureKHR accel)
{
    const STRUCT(VkAccelerationStructureDeviceAddressInfoKHR, info, .accelerationStructure = accel);
    return command_is_on_host(scene->command) || accel == VK_NULL_HANDLE
               ? (uint64_t)accel
               : scene->vk->GetAccelerationStructureDeviceAddressKHR(scene->fixture->device, &info);
}

void scene_skip(struct scene *scene, const char *reason)
{
    scene->skip = reason;
}

/* ---- input data ---- */

static const float identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

static void fill_transforms(struct scene *scene)
{
    for (uint32_t i = 0; i < 4; i++)
        memcpy(scene->transforms.bytes + i * SCENE_TRANSFORM_OFFSET, identity, sizeof(identity));
}

static void fill_vertices(struct scene *scene)
{
    float *vertex = (float *)(void *)scene->vertices.bytes;
    uint32_t *index = (uint32_t *)(void *)scene->indices.bytes;
    uint16_t *short_index = (uint16_t *)(void *)(scene->indices.bytes + SCENE_BUFFER_SIZE / 2);

    for (uint32_t i = 0; i < 64; i++, vertex += 3) {
        vertex[0] = (float)(i % 2);
        vertex[1] = (float)(i % 3);
        vertex[2] = (float)i;
    }
    for (uint32_t i = 0; i < 6; i++) {
        index[i] = i % 4;
        short_index[i] = (uint16_t)(i % 4);
    }
}

/* The first at a stride of 24, then at one of 32. */
static void fill_boxes(struct scene *scene)
{
    float *box = (float *)(void *)scene->boxes.bytes;
    for (uint32_t i = 0; i < SCENE_BUFFER_SIZE / sizeof(float); i++) {
        const uint32_t number = i < SECOND_BOXES / sizeof(float) ? i % 6 : i % 8;
        box[i] = number < 3 ? 0.0f : 1.0f;
    }
}

static void fill_instances(struct scene *scene)
{
    VkAccelerationStructureInstanceKHR *instances = (void *)scene->instances.bytes;
    for (uint32_t i = 0; i < SCENE_BUFFER_SIZE / sizeof(*instances); i++) {
        memcpy(&instances[i].transform, identity, sizeof(identity));
        instances[i].mask = 0xff;
    }
}

static void make_inputs(struct scene *scene)
{
    struct device_buffer *const buffers[] = {&scene->vertices, &scene->indices, &scene->transforms,
                                             &scene->boxes, &scene->instances};
    for (size_t i = 0; i < sizeof(buffers) / sizeof(buffers[0]); i++) {
        *buffers[i] = scene_input(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
        memset(buffers[i]->bytes, 0, SCENE_BUFFER_SIZE);
    }
    fill_vertices(scene);
    fill_transforms(scene);
    fill_boxes(scene);
    fill_instances(scene);
    scene->indirect = scene_input(scene, sizeof(scene->ranges),
                                  VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                                      VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    for (uint32_t build = 0; build < SCENE_BUILDS; build++) {
        scene->indirect_addresses[build] =
            scene->indirect.address + build * sizeof(scene->ranges[build]);
        scene->indirect_strides[build] = sizeof(scene->ranges[build][0]);
    }
}

/* ---- geometries ---- */

static void set_triangles(struct scene *scene, uint32_t build, uint32_t index,
                          VkIndexType index_type, VkDeviceSize index_offset)
{
    *GEOMETRY(scene, build, index) = triangles_geometry(
        scene_address(scene, &scene->vertices, 0), 5, index_type,
        index_type == VK_INDEX_TYPE_NONE_KHR ? 0
                                             : scene_address(scene, &scene->indices, index_offset));
    scene->ranges[build][index].primitiveCount = 2;
}

static void set_boxes(struct scene *scene, uint32_t index, VkDeviceSize offset, VkDeviceSize stride)
{
    *GEOMETRY(scene, AABBS, index) =
        boxes_geometry(scene_address(scene, &scene->boxes, offset), stride);
    GEOMETRY(scene, AABBS, index)->flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    scene->ranges[AABBS][index].primitiveCount = 3;
}

static void set_instances(struct scene *scene)
{
    *GEOMETRY(scene, TLAS, 0) =
        instances_geometry(scene_address(scene, &scene->instances, 0), false);
    scene->ranges[TLAS][0].primitiveCount = 3;
}

static void set_geometries(struct scene *scene)
{
    static const enum scene_build like_indexed[] = {INDEXED, UPDATE, REFIT};

    for (size_t i = 0; i < sizeof(like_indexed) / sizeof(like_indexed[0]); i++) {
        set_triangles(scene, like_indexed[i], 0, VK_INDEX_TYPE_UINT32, 0);
        GEOMETRY(scene, like_indexed[i], 0)->geometry.triangles.transformData.deviceAddress =
            scene_address(scene, &scene->transforms, 0);
    }
    set_triangles(scene, UNINDEXED, 0, VK_INDEX_TYPE_NONE_KHR, 0);
    set_triangles(scene, UNINDEXED, 1, VK_INDEX_TYPE_UINT16, SCENE_BUFFER_SIZE / 2);
    set_boxes(scene, 0, 0, 24);
    set_boxes(scene, 1, SECOND_BOXES, 32);
    set_instances(scene);
}

/* ---- builds ---- */

VkAccelerationStructureBuildSizesInfoKHR scene_sizes(const struct scene *scene, uint32_t build)
{
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    struct messages *messages = &scene->fixture->instance.messages;
    /* Other threads may add messages to a scene that is not edited. */
    const uint32_t since = scene->is_edited ? messages->count : 0;
    uint32_t counts[SCENE_GEOMETRIES];

    for (uint32_t i = 0; i < SCENE_GEOMETRIES; i++)
        counts[i] = scene->ranges[build][i].primitiveCount;
    scene->vk->GetAccelerationStructureBuildSizesKHR(
        scene->fixture->device,
        command_is_on_host(scene->command) ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                                           : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
        &scene->infos[build],
        scene->infos[build].type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR ? NULL
                                                                                        : counts,
        &sizes);
    if (scene->is_edited)
        messages->count = since;
    return sizes;
}

VkDeviceSize scene_scratch_size(const struct scene *scene, uint32_t build)
{
    const VkAccelerationStructureBuildSizesInfoKHR sizes = scene_sizes(scene, build);
    return scene->infos[build].mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
               ? sizes.updateScratchSize
               : sizes.buildScratchSize;
}

VkAccelerationStructureKHR scene_accel_for(struct scene *scene, uint32_t build)
{
    VkDeviceSize size = scene_sizes(scene, build).accelerationStructureSize;
    if (size == 0)
        size = 256; /* what no build can be of has no size on backend cpu */
    scene->dst_buffers[build] = scene_buffer(scene, size, ACCEL_USAGE);
    return scene_accel_in(scene, &scene->dst_buffers[build], 0, size, scene->infos[build].type);
}

void scene_give_objects(struct scene *scene, uint32_t build)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[build];
    const VkAccelerationStructureBuildSizesInfoKHR sizes = scene_sizes(scene, build);
    VkDeviceSize scratch_size = sizes.buildScratchSize;

    if (scratch_size < sizes.updateScratchSize)
        scratch_size = sizes.updateScratchSize;
    scratch_size = scratch_size ? 2 * scratch_size : 1;
    info->dstAccelerationStructure = scene_accel_for(scene, build);
    scene->scratch_buffers[build] = scene_buffer(scene, scratch_size, SCRATCH_USAGE);
    info->scratchData.deviceAddress = scene_address(scene, &scene->scratch_buffers[build], 0);
}

void scene_fit(struct scene *scene, uint32_t build)
{
    const VkAccelerationStructureBuildSizesInfoKHR sizes = scene_sizes(scene, build);
    if (sizes.accelerationStructureSize > scene->dst_buffers[build].size ||
        sizes.buildScratchSize > scene->scratch_buffers[build].size)
        scene_give_objects(scene, build);
}

static void set_info(struct scene *scene, uint32_t build, uint32_t geometry_count)
{
    scene->infos[build] =
        MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
             .type = build == TLAS ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                   : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
             .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
             .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
             .geometryCount = geometry_count, .pGeometries = scene->geometries[build]);
}

uint32_t scene_add_build(struct scene *scene, uint32_t model)
{
    const uint32_t build = scene->info_count++;

    if (build >= SCENE_BUILDS)
        abort();
    scene->infos[build] = scene->infos[model];
    scene->infos[build].pGeometries = scene->geometries[build];
    memcpy(scene->geometries[build], scene->geometries[model], sizeof(scene->geometries[build]));
    memcpy(scene->ranges[build], scene->ranges[model], sizeof(scene->ranges[build]));
    scene_give_objects(scene, build);
    if (scene->infos[build].mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR) {
        scene->infos[build].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
        scene_build_source(scene, build);
    }
    return build;
}

static void set_builds(struct scene *scene)
{
    static const uint32_t geometry_counts[SCENE_BASE_BUILDS] = {
        [INDEXED] = 1, [UNINDEXED] = 2, [AABBS] = 2, [TLAS] = 1, [UPDATE] = 1, [REFIT] = 1};

    for (uint32_t build = 0; build < SCENE_BASE_BUILDS; build++) {
        set_info(scene, build, geometry_counts[build]);
        scene_give_objects(scene, build);
    }
    scene->info_count = SCENE_BASE_BUILDS;
}

static void set_pointers(struct scene *scene)
{
    for (uint32_t build = 0; build < SCENE_BUILDS; build++) {
        scene->range_pointers[build] = scene->ranges[build];
        scene->count_pointers[build] = scene->counts[build];
        for (uint32_t i = 0; i < SCENE_GEOMETRIES; i++)
            scene->geometry_pointers[build][i] = &scene->geometries[build][i];
    }
    scene->infos_argument = scene->infos;
    scene->ranges_argument = scene->range_pointers;
    scene->counts_argument = scene->count_pointers;
    scene->indirect_addresses_argument = scene->indirect_addresses;
    scene->indirect_strides_argument = scene->indirect_strides;
}

static bool can_build(const struct scene *scene)
{
    const struct setup *setup = &scene->fixture->setup;
    return !setup_has(setup, "-accelerationStructure") &&
           (!command_is_on_host(scene->command) ||
            !setup_has(setup, "-accelerationStructureHostCommands"));
}

static void become_updates(struct scene *scene)
{
    static const enum scene_build updates[] = {UPDATE, REFIT};

    for (size_t i = 0; i < sizeof(updates) / sizeof(updates[0]); i++) {
        VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[updates[i]];
        info->mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        info->srcAccelerationStructure = info->dstAccelerationStructure;
    }
    scene->infos[UPDATE].dstAccelerationStructure = scene_accel_for(scene, UPDATE);
}

struct scene *scene_open(struct fixture *fixture, enum build_command command)
{
    struct scene *scene = calloc(1, sizeof(*scene));
    if (scene == NULL)
        abort();
    scene->fixture = fixture;
    scene->vk = &fixture->vk;
    scene->command = command;
    scene->device = fixture->device;

    set_pointers(scene);
    make_inputs(scene);
    set_geometries(scene);
    set_builds(scene);
    scene->command_buffer =
        scene_allocate_command_buffer(scene, scene_pool(scene, scene_family(scene), 0),
                                      fixture->records_secondary ? VK_COMMAND_BUFFER_LEVEL_SECONDARY
                                                                 : VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    scene_begin(scene, scene->command_buffer, 0);
    if (can_build(scene))
        scene_build_before(scene, UPDATE, 2); /* what the updates start from */
    become_updates(scene);
    if (command == COMMAND_NV)
        scene_nv_open(scene);
    else if (command > COMMAND_NV)
        scene_life_open(scene);
    return scene;
}

/* ---- the call ---- */

void scene_use_geometry_pointers(struct scene *scene)
{
    for (uint32_t build = 0; build < SCENE_BUILDS; build++) {
        VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[build];
        if (info->pGeometries == scene->geometries[build] && info->ppGeometries == NULL) {
            info->pGeometries = NULL;
            info->ppGeometries = scene->geometry_pointers[build];
        }
    }
}

static void call_indirect(struct scene *scene)
{
    memcpy(scene->indirect.bytes, scene->ranges, sizeof(scene->ranges));
    for (uint32_t build = 0; build < SCENE_BUILDS; build++) {
        for (uint32_t i = 0; i < SCENE_GEOMETRIES; i++)
            scene->counts[build][i] = scene->ranges[build][i].primitiveCount;
    }
    scene_inputs_copy(scene, scene->command_buffer);
    if (scene->fixture->misaligns)
        scene_misalign(scene);
    scene->vk->CmdBuildAccelerationStructuresIndirectKHR(
        scene->command_buffer, scene->info_count, scene->infos_argument,
        scene->indirect_addresses_argument, scene->indirect_strides_argument,
        scene->counts_argument);
}

VkResult scene_call(struct scene *scene)
{
    if (scene->fixture->misaligns && scene->command != COMMAND_INDIRECT)
        scene_misalign(scene);
    switch ((int)scene->command) {
    case COMMAND_DEVICE:
        scene_inputs_copy(scene, scene->command_buffer);
        scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, scene->info_count,
                                                     scene->infos_argument, scene->ranges_argument);
        break;
    case COMMAND_INDIRECT:
        call_indirect(scene);
        break;
    case COMMAND_HOST:
        return scene->vk->BuildAccelerationStructuresKHR(scene->device, scene->deferred_operation,
                                                         scene->info_count, scene->infos_argument,
                                                         scene->ranges_argument);
    case COMMAND_NV:
        scene_nv_call(scene);
        break;
    default:
        return scene_life_call(scene);
    }
    return VK_SUCCESS;
}

void scene_close(struct scene *scene)
{
    while (scene->cleanup_count > 0) {
        const struct scene_cleanup last = scene->cleanups[--scene->cleanup_count];
        last.destroy(scene, last.device, last.handle);
    }
    free(scene);
}

/* ---- a copy one byte behind what is aligned ---- */

/* Makes a pointer that leads into the scene lead to the same place of its copy. */
static void redirect(const struct scene *scene, const char *copy, void *pointer)
{
    uintptr_t to;
    memcpy(&to, pointer, sizeof(to));
    if (to - (uintptr_t)scene >= sizeof(*scene))
        return;
    to += (uintptr_t)copy - (uintptr_t)scene;
    memcpy(pointer, &to, sizeof(to));
}

void scene_misalign(struct scene *scene)
{
    static _Thread_local _Alignas(struct scene) char room[sizeof(*scene) + 1];
    char *copy = room + 1;
    void *const arguments[] = {&scene->infos_argument,
                               &scene->ranges_argument,
                               &scene->counts_argument,
                               &scene->indirect_addresses_argument,
                               &scene->indirect_strides_argument,
                               &scene->nv.info_argument};
    memcpy(copy, scene, sizeof(*scene));
    for (size_t at = 0; at < sizeof(*scene); at += sizeof(void *))
        redirect(scene, copy, copy + at);
    for (size_t i = 0; i < sizeof(arguments) / sizeof(arguments[0]); i++)
        redirect(scene, copy, arguments[i]);
}
