/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of the reference builder share: meshes, inputs made of them, and built structures. */
#ifndef ASSAY_TESTS_BUILDER_FIXTURE_H
#define ASSAY_TESTS_BUILDER_FIXTURE_H

#include "src/bvh/bvh.h"
#include "src/bvh/micromap.h"
#include "src/bvh/trace.h"

extern const float fixture_triangle[9]; /* (0, 0), (1, 0), (0, 1) in the plane z = 0 */

/* fixture_scope_end() frees all that the fixture has allocated since fixture_scope_begin(), and the
 * caller frees nothing of that. */
void fixture_scope_begin(void);
void fixture_scope_end(void);
/* A test (tests/unit/unit_test.h) between the two. */
#define SCOPE_TEST(name) TEST_BETWEEN(name, fixture_scope_begin, fixture_scope_end)

struct fixture_mesh {
    float *positions;  /* three a vertex */
    uint32_t *indices; /* three a triangle */
    uint32_t vertex_count, triangle_count;
};

struct fixture_mesh fixture_mesh_make(uint32_t vertices, uint32_t triangles);
void fixture_mesh_free(struct fixture_mesh *mesh);
/* A closed sphere without poles' slivers: a cube of side * side squares a face, blown up. Has
 * 12 * side * side triangles and every vertex once. */
struct fixture_mesh fixture_sphere(uint32_t side, float radius, const float center[3]);
/* Squares with hills; twice side * side triangles. */
struct fixture_mesh fixture_terrain(uint32_t side);
/* Separate triangles of random size in a cube of size 100. */
struct fixture_mesh fixture_soup(uint32_t triangles, uint64_t seed);

/* Writes the lowest bits of a value, `at` bits into the bytes. */
void fixture_put_bits(uint8_t *bytes, uint32_t at, uint32_t count, uint32_t value);

/* xorshift64*; never 0 as a state */
uint64_t fixture_random(uint64_t *state);
float fixture_uniform(uint64_t *state, float low, float high);

/* An input of one geometry and all its parts, in one place that must not move. */
struct fixture_input {
    struct builder_geometry geometry;
    VkAccelerationStructureBuildRangeInfoKHR range;
    struct builder_input input;
};
/* Declares an input of one kind and fills it in: INPUT(mesh, input, &mesh). */
#define INPUT(kind, name, ...)                                                                     \
    struct fixture_input name;                                                                     \
    fixture_input_##kind(&(name), __VA_ARGS__)
void fixture_input_mesh(struct fixture_input *input, const struct fixture_mesh *mesh);
void fixture_input_triangles(struct fixture_input *input, const float *corners, uint32_t triangles);
void fixture_input_aabbs(struct fixture_input *input, const VkAabbPositionsKHR *boxes,
                         uint32_t count);
/* Spheres, or swept ones, without indices: three floats a center and one a radius. */
void fixture_input_spheres(struct fixture_input *input, VkGeometryTypeKHR type, uint32_t primitives,
                           const float *centers, const float *radii, uint32_t vertices);
/* References are addresses of structures. */
void fixture_input_instances(struct fixture_input *input,
                             const VkAccelerationStructureInstanceKHR *instances, uint32_t count);
void fixture_input_transform(struct fixture_input *input, const VkTransformMatrixKHR *transform);
/* Vertices of time 1, as many as the input has of time 0. */
void fixture_input_motion(struct fixture_input *input, const float *vertices);
VkAccelerationStructureInstanceKHR fixture_instance(const void *blas); /* identity, mask 0xff */

/* Zeroed bytes with the alignment that structures want. Exits where there are none. */
void *fixture_allocate(uint64_t size);

/* Builds into memory of the size that the builder asks for; NULL after an error. The caller frees.
 */
void *fixture_build(const struct builder_input *input, struct builder_report *report);

/* Updates `source` into `target`, of the same size, with the scratch that the builder asks for. */
enum builder_result fixture_refit(const struct builder_input *input, const void *source,
                                  void *target, struct builder_report *report);

/* Returns the input of a micromap whose triangles lie one behind the other in memory. */
struct micromap_input fixture_micromap_input(VkMicromapTypeEXT type, uint32_t usage_count,
                                             const VkMicromapUsageEXT *usages, const void *data,
                                             uint64_t data_size, uint32_t triangle_count,
                                             const VkMicromapTriangleEXT *triangles);
void *fixture_micromap(const struct micromap_input *input); /* aborts after an error */

struct builder_resolver fixture_resolver(void); /* references are addresses */

/* Without an end, for all instances. */
struct trace_ray fixture_ray(float x, float y, float z, float dx, float dy, float dz);

struct fixture_hits {
    uint32_t count;
    struct trace_hit hits[64]; /* the first of them */
};
void fixture_trace_all(const void *structure, enum trace_accuracy accuracy,
                       const struct trace_ray *ray, struct fixture_hits *hits);
bool fixture_trace(const void *structure, enum trace_accuracy accuracy, const struct trace_ray *ray,
                   struct trace_hit *hit);

#endif
