/* SPDX-License-Identifier: Apache-2.0 */
/* What recorded builds use and no longer is there when they are submitted. */
#include "program.h"

#define TRIANGLES_FIELD(field) ".pGeometries[0].geometry.triangles." field ".deviceAddress"

static struct shape instances(void)
{
    struct shape shape = shape_plain();
    shape.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    shape.geometry_type = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    return shape;
}

/* Of geometries without primitives nothing is read, so their inputs may go. */
SHAPE_BUT(no_triangles, shape_plain, primitive_count, 0)
SHAPE_BUT(no_instances, instances, primitive_count, 0)

/* Of an input, the buffer or else its memory. */
#define BUFFER_OR_MEMORY_DIES(name_, input, rule_, path_, shape_)                                  \
    INPUT_DIES(name_ "_buffer_destroyed", 0, input, DESTROY_INPUT, rule_, path_, shape_),          \
        INPUT_DIES(name_ "_memory_freed", 0, input, FREE_INPUT, RULE_input_buffer_is_bound, path_, \
                   shape_)

#define UNREAD_INPUT_DIES(name_, action, shape_)                                                   \
    {                                                                                              \
        .name = name_, .steps = STEPS(GOOD_X(A), action, RUN(A)), .once = true, .shape = (shape_)  \
    }

/* Its address is taken over by another buffer before the submission: as good as before. */
#define INPUT_IS_RENEWED(name_, input, shape_)                                                     \
    {                                                                                              \
        .name = name_, .steps = STEPS(GOOD_X(A), RENEW_INPUT(input), RUN(A)),                      \
        .needs = NEEDS_RECYCLING, .once = true, .shape = (shape_)                                  \
    }

static const struct program programs[] = {
    BUFFER_OR_MEMORY_DIES("vertex", VERTICES, RULE_input_address_is_in_a_buffer,
                          TRIANGLES_FIELD("vertexData"), NULL),
    BUFFER_OR_MEMORY_DIES("index", INDICES, RULE_input_address_is_in_a_buffer,
                          TRIANGLES_FIELD("indexData"), NULL),
    BUFFER_OR_MEMORY_DIES("transform", TRANSFORMS, RULE_transform_address_is_valid,
                          TRIANGLES_FIELD("transformData"), NULL),
    BUFFER_OR_MEMORY_DIES("aabb", BOXES, RULE_input_address_is_in_a_buffer,
                          ".pGeometries[0].geometry.aabbs.data.deviceAddress", shape_boxes),
    BUFFER_OR_MEMORY_DIES("instance", INSTANCES_INPUT, RULE_input_address_is_in_a_buffer,
                          ".pGeometries[0].geometry.instances.data.deviceAddress", instances),
    BUFFER_OR_MEMORY_DIES("scratch", SCRATCH, RULE_build_scratch_is_in_one_buffer,
                          ".scratchData.deviceAddress", NULL),

    UNREAD_INPUT_DIES("unread_vertex_buffer_destroyed", DESTROY_INPUT(VERTICES), no_triangles),
    UNREAD_INPUT_DIES("unread_index_memory_freed", FREE_INPUT(INDICES), no_triangles),
    UNREAD_INPUT_DIES("unread_transform_buffer_destroyed", DESTROY_INPUT(TRANSFORMS), no_triangles),
    UNREAD_INPUT_DIES("unread_instance_buffer_destroyed", DESTROY_INPUT(INSTANCES_INPUT),
                      no_instances),

    INPUT_IS_RENEWED("vertex_buffer_renewed", VERTICES, NULL),
    INPUT_IS_RENEWED("index_buffer_renewed", INDICES, NULL),
    INPUT_IS_RENEWED("transform_buffer_renewed", TRANSFORMS, NULL),
    INPUT_IS_RENEWED("aabb_buffer_renewed", BOXES, shape_boxes),
    INPUT_IS_RENEWED("instance_buffer_renewed", INSTANCES_INPUT, instances),
    INPUT_IS_RENEWED("scratch_buffer_renewed", SCRATCH, NULL),

    UPDATE_LOSES("update_scratch_buffer_destroyed", DESTROY_INPUT(SCRATCH),
                 RULE_update_scratch_is_in_one_buffer, ".scratchData.deviceAddress"),
    UPDATE_LOSES("update_scratch_memory_freed", FREE_INPUT(SCRATCH), RULE_input_buffer_is_bound,
                 ".scratchData.deviceAddress"),
    UPDATE_LOSES("update_vertex_buffer_destroyed", DESTROY_INPUT(VERTICES),
                 RULE_input_address_is_in_a_buffer, TRIANGLES_FIELD("vertexData")),
    UPDATE_LOSES("build_range_buffer_destroyed", DESTROY_INPUT(RANGES),
                 RULE_indirect_ranges_are_in_one_buffer, "pIndirectDeviceAddresses[0]"),
    UPDATE_LOSES("build_range_memory_freed", FREE_INPUT(RANGES), RULE_input_buffer_is_bound,
                 "pIndirectDeviceAddresses[0]"),
    UPDATE_LOSES("dst_destroyed", DESTROY(Y), RULE_dst_is_a_valid_handle,
                 ".dstAccelerationStructure"),
    UPDATE_LOSES("src_destroyed", DESTROY(X), RULE_src_is_a_valid_handle,
                 ".srcAccelerationStructure"),
    UPDATE_LOSES("dst_buffer_destroyed", DESTROY_BUFFER(Y), RULE_dst_is_backed_by_memory,
                 ".dstAccelerationStructure"),
    UPDATE_LOSES("src_buffer_destroyed", DESTROY_BUFFER(X), RULE_update_src_is_backed_by_memory,
                 ".srcAccelerationStructure"),
    UPDATE_LOSES("dst_memory_freed", FREE_MEMORY(Y), RULE_dst_is_backed_by_memory,
                 ".dstAccelerationStructure"),
    UPDATE_LOSES("src_memory_freed", FREE_MEMORY(X), RULE_update_src_is_backed_by_memory,
                 ".srcAccelerationStructure"),

    DST_IS_RECYCLED(RULE_dst_is_a_valid_handle, ".dstAccelerationStructure"),
    BREAKS("destroyed_before_resubmission", 0, RULE_input_address_is_in_a_buffer,
           TRIANGLES_FIELD("indexData"),
           (GOOD_X(A), RUN(A), IDLE, DESTROY_INPUT(INDICES), REPORTS, RUN(A)),
           (GOOD_X(A), RUN(A), IDLE, RUN(A), IDLE, DESTROY_INPUT(INDICES))),
    INDICES_DIE_UNDER_A_SECONDARY(RULE_input_address_is_in_a_buffer, TRIANGLES_FIELD("indexData")),
    {.name = "destroyed_and_never_submitted",
     .steps = STEPS(GOOD_X(A), DESTROY_INPUT(INDICES), DESTROY(X)),
     .once = true},
};

PROGRAM_LIST(death_programs, programs);
