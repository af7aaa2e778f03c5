/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing_motion_blur: the instances of builds with motion. */
#include <string.h>

#include "case.h"
#include "scene_extensions.h"

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV

static const struct setup with_content = {.enable = ENABLE_MOTION, .level = "content"};
static const struct setup with_content_and_micromaps = {
    .enable = ENABLE_MOTION | ENABLE_OPACITY_MICROMAP_EXT, .level = "content"};

/* ---- instances with motion, in host memory ---- */

enum { STILL, MATRIX, SRT, INSTANCES_MADE };

static VkAccelerationStructureMotionInstanceNV *instance_at(struct scene *scene, uint32_t index)
{
    return (void *)(scene->instances.host + 160 * (size_t)index);
}

/* One of each type. */
static void moving_instances(struct scene *scene)
{
    scene_give_motion_dst(scene, TLAS);
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

#define MOTION_INSTANCE(type, index, member, value)                                                \
    WRITE(instances, type,                                                                         \
          160 * (index) + offsetof(VkAccelerationStructureMotionInstanceNV, member), value)
#define MOTION_TYPE(index, value) MOTION_INSTANCE(uint32_t, index, type, value)
#define MOTION_FLAGS(index, value) MOTION_INSTANCE(uint32_t, index, flags, value)
/* Flags are in the byte before a reference. */
#define FLAGS_OF(index, member, value)                                                             \
    WRITE(instances, uint8_t,                                                                      \
          160 * (index)-1 + offsetof(VkAccelerationStructureMotionInstanceNV,                      \
                                     data.member.accelerationStructureReference),                  \
          value)
#define STILL_FLAGS(value) FLAGS_OF(STILL, staticInstance, value)
#define MATRIX_FLAGS(value) FLAGS_OF(MATRIX, matrixMotionInstance, value)
#define SRT_FLAGS(value) FLAGS_OF(SRT, srtMotionInstance, value)
#define MATRIX_REFERENCE(value)                                                                    \
    MOTION_INSTANCE(uint64_t, MATRIX, data.matrixMotionInstance.accelerationStructureReference,    \
                    value)
#define FLATTEN_MATRIX                                                                             \
    MOTION_INSTANCE(uint32_t, MATRIX, data.matrixMotionInstance.transformT1.matrix[0][0], 0)

static void refer_to_a_structure(struct scene *scene)
{
    instance_at(scene, MATRIX)->data.matrixMotionInstance.accelerationStructureReference =
        scene_reference(scene, scene_accel_for(scene, INDEXED));
}

static void instance_without_memory(struct scene *scene)
{
    const struct test_buffer buffer = scene_create_buffer(scene, 65536, ACCEL_USAGE);
    moving_instances(scene);
    instance_at(scene, SRT)->data.srtMotionInstance.accelerationStructureReference =
        scene_reference(scene, scene_accel_in(scene, &buffer, 0, 65536,
                                              VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR));
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

/* The last of them ends where nothing can be read. */
static void leave_100_bytes(struct scene *scene)
{
    scene->INSTANCES(TLAS, 0).data.hostAddress = bytes_before_unreadable_page(100);
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_HOST, .setup = &with_content, .mutate = moving_instances,
           .mutate_twin = moving_instances,
           .path =
               "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"),
    CASE("motion_instance_of_undefined_type", RULE(motion_instance_type_is_valid),
         EDITS(MOTION_TYPE(MATRIX, 3)), TWIN_EDITS(MOTION_TYPE(INSTANCES_MADE, 3))),
    CASE("motion_instance_with_flags", RULE(motion_instance_flags_are_zero),
         EDITS(MOTION_FLAGS(SRT, 1))),
    CASE("still_motion_instance_with_undefined_flags", RULE(static_member_is_filled),
         EDITS(STILL_FLAGS(0x40))),
    CASE("static_motion_instance_with_flags_of_micromaps",
         RULE(instance_micromap_flags_have_their_feature), EDITS(STILL_FLAGS(0x10)), .count = 1),
    CASE("matrix_motion_instance_with_flags_of_micromaps",
         RULE(matrix_motion_instance_flags_are_valid), NAMES(RULE_matrix_motion_member_is_filled),
         EDITS(MATRIX_FLAGS(0x10))),

    SHARED(.commands = ON_HOST, .setup = &with_content, .mutate = moving_instances),
    CASE("matrix_motion_instance_with_flags_of_micromaps_enabled",
         RULE(matrix_motion_instance_flags_are_valid), .silent = true,
         .setup = &with_content_and_micromaps, EDITS(MATRIX_FLAGS(0x10))),
    CASE("srt_motion_instance_with_undefined_flags", RULE(srt_motion_instance_flags_are_valid),
         NAMES(RULE_srt_motion_member_is_filled), EDITS(SRT_FLAGS(0x80)),
         .mutate_twin = moving_instances,
         TWIN_EDITS(SRT_FLAGS(VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"),
    CASE("motion_instance_of_no_structure", RULE(motion_instance_references_are_valid_handles),
         EDITS(MATRIX_REFERENCE(0x123456)), .mutate_twin = moving_instances,
         TWIN_EDITS(CALL(refer_to_a_structure)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"),
    CASE("motion_instance_of_no_structure_or_nothing",
         RULE(motion_instance_references_are_valid_handles), EDITS(MATRIX_REFERENCE(0x123456)),
         .mutate_twin = moving_instances, TWIN_EDITS(MATRIX_REFERENCE(0))),
    CASE("flat_motion_instance", RULE(transform_matrix_is_invertible),
         EDITS(CALL(refer_to_a_structure), FLATTEN_MATRIX), .mutate_twin = moving_instances,
         TWIN_EDITS(FLATTEN_MATRIX),
         .path =
             "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 1"),
    CASE("flat_packed_motion_instance", RULE(transform_matrix_is_invertible), .commands = ON_DEVICE,
         EDITS(CALL(refer_to_a_structure), FLATTEN_MATRIX, CALL(pack)),
         .mutate_twin = moving_instances, TWIN_EDITS(FLATTEN_MATRIX, CALL(pack)),
         .has_pointers = true, .path = "deviceAddress leads to instance 1"),
    CASE("packed_motion_instance_with_flags", RULE(srt_motion_instance_flags_are_valid),
         .commands = ON_DEVICE, EDITS(SRT_FLAGS(0x80), CALL(pack)), .mutate_twin = moving_instances,
         TWIN_EDITS(FLATTEN_MATRIX, CALL(pack)), .has_pointers = true,
         .path = "deviceAddress leads to instance 2"),
    CASE("motion_instance_without_memory", RULE(instances_are_backed_by_memory),
         .mutate = instance_without_memory, .mutate_twin = moving_instances,
         TWIN_EDITS(CALL(refer_to_a_structure)),
         .path =
             "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 2"),

    SHARED(RULE(motion_instance_type_is_valid), .silent = true, .commands = ON_HOST,
           .setup = &with_content, .mutate = moving_instances, .is_for_the_call = true),
    CASE("motion_instances_behind_pointers",
         EDITS(MOTION_TYPE(MATRIX, 3), SET(INSTANCES(TLAS, 0).arrayOfPointers, VK_TRUE)),
         .may_fail_on_cpu = true),
    CASE("motion_instances_off_the_page", EDITS(MOTION_TYPE(MATRIX, 3), CALL(leave_100_bytes)),
         .may_fail_on_cpu = true),
    CASE("motion_instances_in_device_memory", .commands = ON_COMMAND_BUFFERS,
         EDITS(MOTION_TYPE(MATRIX, 3))),
};

CASE_LIST(cases_motion_instances, cases);
