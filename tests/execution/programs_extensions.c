/* SPDX-License-Identifier: Apache-2.0 */
/* What extensions add to builds, as the builds are submitted: their inputs may have died, and dense
 * geometries are updated by what their source was built with. */
#include "program.h"

#define MOTION_FIELD                                                                               \
    ".pGeometries[0].geometry.triangles."                                                          \
    "pNext<VkAccelerationStructureGeometryMotionTrianglesDataNV>.vertexData.deviceAddress"
#define SPHERES_FIELD(field)                                                                       \
    ".pGeometries[0].pNext<VkAccelerationStructureGeometrySpheresDataNV>." field ".deviceAddress"
#define SWEPT_FIELD(field)                                                                         \
    ".pGeometries[0].pNext<VkAccelerationStructureGeometryLinearSweptSpheresDataNV>." field        \
    ".deviceAddress"
#define DENSE_FIELD(field)                                                                         \
    ".pGeometries[0].pNext<VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX>." field

SHAPE_BUT(moving, shape_plain, moves, true)
SHAPE_BUT(spheres, shape_plain, geometry_type, VK_GEOMETRY_TYPE_SPHERES_NV)
SHAPE_BUT(swept, shape_plain, geometry_type, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV)

static struct shape dense(void)
{
    struct shape shape = shape_plain();
    shape.geometry_type = VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
    shape.dense.triangles = shape.primitive_count;
    shape.dense.vertices = 4;
    shape.dense.max_primitive = 1;
    shape.dense.max_geometry = 1;
    shape.dense.size = 512;
    return shape;
}

SHAPE_BUT(fewer_triangles, dense, dense.triangles, 1)
SHAPE_BUT(fewer_vertices, dense, dense.vertices, 3)
SHAPE_BUT(lower_primitives, dense, dense.max_primitive, 0)
SHAPE_BUT(higher_geometries, dense, dense.max_geometry, 2)
SHAPE_BUT(less_data, dense, dense.size, 384)

#define DENSE_UPDATE(name_, rule_, path_, bad_, ...)                                               \
    {                                                                                              \
        .name = name_, .steps = STEPS(__VA_ARGS__), .once = true, .needs = NEEDS_EXTENSIONS,       \
        RULE_IS(rule_), .path = (path_), .shape = dense, .bad = (bad_)                             \
    }
/* What counts is what X was built with last when the update executes. */
#define DENSE_UPDATES(name_, rule_, path_, bad_)                                                   \
    DENSE_UPDATE(name_, rule_, DENSE_FIELD(path_), bad_, UPDATE_XY(B), BAD_X(A), RUN(A), REPORTS,  \
                 RUN(B)),                                                                          \
        DENSE_UPDATE(name_ "_of_a_copy", rule_, DENSE_FIELD(path_), bad_, BAD_X(A),                \
                     RECORD(C, CLONE(C, X, Z)), GOOD_X(D), RECORD_UPDATE(B, Z, Y), RUN(A), RUN(C), \
                     RUN(D), REPORTS, RUN(B))

static const struct program programs[] = {
    INPUT_DIES("motion_buffer_destroyed", NEEDS_EXTENSIONS, BOXES, DESTROY_INPUT,
               RULE_input_address_is_in_a_buffer, MOTION_FIELD, moving),
    INPUT_DIES("sphere_vertex_memory_freed", NEEDS_EXTENSIONS, VERTICES, FREE_INPUT,
               RULE_input_buffer_is_bound, SPHERES_FIELD("vertexData"), spheres),
    INPUT_DIES("sphere_radius_buffer_destroyed", NEEDS_EXTENSIONS, BOXES, DESTROY_INPUT,
               RULE_input_address_is_in_a_buffer, SPHERES_FIELD("radiusData"), spheres),
    INPUT_DIES("sphere_index_buffer_destroyed", NEEDS_EXTENSIONS, INDICES, DESTROY_INPUT,
               RULE_input_address_is_in_a_buffer, SPHERES_FIELD("indexData"), spheres),
    INPUT_DIES("swept_vertex_buffer_destroyed", NEEDS_EXTENSIONS, VERTICES, DESTROY_INPUT,
               RULE_input_address_is_in_a_buffer, SWEPT_FIELD("vertexData"), swept),
    INPUT_DIES("swept_radius_memory_freed", NEEDS_EXTENSIONS, BOXES, FREE_INPUT,
               RULE_input_buffer_is_bound, SWEPT_FIELD("radiusData"), swept),
    INPUT_DIES("swept_index_buffer_destroyed", NEEDS_EXTENSIONS, INDICES, DESTROY_INPUT,
               RULE_input_address_is_in_a_buffer, SWEPT_FIELD("indexData"), swept),
    INPUT_DIES("dense_buffer_destroyed", NEEDS_EXTENSIONS, BOXES, DESTROY_INPUT,
               RULE_input_address_is_in_a_buffer, DENSE_FIELD("compressedData.deviceAddress"),
               dense),
    INPUT_DIES("dense_scratch_destroyed", NEEDS_EXTENSIONS, SCRATCH, DESTROY_INPUT,
               RULE_build_scratch_is_in_one_buffer, ".scratchData.deviceAddress", dense),

    DENSE_UPDATES("dense_triangle_count", RULE_dense_triangle_count_matches_source, "numTriangles",
                  fewer_triangles),
    DENSE_UPDATES("dense_vertex_count", RULE_dense_vertex_count_matches_source, "numVertices",
                  fewer_vertices),
    DENSE_UPDATES("dense_max_primitive_index", RULE_dense_max_primitive_index_matches_source,
                  "maxPrimitiveIndex", lower_primitives),
    DENSE_UPDATES("dense_max_geometry_index", RULE_dense_max_geometry_index_matches_source,
                  "maxGeometryIndex", higher_geometries),
    DENSE_UPDATES("dense_data_size", RULE_dense_data_size_matches_source, "dataSize", less_data),
    DENSE_UPDATE("dense_source_of_triangles", RULE_geometry_type_matches_source,
                 ".pGeometries[0].geometryType", shape_plain, UPDATE_XY(B), BAD_X(A), RUN(A),
                 REPORTS, RUN(B)),
};

PROGRAM_LIST(extension_programs, programs);
