/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing_motion_blur: builds with motion, and the second positions of triangles. */
#include <string.h>

#include "case.h"

#define MOTION_PATH                                                                                \
    "pInfos[0].pGeometries[0].geometry.triangles."                                                 \
    "pNext<VkAccelerationStructureGeometryMotionTrianglesDataNV>.vertexData."

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV
#define FLAGS_WITH_MOTION(build) SET(infos[build].flags, MOTION)

static const struct setup with_motion = {.enable = ENABLE_MOTION};
static const struct setup with_content = {.enable = ENABLE_MOTION, .level = "content"};
static const struct setup with_content_and_micromaps = {
    .enable = ENABLE_MOTION | ENABLE_OPACITY_MICROMAP_EXT, .level = "content"};

/* ---- structures that are made for motion ---- */

/* A moving build may take more than the same one without. */
static void give_motion_objects(struct scene *scene, uint32_t build)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[build];
    const VkBuildAccelerationStructureFlagsKHR flags = info->flags;
    info->flags |= MOTION;
    scene_give_objects(scene, build);
    info->flags = flags;
}

static void give_motion_dst(struct scene *scene, uint32_t build)
{
    give_motion_objects(scene, build);
    const VkAccelerationStructureMotionInfoNV motion_info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV, .maxInstances = 3};
    const VkAccelerationStructureCreateInfoKHR create_info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
        .pNext = &motion_info,
        .createFlags = VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV,
        .buffer = scene->dst_buffers[build].handle,
        .size = scene->dst_buffers[build].size,
        .type = scene->infos[build].type,
    };
    scene->infos[build].dstAccelerationStructure = scene_create_accel(scene, &create_info);
}

static void motion_blas(struct scene *scene)
{
    give_motion_dst(scene, INDEXED);
}

static void motion_tlas(struct scene *scene)
{
    give_motion_dst(scene, TLAS);
}

/* ---- instances with motion, in host memory ---- */

enum { STILL, MATRIX, SRT, INSTANCES_MADE };

static VkAccelerationStructureMotionInstanceNV *instance_at(struct scene *scene, uint32_t index)
{
    return (void *)(scene->instances.host + 160 * (size_t)index);
}

/* One of each type. */
static void moving_instances(struct scene *scene)
{
    give_motion_dst(scene, TLAS);
    scene->infos[TLAS].flags = MOTION;
    memset(scene->instances.host, 0, SCENE_BUFFER_SIZE);
    for (uint32_t i = 0; i < INSTANCES_MADE; i++)
        instance_at(scene, i)->type = (VkAccelerationStructureMotionInstanceTypeNV)i;
    for (uint32_t i = 0; i < 3; i++) {
        instance_at(scene, STILL)->data.staticInstance.transform.matrix[i][i] = 1;
        instance_at(scene, MATRIX)->data.matrixMotionInstance.transformT0.matrix[i][i] = 1;
        instance_at(scene, MATRIX)->data.matrixMotionInstance.transformT1.matrix[i][i] = 1;
    }
    instance_at(scene, SRT)->data.srtMotionInstance.transformT0 =
        instance_at(scene, SRT)->data.srtMotionInstance.transformT1 =
            (VkSRTDataNV){.sx = 1, .sy = 1, .sz = 1, .qw = 1};
}

/* Sets something of an instance. */
#define MOVING_INSTANCES(name, index, assignment)                                                  \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        moving_instances(scene);                                                                   \
        instance_at(scene, index)->assignment;                                                     \
    }

MOVING_INSTANCES(instances_of_nobodys_type, MATRIX,
                 type = (VkAccelerationStructureMotionInstanceTypeNV)3)
MOVING_INSTANCES(instances_with_flags, SRT, flags = 1)
MOVING_INSTANCES(still_instance_with_flags, STILL, data.staticInstance.flags = 0x40)
MOVING_INSTANCES(matrix_instance_with_flags, MATRIX, data.matrixMotionInstance.flags = 0x10)
MOVING_INSTANCES(srt_instance_with_flags, SRT, data.srtMotionInstance.flags = 0x80)
MOVING_INSTANCES(instances_force_opaque, SRT,
                 data.srtMotionInstance.flags = VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR)
MOVING_INSTANCES(instances_of_no_structure, MATRIX,
                 data.matrixMotionInstance.accelerationStructureReference = 0x123456)
MOVING_INSTANCES(instances_of_a_structure, MATRIX,
                 data.matrixMotionInstance.accelerationStructureReference =
                     scene_reference(scene, scene_accel_for(scene, INDEXED)))
/* Of no structure, and of one. */
MOVING_INSTANCES(flat_instance_of_nothing, MATRIX,
                 data.matrixMotionInstance.transformT1.matrix[0][0] = 0)

static void flat_instance(struct scene *scene)
{
    instances_of_a_structure(scene);
    instance_at(scene, MATRIX)->data.matrixMotionInstance.transformT1.matrix[0][0] = 0;
}

static void instance_without_memory(struct scene *scene)
{
    const struct test_buffer buffer = scene_create_buffer(scene, 65536, ACCEL_USAGE);
    moving_instances(scene);
    instance_at(scene, SRT)->data.srtMotionInstance.accelerationStructureReference =
        scene_reference(scene, scene_accel_in(scene, &buffer, 0, 65536,
                                              VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR));
}

/* Behind the last that is built. */
MOVING_INSTANCES(more_instances_than_built, INSTANCES_MADE,
                 type = (VkAccelerationStructureMotionInstanceTypeNV)3)

static void instances_behind_pointers(struct scene *scene)
{
    instances_of_nobodys_type(scene);
    scene->geometries[TLAS][0].geometry.instances.arrayOfPointers = VK_TRUE;
}

/* Their data alone, by pointers that have the types. */
static void pack(struct scene *scene)
{
    uint64_t *pointers = (void *)(scene->instances.host + SCENE_BUFFER_SIZE / 2);
    for (uint32_t i = 0; i < INSTANCES_MADE; i++) {
        const size_t offset = 1024 + 256 * (size_t)i;
        memcpy(scene->instances.host + offset, &instance_at(scene, i)->data,
               sizeof(instance_at(scene, i)->data));
        pointers[i] = scene_address(scene, &scene->instances, offset) + i;
    }
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    scene->ranges[TLAS][0].primitiveOffset = SCENE_BUFFER_SIZE / 2;
}

static void flat_packed_instance(struct scene *scene)
{
    flat_instance(scene);
    pack(scene);
}

static void flat_packed_instance_of_nothing(struct scene *scene)
{
    flat_instance_of_nothing(scene);
    pack(scene);
}

static void packed_instance_with_flags(struct scene *scene)
{
    srt_instance_with_flags(scene);
    pack(scene);
}

/* The last of them ends where nothing can be read. */
static void instances_off_the_page(struct scene *scene)
{
    instances_of_nobodys_type(scene);
    scene->geometries[TLAS][0].geometry.instances.data.hostAddress =
        bytes_before_unreadable_page(100);
}

/* ---- second positions ---- */

static void chain_motion(struct scene *scene, uint64_t address)
{
    scene->motion = (VkAccelerationStructureGeometryMotionTrianglesDataNV){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV,
        .vertexData.deviceAddress = address};
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &scene->motion;
    give_motion_dst(scene, INDEXED);
    scene->infos[INDEXED].flags = MOTION;
}

static void moving(struct scene *scene)
{
    chain_motion(scene, scene_address(scene, &scene->vertices, 12));
}

static void moving_to_null(struct scene *scene)
{
    chain_motion(scene, 0);
}

/* Not in a build with motion; the address has to be good all the same. */
static void moving_to_null_without_flag(struct scene *scene)
{
    chain_motion(scene, 0);
    scene->infos[INDEXED].flags = 0;
    scene->infos[INDEXED].dstAccelerationStructure = scene_accel_for(scene, INDEXED);
}

static void moving_to_freed_memory(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, INPUT_USAGE);
    chain_motion(scene, buffer.address);
    scene_destroy(scene, (uint64_t)buffer.memory);
}

static void moving_past_the_end(struct scene *scene)
{
    struct test_buffer buffer = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &buffer, &memory, 0);
    chain_motion(scene, buffer.address + 4096);
}

static void moving_without_usage(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, SCRATCH_USAGE);
    chain_motion(scene, buffer.address);
}

/* The structure begins where it can be read and ends where it can't. */
static void moving_off_the_page(struct scene *scene)
{
    moving(scene);
    VkBaseOutStructure *cut = bytes_before_unreadable_page(sizeof(*cut));
    cut->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV;
    scene->geometries[INDEXED][0].geometry.triangles.pNext = cut;
}

static const VkBaseInStructure info_for_creation = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV};

static void moving_and_stray(struct scene *scene)
{
    moving(scene);
    scene->motion.pNext = &info_for_creation;
}

static const struct test_case cases[] = {
    {.name = "motion_dst_built_without_motion",
     RULES(RULE_motion_dst_is_built_with_motion),
     .setup = &with_motion,
     .mutate = motion_blas,
     .mutate_twin = motion_blas,
     .twin_edits = EDITS(FLAGS_WITH_MOTION(INDEXED)),
     .path = "pInfos[0].flags"},
    {.name = "motion_tlas_built_without_motion",
     RULES(RULE_motion_dst_is_built_with_motion),
     .setup = &with_motion,
     .mutate = motion_tlas,
     .mutate_twin = motion_tlas,
     .twin_edits = EDITS(FLAGS_WITH_MOTION(TLAS)),
     .may_fail_on_cpu = true,
     .path = "pInfos[3].flags",
     .below_content = true},
    {.name = "motion_build_of_plain_dst",
     RULES(RULE_motion_build_has_a_motion_dst),
     .setup = &with_motion,
     .edits = EDITS(FLAGS_WITH_MOTION(INDEXED)),
     .mutate_twin = motion_blas,
     .twin_edits = EDITS(FLAGS_WITH_MOTION(INDEXED)),
     .path = "pInfos[0].flags"},
    {.name = "motion_build_of_generic_type",
     RULES(RULE_motion_build_is_not_generic, RULE_build_type_is_not_generic),
     .setup = &with_motion,
     .mutate = motion_blas,
     .edits = EDITS(FLAGS_WITH_MOTION(INDEXED),
                    SET(infos[INDEXED].type, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR)),
     .mutate_twin = motion_blas,
     .twin_edits = EDITS(FLAGS_WITH_MOTION(INDEXED)),
     .path = "pInfos[0]."},
    {.name = "flags_of_motion",
     RULES(RULE_build_flags_are_valid),
     .silent = true,
     .setup = &with_motion,
     .mutate = motion_blas,
     .edits = EDITS(FLAGS_WITH_MOTION(INDEXED))},

    {.name = "motion_data_of_other_stype",
     RULES(RULE_motion_triangles_have_their_stype, RULE_triangles_chain_is_known),
     .setup = &with_motion,
     .mutate = moving,
     .edits = EDITS(SET(motion.sType, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MOTION_INFO_NV)),
     .mutate_twin = moving,
     .path = "pInfos[0].pGeometries[0].geometry.triangles.pNext"},
    {.name = "motion_data_without_stype",
     RULES(RULE_motion_triangles_have_their_stype, RULE_triangles_chain_is_known),
     .setup = &with_motion,
     .mutate = moving,
     .edits = EDITS(SET(motion.sType, 0)),
     .mutate_twin = moving},
    {.name = "motion_data_and_a_stray",
     RULES(RULE_triangles_chain_is_known),
     .setup = &with_motion,
     .mutate = moving_and_stray,
     .mutate_twin = moving},
    {.name = "motion_build_of_still_triangles",
     RULES(RULE_motion_triangles_have_their_stype),
     .silent = true,
     .setup = &with_motion,
     .mutate = motion_blas,
     .edits = EDITS(FLAGS_WITH_MOTION(INDEXED))},
    {.name = "motion_data_off_the_page",
     RULES(RULE_triangles_chain_is_known),
     .setup = &with_motion,
     .mutate = moving_off_the_page,
     .mutate_twin = moving},

    {.name = "motion_address_null",
     RULES(RULE_motion_vertex_address_is_given),
     .setup = &with_motion,
     .mutate = moving_to_null,
     .mutate_twin = moving,
     .path = MOTION_PATH},
    {.name = "motion_address_null_in_build_without_motion",
     RULES(RULE_motion_vertex_address_is_given),
     .setup = &with_motion,
     .mutate = moving_to_null_without_flag,
     .mutate_twin = moving,
     .path = MOTION_PATH},
    {.name = "motion_address_null_of_indirect_build",
     .silent = true,
     .setup = &with_motion,
     .mutate = moving_to_null,
     .commands = ON_INDIRECT},
    {.name = "motion_address_past_the_end",
     RULES(RULE_input_address_is_in_a_buffer),
     .setup = &with_motion,
     .mutate = moving_past_the_end,
     .mutate_twin = moving,
     .commands = ON_COMMAND_BUFFERS,
     .path = MOTION_PATH "deviceAddress"},
    {.name = "motion_address_in_freed_memory",
     RULES(RULE_input_buffer_is_bound),
     .setup = &with_motion,
     .mutate = moving_to_freed_memory,
     .mutate_twin = moving,
     .commands = ON_COMMAND_BUFFERS,
     .path = MOTION_PATH "deviceAddress"},
    /* 03673 lists members, and this is none of them. */
    {.name = "motion_buffer_without_usage",
     RULES(RULE_input_buffer_has_build_input_usage),
     .silent = true,
     .setup = &with_motion,
     .mutate = moving_without_usage},

    /* Contents. */
    {.name = "motion_instance_of_nobodys_type",
     RULES(RULE_motion_instance_type_is_valid),
     .setup = &with_content,
     .mutate = instances_of_nobodys_type,
     .mutate_twin = more_instances_than_built,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"},
    {.name = "motion_instance_with_flags",
     RULES(RULE_motion_instance_flags_are_zero),
     .setup = &with_content,
     .mutate = instances_with_flags,
     .mutate_twin = moving_instances,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"},
    {.name = "still_motion_instance_with_nobodys_flags",
     RULES(RULE_static_member_is_filled),
     .setup = &with_content,
     .mutate = still_instance_with_flags,
     .mutate_twin = moving_instances,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"},
    {.name = "matrix_motion_instance_with_flags_of_micromaps",
     RULES(RULE_matrix_motion_instance_flags_are_valid, RULE_matrix_motion_member_is_filled),
     .setup = &with_content,
     .mutate = matrix_instance_with_flags,
     .mutate_twin = moving_instances,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"},
    {.name = "matrix_motion_instance_with_flags_of_micromaps_enabled",
     RULES(RULE_matrix_motion_instance_flags_are_valid),
     .silent = true,
     .setup = &with_content_and_micromaps,
     .mutate = matrix_instance_with_flags,
     .commands = ON_HOST},
    {.name = "srt_motion_instance_with_nobodys_flags",
     RULES(RULE_srt_motion_instance_flags_are_valid, RULE_srt_motion_member_is_filled),
     .setup = &with_content,
     .mutate = srt_instance_with_flags,
     .mutate_twin = instances_force_opaque,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"},
    {.name = "motion_instance_of_no_structure",
     RULES(RULE_motion_instance_references_are_valid_handles),
     .setup = &with_content,
     .mutate = instances_of_no_structure,
     .mutate_twin = instances_of_a_structure,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"},
    {.name = "flat_motion_instance",
     RULES(RULE_transform_matrix_is_invertible),
     .setup = &with_content,
     .mutate = flat_instance,
     .mutate_twin = flat_instance_of_nothing,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 1"},
    {.name = "flat_packed_motion_instance",
     RULES(RULE_transform_matrix_is_invertible),
     .setup = &with_content,
     .mutate = flat_packed_instance,
     .mutate_twin = flat_packed_instance_of_nothing,
     .commands = ON_DEVICE,
     .has_pointers = true,
     .path = "deviceAddress leads to instance 1"},
    {.name = "packed_motion_instance_with_flags",
     RULES(RULE_srt_motion_instance_flags_are_valid),
     .setup = &with_content,
     .mutate = packed_instance_with_flags,
     .mutate_twin = flat_packed_instance_of_nothing,
     .commands = ON_DEVICE,
     .has_pointers = true,
     .path = "deviceAddress leads to instance 2"},
    {.name = "motion_instance_without_memory",
     RULES(RULE_instances_are_backed_by_memory),
     .setup = &with_content,
     .mutate = instance_without_memory,
     .mutate_twin = instances_of_a_structure,
     .commands = ON_HOST,
     .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 2"},
    {.name = "motion_instances_behind_pointers",
     RULES(RULE_motion_instance_type_is_valid),
     .silent = true,
     .setup = &with_content,
     .mutate = instances_behind_pointers,
     .may_fail_on_cpu = true,
     .commands = ON_HOST,
     .is_for_the_call = true},
    {.name = "motion_instances_off_the_page",
     RULES(RULE_motion_instance_type_is_valid),
     .silent = true,
     .setup = &with_content,
     .mutate = instances_off_the_page,
     .may_fail_on_cpu = true,
     .commands = ON_HOST,
     .is_for_the_call = true},
    {.name = "motion_instances_in_device_memory",
     RULES(RULE_motion_instance_type_is_valid),
     .silent = true,
     .setup = &with_content,
     .mutate = instances_of_nobodys_type,
     .commands = ON_COMMAND_BUFFERS,
     .is_for_the_call = true},
};

CASE_LIST(cases_motion, cases);
