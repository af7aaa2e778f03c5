/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of the reference builder share: meshes, inputs made of them, and built structures. */
#ifndef ASSAY_TESTS_BUILDER_KIT_H
#define ASSAY_TESTS_BUILDER_KIT_H

#include "src/bvh/bvh.h"
#include "src/bvh/trace.h"

struct kit_mesh {
    float *positions;  /* three a vertex */
    uint32_t *indices; /* three a triangle */
    uint32_t vertex_count, triangle_count;
};

struct kit_mesh kit_mesh_make(uint32_t vertices, uint32_t triangles);
void kit_mesh_free(struct kit_mesh *mesh);
/* A closed sphere without poles' slivers: a cube of side * side squares a face, blown up. Has
 * 12 * side * side triangles and every vertex once. */
struct kit_mesh kit_sphere(uint32_t side, float radius, const float center[3]);
/* Squares with hills; twice side * side triangles. */
struct kit_mesh kit_terrain(uint32_t side);
/* Separate triangles of random size in a cube of size 100. */
struct kit_mesh kit_soup(uint32_t triangles, uint64_t seed);

/* xorshift64*; never 0 as a state */
uint64_t kit_random(uint64_t *state);
float kit_uniform(uint64_t *state, float low, float high);

/* An input of one geometry and all its parts, in one place that must not move. */
struct kit_input {
    struct builder_geometry geometry;
    VkAccelerationStructureBuildRangeInfoKHR range;
    struct builder_input input;
};
void kit_input_mesh(struct kit_input *input, const struct kit_mesh *mesh);
void kit_input_triangles(struct kit_input *input, const float *corners, uint32_t triangles);
void kit_input_aabbs(struct kit_input *input, const VkAabbPositionsKHR *boxes, uint32_t count);
/* References are addresses of structures. */
void kit_input_instances(struct kit_input *input,
                         const VkAccelerationStructureInstanceKHR *instances, uint32_t count);
VkAccelerationStructureInstanceKHR kit_instance(const void *blas); /* identity, mask 0xff */

/* Zeroed bytes with the alignment that structures want. Exits where there are none. */
void *kit_allocate(uint64_t size);

/* Builds into memory of the size that the builder asks for; NULL after an error. The caller frees.
 */
void *kit_build(const struct builder_input *input, struct builder_report *report);

struct builder_resolver kit_resolver(void); /* references are addresses */

struct kit_hits {
    uint32_t count;
    struct trace_hit hits[64]; /* the first of them */
};
void kit_trace_all(const void *structure, enum trace_accuracy accuracy, const struct trace_ray *ray,
                   struct kit_hits *hits);
bool kit_trace(const void *structure, enum trace_accuracy accuracy, const struct trace_ray *ray,
               struct trace_hit *hit);

#endif
