/* SPDX-License-Identifier: Apache-2.0 */
/* What recorded builds of VK_NV_ray_tracing use and no longer is there when they are submitted. */
#include "program.h"

SHAPE_BUT(instances, shape_plain, geometry_type, VK_GEOMETRY_TYPE_INSTANCES_KHR)

#define TRIANGLES_FIELD(field) "pInfo->pGeometries[0].geometry.triangles." field " VkBuffer"

static const struct program programs[] = {
    INPUT_DIES("vertex_buffer_destroyed", 0, VERTICES, DESTROY_INPUT,
               RULE_nv_vertex_data_is_a_valid_buffer, TRIANGLES_FIELD("vertexData"), NULL),
    INPUT_DIES("index_buffer_destroyed", 0, INDICES, DESTROY_INPUT,
               RULE_nv_index_data_is_null_or_a_valid_buffer, TRIANGLES_FIELD("indexData"), NULL),
    INPUT_DIES("transform_buffer_destroyed", 0, TRANSFORMS, DESTROY_INPUT,
               RULE_nv_transform_data_is_a_valid_buffer, TRIANGLES_FIELD("transformData"), NULL),
    INPUT_DIES("aabb_buffer_destroyed", 0, BOXES, DESTROY_INPUT,
               RULE_nv_aabb_data_is_a_valid_buffer,
               "pInfo->pGeometries[0].geometry.aabbs.aabbData VkBuffer", shape_boxes),
    INPUT_DIES("instance_buffer_destroyed", 0, INSTANCES_INPUT, DESTROY_INPUT,
               RULE_nv_instance_data_is_a_valid_buffer, "instanceData VkBuffer", instances),
    INPUT_DIES("scratch_buffer_destroyed", 0, SCRATCH, DESTROY_INPUT,
               RULE_nv_scratch_is_a_valid_buffer, "scratch VkBuffer", NULL),
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
     .steps = STEPS(GOOD_X(A), RUN(A), UPDATE_XY(B), IDLE, FREE_MEMORY(X), RUN(B)),
     .needs = NEEDS_NULL_DRIVER,
     .once = true},
    DST_IS_RECYCLED(RULE_nv_dst_is_a_valid_handle, "dst VkAccelerationStructureNV"),
    INDICES_DIE_UNDER_A_SECONDARY(RULE_nv_index_data_is_null_or_a_valid_buffer,
                                  TRIANGLES_FIELD("indexData")),
};

PROGRAM_LIST(nv_programs, programs);
