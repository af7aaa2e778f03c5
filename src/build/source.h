/* SPDX-License-Identifier: Apache-2.0 */
/* Where a geometry's primitives are read from: Vulkan's ranges resolved to pointers and limits. */
#ifndef ASSAY_BUILD_SOURCE_H
#define ASSAY_BUILD_SOURCE_H

#include "build/build.h"
#include "build/formats.h"
#include "build/structure.h"

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

struct source {
    uint32_t first; /* of the structure's primitives, all geometries counted on */
    uint32_t count;
    /* triangles */
    const struct vertex_format *format;
    const uint8_t *vertices; /* of index 0, offset and first vertex included */
    const uint8_t *indices;  /* NULL: none */
    uint64_t stride;         /* of vertices, AABBs or instances */
    uint64_t index_limit;    /* indices below it may be read */
    uint32_t index_size;
    struct opacity_source {
        const uint8_t *indices; /* NULL: none */
        uint64_t stride;
        uint32_t index_size, base;
        bool is_present;
    } opacity;
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

enum source_state source_triangle(const struct source *source, uint32_t primitive,
                                  struct triangle_record *record);
/* Inactive where it is so at either time. */
enum source_state source_motion_triangle(const struct source *source, uint32_t primitive,
                                         struct motion_triangle_record *record);
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
