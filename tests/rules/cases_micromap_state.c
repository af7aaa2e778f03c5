/* SPDX-License-Identifier: Apache-2.0 */
/* What micromaps hold when they are used, and micromaps that the same call builds. */
#include "case.h"
#include "placing.h"

#define OPACITY "VkAccelerationStructureTrianglesOpacityMicromap"
#define TRIANGLES_PATH(build) "pInfos[" #build "].pGeometries[0].geometry.triangles.pNext"

static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};
/* Rules of level state that take more to decide here. */

static void submit(struct scene *scene)
{
    scene_end(scene, scene->command_buffer);
    scene_submit(scene, fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0),
                 scene->command_buffer);
}

/* ---- built or not ---- */

static void use_built(struct scene *scene)
{
    scene_use_micromap(scene);
    scene->micromaps.opacity.micromap = scene_record_micromap(scene, 4);
}

static void use_copy(struct scene *scene)
{
    use_built(scene);
    const VkAccelerationStructureKHR clone =
        scene_micromap_structure(scene, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    scene_copy(scene, scene->micromaps.opacity.micromap, clone,
               VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    scene->micromaps.opacity.micromap = clone;
}

static void use_deserialized(struct scene *scene)
{
    scene_use_micromap(scene);
    scene_deserialize(scene, scene->micromaps.opacity.micromap);
}

/* The structure may be a micromap, but is a BLAS. */
static void use_blas_as_micromap(struct scene *scene)
{
    scene_use_micromap(scene);
    const VkAccelerationStructureKHR accel =
        scene_micromap_structure(scene, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[UNINDEXED];
    info.dstAccelerationStructure = accel;
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &info,
                                                 &scene->range_pointers[UNINDEXED]);
    scene->micromaps.opacity.micromap = accel;
}

static void destroy_and_submit(struct scene *scene)
{
    scene_destroy(scene, (uint64_t)scene->micromaps.opacity.micromap);
    submit(scene);
}

static void submit_and_destroy(struct scene *scene)
{
    submit(scene);
    scene_destroy(scene, (uint64_t)scene->micromaps.opacity.micromap);
}

/* Recorded, and submitted before the call. */
static void submit_before(struct scene *scene, VkAccelerationStructureTypeKHR type)
{
    const VkCommandBuffer command_buffer = scene->command_buffer;
    const uint32_t family = fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
    scene_record_in_family(scene, family, 0);
    if (type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)
        use_built(scene);
    else
        use_blas_as_micromap(scene);
    submit(scene);
    scene->command_buffer = command_buffer;
}

/* ---- VK_EXT_opacity_micromap ---- */

static VkMicromapBuildInfoEXT build_info(const struct scene *scene)
{
    return (VkMicromapBuildInfoEXT){.sType = VK_STRUCTURE_TYPE_MICROMAP_BUILD_INFO_EXT,
                                    .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
                                    .dstMicromap = scene->micromaps.opacity_ext.micromap};
}

static void use_built_ext(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    const VkMicromapBuildInfoEXT info = build_info(scene);
    scene->vk->CmdBuildMicromapsEXT(scene->command_buffer, 1, &info);
}

static void use_copy_ext(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    const VkCopyMicromapInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_COPY_MICROMAP_INFO_EXT,
        .src = scene_micromap_ext(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT),
        .dst = scene->micromaps.opacity_ext.micromap,
        .mode = VK_COPY_MICROMAP_MODE_CLONE_EXT,
    };
    scene->vk->CmdCopyMicromapEXT(scene->command_buffer, &info);
}

static void use_deserialized_ext(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    const VkCopyMemoryToMicromapInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_MICROMAP_INFO_EXT,
        .src.deviceAddress = scene->vertices.address,
        .dst = scene->micromaps.opacity_ext.micromap,
        .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT,
    };
    scene->vk->CmdCopyMemoryToMicromapEXT(scene->command_buffer, &info);
}

static void use_built_by_host_ext(struct scene *scene)
{
    scene_use_micromap_ext(scene);
    const VkMicromapBuildInfoEXT info = build_info(scene);
    expect_success(scene->vk->BuildMicromapsEXT(scene->fixture->device, VK_NULL_HANDLE, 1, &info),
                   "vkBuildMicromapsEXT");
}

static void destroy_ext_and_submit(struct scene *scene)
{
    scene_destroy(scene, (uint64_t)scene->micromaps.opacity_ext.micromap);
    submit(scene);
}

/* ---- in one call ---- */

static void place_micromap(struct scene *scene, enum place place)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize offset = place_offset(place_size(scene, UNINDEXED), place);
    scene_use_micromap(scene);
    place_dst(scene, UNINDEXED, &buffer, 0);
    scene->micromaps.opacity.micromap = scene_accel_in(
        scene, &buffer, offset, 4096, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
}

/* A micromap may lie where the build that uses it goes. */
static void place_micromap_in_own_dst(struct scene *scene)
{
    scene_use_micromap(scene);
    scene->micromaps.opacity.micromap =
        scene_accel_in(scene, &scene->dst_buffers[INDEXED], 0, 256,
                       VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
}

static const struct test_case cases[] = {
    SHARED(RULE(opacity_micromap_was_constructed_before), .setup = &with_khr),
    CASE("micromap_never_built", .mutate = scene_use_micromap, .mutate_twin = use_built,
         .then = submit, .twin_then = submit, .forwards = true,
         .path = TRIANGLES_PATH(0) "<" OPACITY "KHR>.micromap"),
    CASE("micromap_copied", .silent = true, .mutate = use_copy, .then = submit),
    CASE("micromap_deserialized", .silent = true, .mutate = use_deserialized, .then = submit),
    CASE("micromap_built_as_blas", RULE(opacity_micromap_was_built_as_micromap),
         .mutate = use_blas_as_micromap, .mutate_twin = use_built,
         .path = TRIANGLES_PATH(0) "<" OPACITY "KHR>.micromap"),
    CASE("micromap_built_as_blas_in_another_command_buffer",
         RULE(opacity_micromap_was_built_as_micromap),
         EITHER_CALL(submit_before, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                     VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR),
         .then = submit, .twin_then = submit, .forwards = true,
         .path = TRIANGLES_PATH(0) "<" OPACITY "KHR>.micromap"),

    SHARED(RULE(opacity_triangles_are_within_micromap), .setup = &with_khr),
    CASE("micromap_with_too_few_triangles", .commands = ON_DEVICE, .prepare = use_built,
         PREPARE_EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_NONE_KHR),
                       SET(micromaps.opacity.indexBuffer, 0)),
         EITHER_SET(micromaps.opacity.baseTriangle, 4, 3),
         .path = TRIANGLES_PATH(0) "<" OPACITY "KHR>.baseTriangle"),
    CASE("micromap_beyond_32_bits_of_triangles", .commands = ON_DEVICE, .prepare = use_built,
         PREPARE_EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_NONE_KHR),
                       SET(micromaps.opacity.indexBuffer, 0),
                       SET(micromaps.opacity.baseTriangle, UINT32_MAX)),
         TWIN_EDITS(SET(ranges[INDEXED][0].primitiveCount, 0))),
    CASE("micromap_with_indices_has_them_elsewhere", .silent = true, .commands = ON_COMMAND_BUFFERS,
         .mutate = use_built, EDITS(SET(micromaps.opacity.baseTriangle, 100))),
    CASE("micromap_destroyed_before_submission", RULE(opacity_micromap_is_valid),
         .commands = ON_COMMAND_BUFFERS,
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR, .level = "execution"),
         .mutate = scene_use_micromap, .mutate_twin = use_built, .then = destroy_and_submit,
         .twin_then = submit_and_destroy, .forwards = true,
         .path = TRIANGLES_PATH(0) "<" OPACITY "KHR>.micromap"),

    SHARED(RULE(ext_opacity_micromap_was_constructed_before),
           SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT), .then = submit),
    CASE("ext_micromap_never_built", .mutate = scene_use_micromap_ext, .mutate_twin = use_built_ext,
         .twin_then = submit, .forwards = true,
         .path = TRIANGLES_PATH(0) "<" OPACITY "EXT>.micromap"),
    CASE("ext_micromap_null_is_never_built", .silent = true, .mutate = scene_use_micromap_ext,
         EDITS(SET(micromaps.opacity_ext.micromap, 0))),
    CASE("ext_micromap_copied", .silent = true, .mutate = use_copy_ext),
    CASE("ext_micromap_deserialized", .silent = true, .mutate = use_deserialized_ext),
    CASE("ext_micromap_built_by_host", .silent = true, .mutate = use_built_by_host_ext),
    CASE("ext_micromap_destroyed_before_submission", RULE(ext_opacity_micromap_is_valid),
         .commands = ON_COMMAND_BUFFERS,
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT, .level = "execution"),
         .prepare = use_built_ext, .then = destroy_ext_and_submit, .twin_then = submit,
         .forwards = true),

    SHARED(RULE(dst_and_micromaps_of_other_builds_are_apart), .setup = &with_khr),
    CASE("dst_is_a_micromap_in_use", RULE(no_dst_is_a_micromap_of_another_build),
         .prepare = scene_use_micromap, PREPARE_EDITS(CALL(scene_build_micromap)),
         EDITS(COPY(infos[AABBS].dstAccelerationStructure, micromaps.opacity.micromap)),
         .path = "pInfos[2].dstAccelerationStructure"),
    CASE("dst_over_a_micromap_in_use", EITHER_CALL(place_micromap, WITHIN, BEHIND),
         .path = "pInfos[1].dstAccelerationStructure"),
    CASE("dst_over_its_own_micromap", .silent = true, .mutate = place_micromap_in_own_dst),
};

CASE_LIST(cases_micromap_state, cases);
