/* SPDX-License-Identifier: Apache-2.0 */
/* The source of a geometry's primitives: Vulkan's ranges resolved to pointers and limits. */
#ifndef ASSAY_BVH_INPUT_SOURCE_H
#define ASSAY_BVH_INPUT_SOURCE_H

#include <math.h>
#include <string.h>

#include "src/bvh/bvh.h"
#include "src/bvh/input/formats.h"
#include "src/bvh/structure.h"

/* The result of reading a primitive. */
enum source_state {
    SOURCE_ACTIVE,
    SOURCE_INACTIVE,
    SOURCE_UNDEFINED,    /* NaN in Y or Z but not X; not used */
    SOURCE_OUT_OF_RANGE, /* not read */
    SOURCE_UNRESOLVED,   /* the resolver does not find the instance's reference */
};

/* A decoded triangle of dense geometry. */
struct dense_triangle {
    float a[3], b[3], c[3];
    uint32_t geometry, primitive;
    uint32_t is_opaque;
    enum source_state found;
};

struct displaced_point {
    float at[3];
};

/* A triangle that is subdivided into parts. */
struct displaced_base {
    uint32_t first; /* first part, counted within the geometry; an inactive triangle has one part */
    uint32_t point; /* first vertex (displacement.h defines the order) */
    uint8_t level, edges, found; /* `found`: enum source_state */
};

/* The array that maps each triangle to a triangle of a micromap. */
struct micromap_indices {
    const uint8_t *indices; /* NULL if there are no indices */
    uint64_t stride;
    uint32_t index_size, base;
    bool is_present;
};

struct source {
    uint32_t first; /* first primitive in the structure, counted over all geometries */
    uint32_t count; /* number of parts if triangles are displaced */
    /* For triangles. */
    const struct vertex_format *format;
    const uint8_t *vertices; /* vertex of index 0, with offset and firstVertex applied */
    const uint8_t *indices;  /* NULL if there are no indices */
    uint64_t stride;         /* stride of vertices, AABBs or instances */
    uint64_t index_limit;    /* lower indices are readable */
    uint32_t index_size;
    struct micromap_indices opacity;
    /* Positions at time 1, from index 0 on, as many as `vertices`; NULL if static. */
    const uint8_t *motion_vertices;
    bool has_transform, is_plain; /* plain: untransformed float positions with 32-bit indices */
    VkTransformMatrixKHR transform;
    /* For spheres and linear swept spheres, in addition to format, vertices, indices and limit. */
    struct sphere_source {
        const uint8_t *radii;
        uint64_t radius_stride, index_stride;
        bool is_half, is_successive, has_caps;
    } spheres;
    const struct dense_triangle *dense;
    uint32_t max_primitive; /* for dense geometry */
    /* For structures with displaced triangles. */
    const struct displaced_base *bases;
    const struct displaced_point *points, *motion_points; /* at times 0 and 1 */
    uint32_t base_count;
    /* For AABBs and instances. */
    const uint8_t *data;
    bool is_pointer_array, has_motion;
};

/* Whether all triangles are certainly active. Looks at each vertex once, which is faster than
 * reading all triangles. `index_max`: the largest index; ignored if there are no indices. */
bool source_triangles_are_active(const struct source *source, uint32_t index_max);

/* Opens a geometry. Its type must match the structure and its format must be supported. Returns
 * false if the range exceeds the data. */
bool source_open(struct source *source, bool has_motion, const struct builder_geometry *geometry,
                 const VkAccelerationStructureBuildRangeInfoKHR *range);

bool source_open_spheres(struct source *source, const struct builder_spheres *spheres,
                         bool is_swept, const VkAccelerationStructureBuildRangeInfoKHR *range);

bool source_open_instances(struct source *source, const struct builder_instances *instances,
                           const VkAccelerationStructureBuildRangeInfoKHR *range);
/* Returns false if the elements of the range exceed the data. */
bool source_open_array(struct source *source, const void *data, uint64_t size, uint64_t element,
                       uint64_t stride, const VkAccelerationStructureBuildRangeInfoKHR *range);

/* Returns the number of elements of `size` bytes at `stride` that fit in `room` bytes. */
uint64_t source_elements_in(uint64_t room, uint64_t size, uint64_t stride);
bool source_index_is_known(VkIndexType type);
uint32_t source_read_number(const uint8_t *from, uint32_t size);

/* Reads the vertex numbers of a triangle. Returns false if one is out of range. */
bool source_corners(const struct source *source, uint32_t primitive, uint64_t index[3]);
/* Computes in double, so that each component is rounded only twice and overflows only if the result
 * does. The same vertex gives the same result, so shared vertices stay shared. */
void source_transform(const VkTransformMatrixKHR *transform, const double from[3], float to[3]);
enum source_state source_triangle(const struct source *source, uint32_t primitive,
                                  struct triangle_record *record);
/* Reads an active triangle of a plain source. Returns false if it is none, or out of range. */
static inline bool source_read_plain(const struct source *source, uint32_t primitive,
                                     struct triangle_record *record)
{
    uint32_t index[3];
    memcpy(index, source->indices + (uint64_t)primitive * sizeof(index), sizeof(index));
    if (index[0] >= source->index_limit || index[1] >= source->index_limit ||
        index[2] >= source->index_limit)
        return false;
    memcpy(record->a, source->vertices + source->stride * index[0], sizeof(record->a));
    memcpy(record->b, source->vertices + source->stride * index[1], sizeof(record->b));
    memcpy(record->c, source->vertices + source->stride * index[2], sizeof(record->c));
    bool has_nan = false;
    for (int i = 0; i < 3; i++) {
        record->a[i] += 0.0f;
        record->b[i] += 0.0f;
        record->c[i] += 0.0f;
        has_nan |= isunordered(record->a[i], record->b[i]) || isnan(record->c[i]);
    }
    return !has_nan;
}
/* Returns SOURCE_INACTIVE if the triangle is inactive at either time. */
enum source_state source_motion_triangle(const struct source *source, uint32_t primitive,
                                         struct motion_triangle_record *record);
/* Returns false if the indices of `count` triangles are not readable. */
bool source_open_indices(struct micromap_indices *indices, VkIndexType type, uint32_t base,
                         const void *data, uint64_t size, uint64_t stride, uint64_t count);
/* Returns the micromap index of a triangle without the base. Special indices are the greatest
 * values. */
#define SOURCE_SPECIAL UINT64_C(0xfffffffffffffffc) /* the lowest special index */
uint64_t source_micromap_index(const struct micromap_indices *indices, uint32_t primitive);
/* Returns the `opacity` of a triangle's record. The source must have opacities. */
uint32_t source_opacity(const struct source *source, uint32_t primitive);
/* Prefetches a triangle that is read soon: first its indices, later its vertices. Records are read
 * in the order of the tree, in which neither is cached. */
static inline void source_prefetch_indices(const struct source *source, uint32_t primitive)
{
    if (source->indices)
        __builtin_prefetch(source->indices + (uint64_t)primitive * 3 * source->index_size);
}
void source_prefetch_vertices(const struct source *source, uint32_t primitive);
enum source_state source_dense(const struct source *source, uint32_t primitive,
                               struct dense_record *record);
bool sphere_formats_are_known(const struct builder_spheres *spheres);
/* Returns the number of indices that `count` primitives consume or, without indices, the number of
 * vertices and radii. */
uint64_t sphere_element_count(const struct builder_spheres *spheres, bool is_swept, uint32_t count);
/* Returns the number of vertices and radii that a range reaches from its firstVertex on, or 0 if
 * the indices are not readable. */
uint64_t sphere_vertex_count(const struct builder_spheres *spheres, bool is_swept,
                             const VkAccelerationStructureBuildRangeInfoKHR *range);
enum source_state source_sphere(const struct source *source, uint32_t primitive,
                                struct sphere_record *record);
enum source_state source_swept(const struct source *source, uint32_t primitive,
                               struct swept_record *record);
enum source_state source_aabb(const struct source *source, uint32_t primitive,
                              struct aabb_record *record);
/* Fills the instance but not its inverse. Returns SOURCE_INACTIVE if the reference is 0. */
enum source_state source_instance(const struct source *source, uint32_t primitive,
                                  const struct builder_memory *memory,
                                  struct instance_record *record);
/* Returns the data size of a motion instance in bytes, or 0 if the type is invalid. */
uint64_t source_motion_size(uint32_t type);
enum source_state source_motion_instance(const struct source *source, uint32_t primitive,
                                         const struct builder_memory *memory,
                                         struct motion_instance_record *record);

#endif
