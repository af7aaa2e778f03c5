/* SPDX-License-Identifier: Apache-2.0 */
/* Where a geometry's primitives are read from: Vulkan's ranges resolved to pointers and limits. */
#ifndef ASSAY_BVH_INPUT_SOURCE_H
#define ASSAY_BVH_INPUT_SOURCE_H

#include "src/bvh/bvh.h"
#include "src/bvh/input/formats.h"
#include "src/bvh/structure.h"

/* What reading a primitive found. */
enum source_state {
    SOURCE_ACTIVE,
    SOURCE_INACTIVE,
    SOURCE_UNDEFINED,    /* NaN in Y or Z alone; not used */
    SOURCE_OUT_OF_RANGE, /* not read */
    SOURCE_UNRESOLVED,   /* an instance of nothing that the resolver knows */
};

/* A triangle of dense geometry, decoded. */
struct dense_triangle {
    float a[3], b[3], c[3];
    uint32_t geometry, primitive;
    uint32_t is_opaque;
    enum source_state found;
};

struct displaced_point {
    float at[3];
};

/* A triangle of which others are parts, and what it is made of. */
struct displaced_base {
    uint32_t first; /* of its parts, counted in its geometry; one where it isn't active */
    uint32_t point; /* the first of its vertices (displacement.h has their order) */
    uint8_t level, edges, found; /* the latter: enum source_state */
};

/* Where each triangle's number in a micromap is. */
struct micromap_indices {
    const uint8_t *indices; /* NULL: none */
    uint64_t stride;
    uint32_t index_size, base;
    bool is_present;
};

struct source {
    uint32_t first; /* of the structure's primitives, all geometries counted on */
    uint32_t count; /* parts of triangles, where these are displaced */
    /* triangles */
    const struct vertex_format *format;
    const uint8_t *vertices; /* of index 0, offset and first vertex included */
    const uint8_t *indices;  /* NULL: none */
    uint64_t stride;         /* of vertices, AABBs or instances */
    uint64_t index_limit;    /* indices below it may be read */
    uint32_t index_size;
    struct micromap_indices opacity;
    const uint8_t
        *motion_vertices;         /* at time 1, of index 0 and as readable as `vertices`; or NULL */
    bool has_transform, is_plain; /* plain: float positions as they are, 32-bit indices */
    VkTransformMatrixKHR transform;
    struct sphere_source { /* spheres, swept or not: beside format, vertices, indices and limit */
        const uint8_t *radii;
        uint64_t radius_stride, index_stride;
        bool is_half, is_successive, has_caps;
    } spheres;
    const struct dense_triangle *dense;
    uint32_t max_primitive; /* of dense geometry */
    /* of structures with displaced triangles */
    const struct displaced_base *bases;
    const struct displaced_point *points, *motion_points; /* at times 0 and 1 */
    uint32_t base_count;
    /* AABBs and instances */
    const uint8_t *data;
    bool is_pointer_array, has_motion;
};

/* False where the range itself leads out of the data. `geometry` is of the structure's kind and of
 * a known format. */
bool source_open(struct source *source, bool has_motion, const struct builder_geometry *geometry,
                 const VkAccelerationStructureBuildRangeInfoKHR *range);

bool source_open_spheres(struct source *source, const struct builder_spheres *spheres,
                         bool is_swept, const VkAccelerationStructureBuildRangeInfoKHR *range);

bool source_open_instances(struct source *source, const struct builder_instances *instances,
                           const VkAccelerationStructureBuildRangeInfoKHR *range);
/* False where the range's elements don't lie in the data. */
bool source_open_array(struct source *source, const void *data, uint64_t size, uint64_t element,
                       uint64_t stride, const VkAccelerationStructureBuildRangeInfoKHR *range);

/* How many elements of `size` bytes at `stride` lie in `room` bytes. */
uint64_t source_elements_in(uint64_t room, uint64_t size, uint64_t stride);
uint32_t source_index_bytes(VkIndexType type); /* 0: no such type, or none */
bool source_index_is_known(VkIndexType type);
uint32_t source_read_number(const uint8_t *from, uint32_t size);

/* The numbers of a triangle's vertices; false where one is out of range. */
bool source_corners(const struct source *source, uint32_t primitive, uint64_t index[3]);
/* In double, so that each component is rounded twice only, and overflows only where the result
 * does. Same vertex, same result: what shared a vertex still does. */
void source_transform(const VkTransformMatrixKHR *transform, const double from[3], float to[3]);
enum source_state source_triangle(const struct source *source, uint32_t primitive,
                                  struct triangle_record *record);
/* Inactive where it is so at either time. */
enum source_state source_motion_triangle(const struct source *source, uint32_t primitive,
                                         struct motion_triangle_record *record);
/* False where the indices of `count` triangles can't be read. */
bool source_open_indices(struct micromap_indices *indices, VkIndexType type, uint32_t base,
                         const void *data, uint64_t size, uint64_t stride, uint64_t count);
/* Of a triangle, without the base; special indices as the greatest numbers. */
#define SOURCE_SPECIAL UINT64_C(0xfffffffffffffffc) /* the least of them */
uint64_t source_micromap_index(const struct micromap_indices *indices, uint32_t primitive);
/* What its record says of opacity, where the source has any. */
uint32_t source_opacity(const struct source *source, uint32_t primitive);
/* Asks for the memory of a triangle that is read soon: its indices, later its vertices. Records
 * come in the tree's order, in which caches find neither. */
static inline void source_prefetch_indices(const struct source *source, uint32_t primitive)
{
    if (source->indices)
        __builtin_prefetch(source->indices + (uint64_t)primitive * 3 * source->index_size);
}
void source_prefetch_vertices(const struct source *source, uint32_t primitive);
enum source_state source_dense(const struct source *source, uint32_t primitive,
                               struct dense_record *record);
bool sphere_formats_are_known(const struct builder_spheres *spheres);
/* How many indices that many primitives consume, or, without indices, vertices and radii. */
uint64_t sphere_element_count(const struct builder_spheres *spheres, bool is_swept, uint32_t count);
/* How many vertices and radii those of a range reach, from its firstVertex on; 0 where indices
 * can't be read. */
uint64_t sphere_vertex_count(const struct builder_spheres *spheres, bool is_swept,
                             const VkAccelerationStructureBuildRangeInfoKHR *range);
enum source_state source_sphere(const struct source *source, uint32_t primitive,
                                struct sphere_record *record);
enum source_state source_swept(const struct source *source, uint32_t primitive,
                               struct swept_record *record);
enum source_state source_aabb(const struct source *source, uint32_t primitive,
                              struct aabb_record *record);
/* Fills the instance, not its inverse; SOURCE_INACTIVE where the reference is 0. */
enum source_state source_instance(const struct source *source, uint32_t primitive,
                                  const struct builder_memory *memory,
                                  struct instance_record *record);
/* Bytes of the data of a motion instance of a type; 0 for what is no type. */
uint64_t source_motion_size(uint32_t type);
enum source_state source_motion_instance(const struct source *source, uint32_t primitive,
                                         const struct builder_memory *memory,
                                         struct motion_instance_record *record);

#endif
