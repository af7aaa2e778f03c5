/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of the reference builder share. */
#include "tests/builder/fixture.h"
#include "src/platform/aligned.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const float fixture_triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* What fixture_scope_end() frees. */
static struct {
    void **allocations;
    size_t count, capacity;
    bool is_open;
} scope;

static void *check_memory(void *bytes, uint64_t size)
{
    if (!bytes) {
        fprintf(stderr, "out of memory: %llu bytes\n", (unsigned long long)size);
        exit(1);
    }
    return bytes;
}

void fixture_scope_begin(void)
{
    scope.is_open = true;
}

void fixture_scope_end(void)
{
    for (size_t i = 0; i < scope.count; i++)
        aligned_free(scope.allocations[i]);
    free(scope.allocations);
    memset(&scope, 0, sizeof(scope));
}

static void *scope_add(void *bytes)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    if (!scope.is_open)
        return bytes;
    pthread_mutex_lock(&lock);
    if (scope.count == scope.capacity) {
        scope.capacity = 2 * scope.capacity + 16;
        uint64_t size = scope.capacity * sizeof(*scope.allocations);
        scope.allocations = check_memory(realloc(scope.allocations, size), size);
    }
    scope.allocations[scope.count++] = bytes;
    pthread_mutex_unlock(&lock);
    return bytes;
}

/* The caller frees the bytes, even in a scope. */
static void *allocate(uint64_t size)
{
    size = (size + BUILDER_ALIGNMENT - 1) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
    void *bytes = aligned_allocate(BUILDER_ALIGNMENT, size > 0 ? size : BUILDER_ALIGNMENT);
    return memset(check_memory(bytes, size), 0, size > 0 ? size : BUILDER_ALIGNMENT);
}

void *fixture_allocate(uint64_t size)
{
    return scope_add(allocate(size));
}

struct fixture_mesh fixture_mesh_make(uint32_t vertices, uint32_t triangles)
{
    return (struct fixture_mesh){fixture_allocate((uint64_t)vertices * 12),
                                 fixture_allocate((uint64_t)triangles * 12), vertices, triangles};
}

void fixture_mesh_free(struct fixture_mesh *mesh)
{
    aligned_free(mesh->positions);
    aligned_free(mesh->indices);
}

void fixture_put_bits(uint8_t *bytes, uint32_t at, uint32_t count, uint32_t value)
{
    for (uint32_t i = 0; i < count; i++, at++) {
        bytes[at / 8] &= (uint8_t) ~(1u << at % 8);
        bytes[at / 8] |= (uint8_t)((value >> i & 1) << at % 8);
    }
}

uint64_t fixture_random(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 0x2545f4914f6cdd1du;
}

float fixture_uniform(uint64_t *state, float low, float high)
{
    return low + (high - low) * ((float)(fixture_random(state) >> 40) * 0x1p-24f);
}

/* The number of lattice point (x, y, z) of a cube's surface: points are found in a table, so that
 * faces share those of their edges. */
static uint32_t sphere_vertex(struct fixture_mesh *mesh, uint32_t *table, uint32_t side,
                              const uint32_t at[3], float radius, const float center[3])
{
    uint64_t row = side + 1;
    uint32_t *entry = &table[(at[0] * row + at[1]) * row + at[2]];
    if (*entry == 0) {
        double p[3], length = 0;
        for (int i = 0; i < 3; i++) {
            p[i] = tan((2.0 * at[i] / side - 1) * 0.785398163397448);
            length += p[i] * p[i];
        }
        for (int i = 0; i < 3; i++)
            mesh->positions[3 * mesh->vertex_count + i] =
                (float)(center[i] + radius * p[i] / sqrt(length));
        *entry = ++mesh->vertex_count;
    }
    return *entry - 1;
}

struct fixture_mesh fixture_sphere(uint32_t side, float radius, const float center[3])
{
    struct fixture_mesh mesh = fixture_mesh_make(6 * side * side + 2, 12 * side * side);
    uint64_t row = side + 1;
    uint32_t *table = allocate(row * row * row * sizeof(*table)), *to = mesh.indices;
    mesh.vertex_count = 0;
    for (uint32_t square = 0; square < 6 * side * side; square++) {
        uint32_t face = square / (side * side), u = square / side % side, v = square % side;
        uint32_t axis = face / 2, is_top = face % 2, corner[4];
        for (uint32_t i = 0; i < 4; i++) {
            uint32_t at[3];
            at[axis] = is_top ? side : 0;
            at[(axis + 1) % 3] = u + (i == 1 || i == 2);
            at[(axis + 2) % 3] = v + (i >= 2);
            corner[i] = sphere_vertex(&mesh, table, side, at, radius, center);
        }
        uint32_t second = is_top ? 1 : 3, fourth = is_top ? 3 : 1;
        uint32_t order[6] = {0, second, 2, 0, 2, fourth};
        for (int i = 0; i < 6; i++)
            *to++ = corner[order[i]];
    }
    free(table);
    return mesh;
}

struct fixture_mesh fixture_terrain(uint32_t side)
{
    struct fixture_mesh mesh = fixture_mesh_make((side + 1) * (side + 1), 2 * side * side);
    float *position = mesh.positions;
    uint32_t *to = mesh.indices;
    for (uint32_t i = 0; i <= side; i++)
        for (uint32_t j = 0; j <= side; j++) {
            float x = 100.0f * (float)i / (float)side, y = 100.0f * (float)j / (float)side;
            *position++ = x;
            *position++ = y;
            *position++ = 5 * sinf(x / 9) * cosf(y / 7) + sinf(x * 1.3f + y) + 0.2f * sinf(9 * y);
        }
    for (uint32_t i = 0; i < side; i++)
        for (uint32_t j = 0; j < side; j++) {
            uint32_t a = i * (side + 1) + j, b = a + side + 1;
            uint32_t order[6] = {a, b, b + 1, a, b + 1, a + 1};
            memcpy(to, order, sizeof(order));
            to += 6;
        }
    return mesh;
}

struct fixture_mesh fixture_soup(uint32_t triangles, uint64_t seed)
{
    struct fixture_mesh mesh = fixture_mesh_make(3 * triangles, triangles);
    for (uint32_t i = 0; i < 3 * triangles; i++)
        mesh.indices[i] = i;
    for (uint32_t i = 0; i < triangles; i++) {
        float size = 3 * powf(fixture_uniform(&seed, 0.1f, 1), 3);
        for (int axis = 0; axis < 3; axis++) {
            float center = fixture_uniform(&seed, 0, 100);
            for (int corner = 0; corner < 3; corner++)
                mesh.positions[9 * i + 3 * corner + axis] =
                    center + fixture_uniform(&seed, -size, size);
        }
    }
    return mesh;
}

static const void *find_address(void *context, uint64_t reference)
{
    (void)context;
    return (const void *)(uintptr_t)reference; // NOLINT(performance-no-int-to-ptr)
}

struct builder_resolver fixture_resolver(void)
{
    return (struct builder_resolver){find_address, NULL};
}

static void make_input(struct fixture_input *input, VkGeometryTypeKHR type, uint32_t count)
{
    *input = (struct fixture_input){.geometry = {.type = type}, .range = {.primitiveCount = count}};
    input->input = (struct builder_input){
        .type = type == VK_GEOMETRY_TYPE_INSTANCES_KHR
                    ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                    : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .quality = BUILDER_BALANCED,
        .geometry_count = 1,
        .geometries = &input->geometry,
        .ranges = &input->range,
        .resolver = fixture_resolver(),
        .micromaps = fixture_resolver(),
    };
}

void fixture_input_mesh(struct fixture_input *input, const struct fixture_mesh *mesh)
{
    make_input(input, VK_GEOMETRY_TYPE_TRIANGLES_KHR, mesh->triangle_count);
    input->geometry.triangles = (struct builder_triangles){
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .index_type = VK_INDEX_TYPE_UINT32,
        .max_vertex = mesh->vertex_count - 1,
        .vertex_stride = 12,
        .vertices = mesh->positions,
        .indices = mesh->indices,
        .vertices_size = (uint64_t)mesh->vertex_count * 12,
        .indices_size = (uint64_t)mesh->triangle_count * 12,
    };
}

void fixture_input_triangles(struct fixture_input *input, const float *corners, uint32_t triangles)
{
    make_input(input, VK_GEOMETRY_TYPE_TRIANGLES_KHR, triangles);
    input->geometry.triangles = (struct builder_triangles){
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .index_type = VK_INDEX_TYPE_NONE_KHR,
        .max_vertex = triangles > 0 ? 3 * triangles - 1 : 0,
        .vertex_stride = 12,
        .vertices = corners,
        .vertices_size = (uint64_t)triangles * 36,
    };
}

void fixture_input_aabbs(struct fixture_input *input, const VkAabbPositionsKHR *boxes,
                         uint32_t count)
{
    make_input(input, VK_GEOMETRY_TYPE_AABBS_KHR, count);
    input->geometry.aabbs =
        (struct builder_aabbs){boxes, (uint64_t)count * sizeof(*boxes), sizeof(*boxes)};
}

void fixture_input_spheres(struct fixture_input *input, VkGeometryTypeKHR type, uint32_t primitives,
                           const float *centers, const float *radii, uint32_t vertices)
{
    make_input(input, type, primitives);
    input->geometry.spheres = (struct builder_spheres){
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .radius_format = VK_FORMAT_R32_SFLOAT,
        .index_type = VK_INDEX_TYPE_NONE_KHR,
        .vertices = centers,
        .radii = radii,
        .vertices_size = (uint64_t)vertices * 12,
        .radii_size = (uint64_t)vertices * 4,
        .vertex_stride = 12,
        .radius_stride = 4,
        .end_caps_mode = VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV,
    };
}

void fixture_input_instances(struct fixture_input *input,
                             const VkAccelerationStructureInstanceKHR *instances, uint32_t count)
{
    make_input(input, VK_GEOMETRY_TYPE_INSTANCES_KHR, count);
    input->geometry.instances =
        (struct builder_instances){instances, (uint64_t)count * sizeof(*instances), false};
}

void fixture_input_transform(struct fixture_input *input, const VkTransformMatrixKHR *transform)
{
    input->geometry.triangles.transforms = transform;
    input->geometry.triangles.transforms_size = sizeof(*transform);
}

void fixture_input_motion(struct fixture_input *input, const float *vertices)
{
    input->input.flags |= VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    input->geometry.triangles.motion_vertices = vertices;
    input->geometry.triangles.motion_vertices_size = input->geometry.triangles.vertices_size;
}

VkAccelerationStructureInstanceKHR fixture_instance(const void *blas)
{
    return (VkAccelerationStructureInstanceKHR){
        .transform = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
        .mask = 0xff,
        .accelerationStructureReference = (uintptr_t)blas,
    };
}

/* Bytes after a block of memory that must stay as they are. */
enum { GUARD = 64, GUARDED = 0xa5 };

static void *allocate_guarded(uint64_t size)
{
    uint8_t *bytes = allocate(size + GUARD);
    memset(bytes + size, GUARDED, GUARD);
    return bytes;
}

static void check_guard(const void *block, uint64_t size)
{
    const uint8_t *end = (const uint8_t *)block + size;
    for (int i = 0; i < GUARD; i++)
        if (end[i] != GUARDED) {
            fprintf(stderr, "the builder writes beyond %llu bytes\n", (unsigned long long)size);
            abort();
        }
}

void *fixture_build(const struct builder_input *input, struct builder_report *report)
{
    struct builder_sizes sizes;
    if (builder_get_sizes(input, NULL, &sizes) != BUILDER_OK)
        return NULL;
    void *structure = allocate_guarded(sizes.structure),
         *scratch = allocate_guarded(sizes.build_scratch);
    enum builder_result result =
        builder_build(input, structure, sizes.structure, scratch, sizes.build_scratch, report);
    check_guard(structure, sizes.structure);
    check_guard(scratch, sizes.build_scratch);
    aligned_free(scratch);
    if (result == BUILDER_OK)
        return scope_add(structure);
    aligned_free(structure);
    return NULL;
}

enum builder_result fixture_refit(const struct builder_input *input, const void *source,
                                  void *target, struct builder_report *report)
{
    struct builder_sizes sizes;
    enum builder_result result = builder_get_sizes(input, NULL, &sizes);
    if (result != BUILDER_OK)
        return result;
    void *scratch = allocate_guarded(sizes.update_scratch);
    result = builder_refit(input, source, target, builder_size(source), scratch,
                           sizes.update_scratch, report);
    check_guard(scratch, sizes.update_scratch);
    aligned_free(scratch);
    return result;
}

struct trace_ray fixture_ray(float x, float y, float z, float dx, float dy, float dz)
{
    return (struct trace_ray){
        .origin = {x, y, z}, .direction = {dx, dy, dz}, .t_max = INFINITY, .cull_mask = 0xff};
}

static enum trace_answer count_hit(void *context, struct trace_hit *candidate)
{
    struct fixture_hits *hits = context;
    if (hits->count < sizeof(hits->hits) / sizeof(hits->hits[0]))
        hits->hits[hits->count] = *candidate;
    hits->count++;
    return TRACE_IGNORE;
}

static struct trace_scene scene_of(const void *structure, enum trace_accuracy accuracy)
{
    return (struct trace_scene){.structure = structure,
                                .accuracy = accuracy,
                                .resolver = fixture_resolver(),
                                .micromaps = fixture_resolver()};
}

void fixture_trace_all(const void *structure, enum trace_accuracy accuracy,
                       const struct trace_ray *ray, struct fixture_hits *hits)
{
    struct trace_scene scene = scene_of(structure, accuracy);
    struct trace_visitor visitor = {count_hit, hits};
    hits->count = 0;
    trace_candidates(&scene, ray, &visitor);
}

bool fixture_trace(const void *structure, enum trace_accuracy accuracy, const struct trace_ray *ray,
                   struct trace_hit *hit)
{
    struct trace_scene scene = scene_of(structure, accuracy);
    return trace_closest(&scene, ray, hit);
}
