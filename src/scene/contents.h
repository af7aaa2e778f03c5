/* SPDX-License-Identifier: Apache-2.0 */
/* What a capture's structures hold at a point of the capture, and the rows of their input data:
 * what `export` and `report` have in common. */
#ifndef ASSAY_SCENE_CONTENTS_H
#define ASSAY_SCENE_CONTENTS_H

#include <vulkan/vulkan_core.h>

#include "src/bvh/input/formats.h"
#include "src/scene/capture.h"

/* What is left out, and why. `export` and `report` count it. */
#define LEFT_OUT_LIST(X)                                                                           \
    X(INACTIVE_PRIMITIVES, "inactive primitives")                                                  \
    X(NOT_FINITE, "primitives and instances with infinite coordinates")                            \
    X(NOT_IN_CAPTURE, "primitives whose data is not in the capture")                               \
    X(OTHER_GEOMETRIES, "geometries of other types or formats")                                    \
    X(LEFT_NULL_INSTANCES, "instances without a structure")                                        \
    X(LEFT_UNKNOWN, "instances that refer to no known structure")                                  \
    X(LEFT_DESTROYED, "instances that refer to a destroyed structure")                             \
    X(LEFT_NOT_BUILT, "instances of structures whose build is not in the capture")
#define NUMBER_OF_LEFT_OUT(name, text) name,
enum left_out { LEFT_OUT_LIST(NUMBER_OF_LEFT_OUT) LEFT_OUT };
extern const char *const left_out_names[LEFT_OUT];

/* ---- structures */

/* Executes a command: notes in `builds` what is in its dst then. */
void contents_execute(const struct capture *capture, uint32_t command, uint32_t *builds);

/* Returns, for each structure, the command that last built what is in it after the first
 * `command_count` commands, or CAPTURE_NONE; the caller frees it. What is destroyed later stays:
 * the reference of an instance says whether it was destroyed by then. */
uint32_t *contents_find_builds(const struct capture *capture, uint32_t command_count);

/* Returns whether a command builds a top-level structure. */
bool contents_is_top(const struct capture *capture, uint32_t command);

/* Finds the top-level structure of a name or id, or with NULL the one that was built last;
 * CAPTURE_NONE if none was. Returns false, with an error, if there is none of that name. */
bool contents_find_top(const struct capture *capture, const uint32_t *builds,
                       uint32_t command_count, const char *wanted, uint32_t *top,
                       struct capture_error *error);

/* ---- rows of input data */

/* The rows of an input; none if they are not in the capture. */
struct rows {
    const uint8_t *bytes;
    uint64_t count;
    uint32_t size;
    const struct captured_input *input;
};
struct rows rows_load(struct capture *capture, const struct captured_geometry *geometry,
                      enum capture_role role, struct capture_error *error);
/* Frees what rows_load() has read of a geometry. */
void rows_release(struct capture *capture, const struct captured_geometry *geometry);

/* Returns the format of a name such as VK_FORMAT_R32G32_SFLOAT, or NULL if it is not known. */
const struct vertex_format *vertex_format_named(const char *name);

/* The inputs of a geometry of triangles. Returns false if the format is not known. */
struct triangle_rows {
    const struct captured_geometry *geometry;
    const struct vertex_format *format;
    struct rows vertices, indices, transform;
    uint64_t count; /* triangles that have data */
};
bool triangle_rows_load(struct capture *capture, const struct captured_geometry *geometry,
                        struct triangle_rows *triangles, struct capture_error *error);
/* Finds the row of a vertex. Returns false if it is not in the capture. */
bool triangle_rows_find(const struct triangle_rows *triangles, uint64_t corner, uint64_t *row);

/* ---- meshes */

/* The corners of a geometry's triangles, with its transform, or of the boxes of its AABBs. Only
 * primitives that are not left out have indices, `each` of them. */
struct mesh {
    float (*positions)[3];
    uint32_t *indices;
    uint32_t *primitives; /* their numbers in the geometry */
    uint32_t position_count, position_capacity, index_count, index_capacity, primitive_count,
        primitive_capacity, each;
};
/* Reads a geometry of a build, and counts what the mesh lacks. There is an error if its data cannot
 * be read. The caller releases the mesh. */
struct mesh mesh_read(struct capture *capture, const struct captured_geometry *geometry,
                      uint64_t left_out[LEFT_OUT], struct capture_error *error);
void mesh_release(struct mesh *mesh);

/* ---- instances */

/* What an instance says, moving or not. */
struct placing {
    VkAccelerationStructureInstanceKHR instance; /* of motion, with the first matrix */
    uint32_t number, structure;                  /* once it is found */
};
/* Reads a row of instances. Returns false if its type of motion is unknown. */
bool rows_read_instance(const struct rows *rows, uint64_t at, struct placing *placing);

/* Finds the structure of an instance, or returns why it is left out. */
enum left_out contents_find_instance(const struct capture *capture, const uint32_t *builds,
                                     const struct captured_command *build,
                                     const struct placing *placing, uint32_t *structure);

/* Returns the instances of a build whose structures are known to hold meshes, and counts the
 * others. There is an error if the data cannot be read. The caller frees the array. */
struct placing *contents_read_instances(struct capture *capture, const uint32_t *builds,
                                        const struct captured_command *build, uint32_t *count,
                                        uint64_t left_out[LEFT_OUT], struct capture_error *error);

#endif
