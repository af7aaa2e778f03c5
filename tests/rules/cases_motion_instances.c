/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing_motion_blur: the instances of builds with motion. */
#include <string.h>

#include "case.h"
#include "scene_motion.h"

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

/* Sets something of an instance. */
#define MOVING_INSTANCES(name, index, assignment)                                                  \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        moving_instances(scene);                                                                   \
        instance_at(scene, index)->assignment;                                                     \
    }

MOVING_INSTANCES(instances_of_undefined_type, MATRIX,
                 type = (VkAccelerationStructureMotionInstanceTypeNV)3)
MOVING_INSTANCES(instances_with_flags, SRT, flags = 1)
MOVING_INSTANCES(still_instance_with_flags, STILL, data.staticInstance.flags = 0x40)
MOVING_INSTANCES(still_instance_with_flags_of_micromaps, STILL, data.staticInstance.flags = 0x10)
MOVING_INSTANCES(matrix_instance_with_flags, MATRIX, data.matrixMotionInstance.flags = 0x10)
MOVING_INSTANCES(srt_instance_with_flags, SRT, data.srtMotionInstance.flags = 0x80)
MOVING_INSTANCES(instances_force_opaque, SRT,
                 data.srtMotionInstance.flags = VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR)
MOVING_INSTANCES(instances_of_no_structure, MATRIX,
                 data.matrixMotionInstance.accelerationStructureReference = 0x123456)
MOVING_INSTANCES(instances_of_nothing, MATRIX,
                 data.matrixMotionInstance.accelerationStructureReference = 0)
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
    instances_of_undefined_type(scene);
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
    instances_of_undefined_type(scene);
    scene->geometries[TLAS][0].geometry.instances.data.hostAddress =
        bytes_before_unreadable_page(100);
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_HOST, .setup = &with_content, .mutate_twin = moving_instances,
           .path =
               "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"),
    CASE("motion_instance_of_undefined_type", RULE(motion_instance_type_is_valid),
         .mutate = instances_of_undefined_type, .mutate_twin = more_instances_than_built),
    CASE("motion_instance_with_flags", RULE(motion_instance_flags_are_zero),
         .mutate = instances_with_flags),
    CASE("still_motion_instance_with_undefined_flags", RULE(static_member_is_filled),
         .mutate = still_instance_with_flags),
    CASE("static_motion_instance_with_flags_of_micromaps",
         RULE(instance_micromap_flags_have_their_feature),
         .mutate = still_instance_with_flags_of_micromaps, .count = 1),
    CASE("matrix_motion_instance_with_flags_of_micromaps",
         RULES(RULE_matrix_motion_instance_flags_are_valid),
         NAMES(RULE_matrix_motion_member_is_filled), .mutate = matrix_instance_with_flags),

    SHARED(),
    CASE("matrix_motion_instance_with_flags_of_micromaps_enabled",
         RULE(matrix_motion_instance_flags_are_valid), .silent = true, .commands = ON_HOST,
         .setup = &with_content_and_micromaps, .mutate = matrix_instance_with_flags),

    SHARED(RULE(motion_instance_references_are_valid_handles), .commands = ON_HOST,
           .setup = &with_content, .mutate = instances_of_no_structure),
    CASE("srt_motion_instance_with_undefined_flags",
         RULES(RULE_srt_motion_instance_flags_are_valid), NAMES(RULE_srt_motion_member_is_filled),
         .mutate = srt_instance_with_flags, .mutate_twin = instances_force_opaque,
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"),
    CASE("motion_instance_of_no_structure", .mutate_twin = instances_of_a_structure,
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance"),
    CASE("motion_instance_of_no_structure_or_nothing", .mutate_twin = instances_of_nothing),

    SHARED(RULE(transform_matrix_is_invertible), .commands = ON_DEVICE, .setup = &with_content,
           .mutate_twin = flat_packed_instance_of_nothing),
    CASE("flat_motion_instance", .commands = ON_HOST, .mutate = flat_instance,
         .mutate_twin = flat_instance_of_nothing,
         .path =
             "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 1"),
    CASE("flat_packed_motion_instance", EDITS(CALL(flat_instance), CALL(pack)),
         .has_pointers = true, .path = "deviceAddress leads to instance 1"),
    CASE("packed_motion_instance_with_flags", RULE(srt_motion_instance_flags_are_valid),
         .mutate = packed_instance_with_flags, .has_pointers = true,
         .path = "deviceAddress leads to instance 2"),

    SHARED(RULE(motion_instance_type_is_valid), .commands = ON_HOST, .setup = &with_content),
    CASE("motion_instance_without_memory", RULE(instances_are_backed_by_memory),
         .mutate = instance_without_memory, .mutate_twin = instances_of_a_structure,
         .path =
             "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance 2"),
    CASE("motion_instances_behind_pointers", .silent = true, .mutate = instances_behind_pointers,
         .may_fail_on_cpu = true, .is_for_the_call = true),
    CASE("motion_instances_off_the_page", .silent = true, .mutate = instances_off_the_page,
         .may_fail_on_cpu = true, .is_for_the_call = true),
    CASE("motion_instances_in_device_memory", .silent = true, .commands = ON_COMMAND_BUFFERS,
         .mutate = instances_of_undefined_type, .is_for_the_call = true),
};

CASE_LIST(cases_motion_instances, cases);
