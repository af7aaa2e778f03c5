/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 22 to 27 and 29 to 31: directions with zeros, edges and vertices, the ends of rays. */
#include <math.h>
#include <string.h>

#include "cases.h"

/* A sphere at the origin, as three corners a triangle. */
struct sphere {
    float *corners;
    uint32_t count;
    void *structure;
};

static struct sphere build_sphere(uint32_t side)
{
    struct fixture_mesh mesh = fixture_sphere(side, 1, (float[3]){0, 0, 0});
    float *corners = fixture_allocate((uint64_t)mesh.triangle_count * 36);
    for (uint32_t i = 0; i < 3 * mesh.triangle_count; i++)
        memcpy(corners + 3 * (size_t)i, mesh.positions + 3 * (size_t)mesh.indices[i], 12);
    return (struct sphere){corners, mesh.triangle_count,
                           case_triangles(corners, mesh.triangle_count)};
}

CASE(22, 0, 0, "zeros in the direction", "axis")
{
    const struct sphere sphere = build_sphere(3);
    uint64_t random = 37;
    for (int i = 0; i < 24; i++) {
        int axis = i % 3;
        struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
        case_uniform(&random, -0.4f, 0.4f, ray.origin);
        for (int j = 0; j < 3; j++)
            ray.direction[j] = i % 2 ? -0.0f : 0.0f;
        ray.direction[axis] = i % 4 < 2 ? 1 : -1;
        if (i >= 12)
            ray.direction[(axis + 1) % 3] = 0.5f;
        case_check_ray(sphere.structure, sphere.corners, sphere.count, ray);
    }
}

/* Where the matrix puts what is at `at`. */
static void place(const VkTransformMatrixKHR *transform, float at[3])
{
    const float from[3] = {at[0], at[1], at[2]};
    for (int i = 0; i < 3; i++) {
        const float *row = transform->matrix[i];
        at[i] = row[0] * from[0] + row[1] * from[1] + row[2] * from[2] + row[3];
    }
}

/* From inside a closed mesh through points of its edges, or its vertices: one triangle each. With a
 * matrix the mesh is an instance, and the rays are aimed where it puts the vertices. */
static void shoot_closed(bool at_vertex, float far, const VkTransformMatrixKHR *transform)
{
    float center[3] = {far + 0.1f, far + 0.2f, far + 0.3f};
    struct fixture_mesh mesh = fixture_sphere(3, 1, center);
    uint64_t random = 41;
    void *structure = case_mesh(&mesh);
    if (transform) {
        VkAccelerationStructureInstanceKHR instance = fixture_instance(structure);
        instance.transform = *transform;
        structure = case_instances(&instance, 1);
        place(transform, center);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            place(transform, mesh.positions + 3 * (size_t)i);
    }
    for (uint32_t i = 0; i < 3 * mesh.triangle_count; i++) {
        const float *a = mesh.positions + 3 * (size_t)mesh.indices[i];
        const float *b = mesh.positions + 3 * (size_t)mesh.indices[i - i % 3 + (i + 1) % 3];
        float along = at_vertex ? 0 : 0.5f, origin[3], target[3];
        for (int j = 0; j < 3; j++) {
            origin[j] = center[j] + (i % 2 ? 0 : fixture_uniform(&random, -0.4f, 0.4f));
            target[j] = a[j] + along * (b[j] - a[j]);
        }
        EXPECT(case_count(structure, case_ray_to(origin, target)) == 1);
    }
}

static void shoot_closed_meshes(bool at_vertex)
{
    static const VkTransformMatrixKHR turned = {
        {{1.2f, -2.1f, 0.3f, 5}, {1.7f, 0.9f, -0.4f, -70}, {0.2f, 0.6f, 0.8f, 300}}};
    shoot_closed(at_vertex, 0, NULL);
    shoot_closed(at_vertex, 1000, NULL);
    shoot_closed(at_vertex, 0, &turned);
}

CASE(23, 550, 380, "shared edge", "shared edges")
{
    shoot_closed_meshes(false);
}

CASE(24, 820, 950, "vertex of a closed fan", "vertices")
{
    shoot_closed_meshes(true);
    /* Eight triangles around the origin, on a grid where every tie is exact. */
    float corners[72];
    const float ring[9][2] = {{1, 0},   {1, 1},  {0, 1},  {-1, 1}, {-1, 0},
                              {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    for (int i = 0; i < 8; i++) {
        float one[9] = {0, 0, 0, ring[i][0], ring[i][1], 0, ring[i + 1][0], ring[i + 1][1], 0};
        memcpy(corners + (size_t)9 * i, one, sizeof(one));
    }
    void *structure = case_triangles(corners, 8);
    for (int i = 0; i < 25; i++) {
        int column = i % 5 - 2, row = i / 5 - 2;
        float x = (float)column / 4, y = (float)row / 4;
        EXPECT(case_count(structure, case_ray_down(x, y)) == 1);
        EXPECT(case_count(structure, fixture_ray(x + 0.5f, y - 0.25f, -1, -0.5f, 0.25f, 1)) == 1);
    }
}

CASE(25, 0, 0, "open boundary", "open edges")
{
    void *structure = case_triangles(fixture_triangle, 1);
    for (int i = 0; i <= 8; i++) {
        const struct fixture_hits hits =
            case_hits(structure, fixture_ray((float)i / 8, 0, 1, 0, 0, -1));
        EXPECT(hits.count <= 1 && (hits.count == 0 || hits.hits[0].t == 1));
    }
}

CASE(26, 0, 0, "origin on the surface", "surface")
{
    void *structure = case_triangles(fixture_triangle, 1);
    EXPECT(!case_meets(structure, fixture_ray(0.25f, 0.25f, 0, 0, 0, -1)));
    EXPECT(!case_meets(structure, fixture_ray(0.25f, 0.25f, 0, 1, 0.5f, 0.25f)));
}

CASE(27, 0, 0, "t equal to tmin or tmax", "surface")
{
    void *structure = case_triangles(fixture_triangle, 1);
    for (int i = 0; i < 5; i++) {
        float t = (float[]){1, 2, 0.5f, 1024, 0x1p-20f}[i];
        const struct trace_ray ray = fixture_ray(0.25f, 0.25f, t, 0, 0, -1);
        EXPECT(!case_meets(structure, case_between(ray, t, INFINITY)));
        EXPECT(case_closest(structure, case_between(ray, nextafterf(t, 0), INFINITY)).t == t);
        EXPECT(!case_meets(structure, case_between(ray, 0, t)));
        EXPECT(case_closest(structure, case_between(ray, 0, nextafterf(t, INFINITY))).t == t);
    }
    /* On an edge, which the ray does not meet, or meets in double precision. */
    const struct trace_ray edge = fixture_ray(0.25f, 0, 1, 0, 0, -1);
    EXPECT(!case_meets(structure, case_between(edge, 1, INFINITY)));
    EXPECT(!case_meets(structure, case_between(edge, 0, 1)));
}

CASE(29, 1000, 0, "tmax infinite", "products of coordinates overflow")
{
    float far[9] = {-1e30f, -1e30f, 1e30f, 3e30f, -1e30f, 1e30f, -1e30f, 3e30f, 1e30f};
    void *structure = case_triangles(far, 1);
    struct trace_ray ray = fixture_ray(1, 2, 3, 0.25f, 0.125f, 1);
    EXPECT(case_check_ray(structure, far, 1, ray) == 1);
}

CASE(30, 0, 0, "direction scaled by 1e20 and 1e-20", "axis")
{
    const struct sphere sphere = build_sphere(3);
    uint64_t random = 43;
    for (int i = 0; i < 20; i++) {
        struct trace_ray ray = fixture_ray(0.1f, 0.2f, 0.1f, 0, 0, 0), scaled;
        case_uniform(&random, -1, 1, ray.direction);
        for (int j = 0; j < 4; j++) {
            float scale = (float[]){1e20f, 1e-20f, 0x1p60f, 0x1p-60f}[j];
            struct trace_hit hit, other;
            scaled = ray;
            for (int k = 0; k < 3; k++)
                scaled.direction[k] *= scale;
            case_check_ray(sphere.structure, sphere.corners, sphere.count, scaled);
            bool is_hit = case_trace(sphere.structure, ray, &hit);
            EXPECT(is_hit == case_trace(sphere.structure, scaled, &other));
            EXPECT(fabsf(other.t * scale - hit.t) <= (j < 2 ? 1e-5f : 0) * hit.t);
        }
    }
}

CASE(31, 90, 80, "origin far away", "far origin")
{
    const struct sphere sphere = build_sphere(2);
    uint64_t random = 47;
    for (int i = 0; i < 40; i++) {
        float far = i % 2 ? 1e7f : 1e8f;
        float origin[3] = {far, fixture_uniform(&random, -far, far),
                           fixture_uniform(&random, -far, far)};
        uint64_t triangle = fixture_random(&random) % sphere.count;
        struct trace_ray ray = case_ray_into(sphere.corners + 9 * triangle, origin, &random);
        case_check_ray(sphere.structure, sphere.corners, sphere.count, ray);
    }
}
