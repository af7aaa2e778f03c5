/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 59 to 61: spheres (VK_NV_ray_tracing_linear_swept_spheres). */
#include <math.h>

#include "cases.h"
#include "exact.h"

void sphere_list_describe(struct sphere_list *list, VkGeometryTypeKHR type, uint32_t primitives)
{
    fixture_input_triangles(&list->input, NULL, primitives);
    list->input.geometry.type = type;
    list->input.geometry.spheres = (struct builder_spheres){
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .radius_format = VK_FORMAT_R32_SFLOAT,
        .index_type = VK_INDEX_TYPE_NONE_KHR,
        .vertices = list->centers,
        .radii = list->radii,
        .vertices_size = (uint64_t)list->vertices * 12,
        .radii_size = (uint64_t)list->vertices * 4,
        .vertex_stride = 12,
        .radius_stride = 4,
        .end_caps_mode = VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV,
    };
}

static void *build_spheres(const float *centers, const float *radii, uint32_t count)
{
    struct sphere_list list = {.centers = centers, .radii = radii, .vertices = count};
    sphere_list_describe(&list, VK_GEOMETRY_TYPE_SPHERES_NV, count);
    return case_build(&list.input);
}

/* Many of all sizes; rays into them, beside them and along their silhouettes. */
CASE(59, 0, 0, "spheres")
{
    enum { COUNT = 40 };
    float centers[3 * COUNT], radii[COUNT];
    uint64_t random = 101;
    for (int i = 0; i < COUNT; i++) {
        radii[i] = ldexpf(fixture_uniform(&random, 0.5f, 1), i % 12 - 8);
        for (int j = 0; j < 3; j++)
            centers[3 * i + j] = fixture_uniform(&random, -20, 20);
    }
    void *structure = build_spheres(centers, radii, COUNT);
    for (int i = 0; i < 300; i++) {
        uint32_t target = (uint32_t)(fixture_random(&random) % COUNT);
        float far = i % 5 == 0 ? 1e5f : 30;
        struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
        for (int j = 0; j < 3; j++) {
            ray.origin[j] = fixture_uniform(&random, -far, far);
            ray.direction[j] = centers[3 * target + j] - ray.origin[j];
        }
        /* across the direction by about the radius, or less */
        int across = (int)(fixture_random(&random) % 3);
        ray.direction[across] += radii[target] * (i % 2 ? fixture_uniform(&random, -1, 1) : 1.01f);
        const struct fixture_hits hits = case_hits(structure, ray);
        uint32_t expected = 0;
        for (uint32_t j = 0; j < COUNT; j++) {
            struct exact_hit truth = exact_sphere(&ray, centers + 3 * j, radii[j]);
            const struct trace_hit *hit = NULL;
            for (uint32_t k = 0; k < hits.count && k < 64; k++)
                if (hits.hits[k].primitive == j)
                    hit = &hits.hits[k];
            EXPECT(truth.class == EXACT_BOUNDARY || (hit != NULL) == (truth.class == EXACT_INSIDE));
            if (hit && truth.class == EXACT_INSIDE)
                EXPECT(fabs(hit->t - truth.t) <= 0x1p-22 * truth.t && hit->is_sphere);
            expected += hit != NULL;
        }
        EXPECT(hits.count == expected);
    }
}

/* One step of a float decides. */
CASE(60, 0, 0, "silhouettes of spheres")
{
    const float center[3] = {0, 0, 0};
    for (int i = 0; i < 12; i++) {
        float radius = (float[]){1, 0.1f, 3e-20f, 1e15f}[i % 4];
        float off = i < 4 ? radius : nextafterf(radius, i < 8 ? 0 : INFINITY);
        void *structure = build_spheres(center, &radius, 1);
        struct trace_ray ray = fixture_ray(off, -5 * radius, 0, 0, 3, 0);
        struct trace_hit hit;
        bool is_hit = case_trace(structure, ray, &hit);
        EXPECT(i < 4 || is_hit == (i < 8));
    }
    /* an origin one step within, on and outside */
    const float one = 1;
    void *structure = build_spheres(center, &one, 1);
    for (int i = 0; i < 3; i++) {
        float x = (float[]){nextafterf(1, 0), 1, nextafterf(1, 2)}[i];
        struct trace_ray ray = fixture_ray(x, 0, 0, -1, 0, 0);
        struct trace_hit hit;
        bool is_hit = case_trace(structure, ray, &hit);
        EXPECT(is_hit == (i > 0) && (!is_hit || hit.t == x - 1));
    }
}

CASE(61, 0, 0, "what counts for spheres")
{
    const float centers[15] = {0, 0, 0, 5, 0, 0, 10, NAN, 0, 15, 0, 0, 20, 0, 0};
    const float radii[5] = {1, NAN, 1, -1, 0};
    struct sphere_list list = {.centers = centers, .radii = radii, .vertices = 5};
    sphere_list_describe(&list, VK_GEOMETRY_TYPE_SPHERES_NV, 5);
    list.input.geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    void *structure = case_build(&list.input);
    EXPECT(report.active == 2 && report.inactive == 3 && report.undefined == 1);
    struct trace_ray ray = fixture_ray(-3, 0, 0, 2, 0, 0);
    struct trace_hit hit;
    const struct fixture_hits hits = case_hits(structure, ray);
    EXPECT(hits.count >= 1 && hits.count <= 2); /* radius 0: either */
    EXPECT(case_trace(structure, ray, &hit) && hit.t == 1 && hit.opaque && hit.primitive == 0 &&
           hit.u == 0 && !hit.is_swept);
    EXPECT(case_meets(structure, case_between(ray, 0, 1))); /* both ends count */
    EXPECT(!case_meets(structure, case_between(ray, 0, nextafterf(1, 0))));
    /* where it leaves isn't met, also from within */
    EXPECT(!case_meets(structure, case_between(ray, nextafterf(1, 2), 1.9f)));
    EXPECT(!case_meets(structure, case_between(fixture_ray(0.5f, 0.5f, 0, 1, 0.1f, 0), 0, 3)));
    ray.flags = TRACE_SKIP_TRIANGLES;
    EXPECT(!case_meets(structure, ray));
    ray.flags = TRACE_SKIP_AABBS | TRACE_CULL_BACK_FACING | TRACE_CULL_FRONT_FACING;
    EXPECT(case_meets(structure, ray));
    ray.flags = TRACE_CULL_OPAQUE;
    EXPECT(!case_meets(structure, ray));
    /* A ray that touches it meets it; its neighbour does not. */
    ray = fixture_ray(-3, 1, 0, 2, 0, 0);
    EXPECT(case_trace(structure, ray, &hit) && hit.t == 1.5f);
    EXPECT(!case_meets(structure, fixture_ray(-3, nextafterf(1, 2), 0, 2, 0, 0)));
    /* seen through an instance, where it is an ellipsoid */
    VkAccelerationStructureInstanceKHR instance = fixture_instance(structure);
    instance.transform.matrix[0][0] = 2;
    void *tlas = case_instances(&instance, 1);
    ray = fixture_ray(-3, 0, 0, 1, 0, 0);
    EXPECT(case_trace(tlas, ray, &hit) && hit.t == 1 && hit.is_sphere);
}
