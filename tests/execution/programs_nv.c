/* SPDX-License-Identifier: Apache-2.0 */
/* What recorded builds of VK_NV_ray_tracing use and no longer is there when they are submitted. */
#include "program.h"

static struct shape boxes(void)
{
    struct shape shape = shape_plain();
    shape.geometry_type = VK_GEOMETRY_TYPE_AABBS_KHR;
    return shape;
}

static struct shape instances(void)
{
    struct shape shape = shape_plain();
    shape.geometry_type = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    return shape;
}

#define TRIANGLES_FIELD(field) "pInfo->pGeometries[0].geometry.triangles." field " VkBuffer"

/* An input of a build; the twin loses it after the submission. */
#define INPUT_DIES(name_, input, rule_, path_, shape_)                                             \
    {                                                                                              \
        .name = name_,                                                                             \
        .steps = STEPS(RECORD_BUILD(A, X, GOOD), DESTROY_INPUT(input), REPORTS, RUN(A)),           \
        .twin = STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), IDLE, DESTROY_INPUT(input)), .once = true, \
        RULE_IS(rule_), .path = (path_), .shape = (shape_), .keeps_place = true                    \
    }

/* An object of an update from X to Y. */
#define UPDATE_LOSES(name_, action, rule_, path_)                                                  \
    {                                                                                              \
        .name = name_,                                                                             \
        .steps = STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), RECORD_UPDATE(B, X, Y), IDLE, action,     \
                       REPORTS, RUN(B)),                                                           \
        .twin =                                                                                    \
            STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), RECORD_UPDATE(B, X, Y), RUN(B), IDLE, action), \
        .once = true, RULE_IS(rule_), .path = (path_), .keeps_place = true                         \
    }

static const struct program programs[] = {
    INPUT_DIES("vertex_buffer_destroyed", VERTICES, RULE_nv_vertex_data_is_a_valid_buffer,
               TRIANGLES_FIELD("vertexData"), NULL),
    INPUT_DIES("index_buffer_destroyed", INDICES, RULE_nv_index_data_is_null_or_a_valid_buffer,
               TRIANGLES_FIELD("indexData"), NULL),
    INPUT_DIES("transform_buffer_destroyed", TRANSFORMS, RULE_nv_transform_data_is_a_valid_buffer,
               TRIANGLES_FIELD("transformData"), NULL),
    INPUT_DIES("aabb_buffer_destroyed", BOXES, RULE_nv_aabb_data_is_a_valid_buffer,
               "pInfo->pGeometries[0].geometry.aabbs.aabbData VkBuffer", boxes),
    INPUT_DIES("instance_buffer_destroyed", INSTANCES_INPUT,
               RULE_nv_instance_data_is_a_valid_buffer, "instanceData VkBuffer", instances),
    INPUT_DIES("scratch_buffer_destroyed", SCRATCH, RULE_nv_scratch_is_a_valid_buffer,
               "scratch VkBuffer", NULL),
    UPDATE_LOSES("update_scratch_buffer_destroyed", DESTROY_INPUT(SCRATCH),
                 RULE_nv_scratch_is_a_valid_buffer, "scratch VkBuffer"),
    UPDATE_LOSES("dst_destroyed", DESTROY(Y), RULE_nv_dst_is_a_valid_handle,
                 "dst VkAccelerationStructureNV"),
    UPDATE_LOSES("src_destroyed", DESTROY(X), RULE_nv_src_is_a_valid_handle,
                 "src VkAccelerationStructureNV"),
    UPDATE_LOSES("dst_memory_freed", FREE_MEMORY(Y), RULE_nv_dst_is_bound_to_memory,
                 "dst VkAccelerationStructureNV"),

    /* No rule asks for the memory of a source. */
    {.name = "src_memory_freed",
     .steps = STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), RECORD_UPDATE(B, X, Y), IDLE, FREE_MEMORY(X),
                    RUN(B)),
     .needs = NEEDS_NULL_DRIVER,
     .once = true},
    {.name = "dst_destroyed_and_its_handle_recycled",
     .steps = STEPS(RECORD_BUILD(A, X, GOOD), DESTROY(X), CREATE(X), REPORTS, RUN(A)),
     .twin = STEPS(RECORD_BUILD(A, X, GOOD), RUN(A), IDLE, DESTROY(X), CREATE(X)),
     .once = true,
     .needs = NEEDS_RECYCLING,
     RULE_IS(RULE_nv_dst_is_a_valid_handle),
     .path = "dst VkAccelerationStructureNV",
     .keeps_place = true},
    {.name = "destroyed_under_a_secondary",
     .steps = STEPS(RECORD_BUILD(S, X, GOOD), BEGIN(A), EXECUTE(A, S), END(A),
                    DESTROY_INPUT(INDICES), REPORTS, RUN(A)),
     .twin = STEPS(RECORD_BUILD(S, X, GOOD), BEGIN(A), EXECUTE(A, S), END(A), RUN(A), IDLE,
                   DESTROY_INPUT(INDICES)),
     .once = true,
     RULE_IS(RULE_nv_index_data_is_null_or_a_valid_buffer),
     .path = TRIANGLES_FIELD("indexData"),
     .keeps_place = true},
};

PROGRAM_LIST(nv_programs, programs);
