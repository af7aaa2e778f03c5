/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 59 to 61: spheres (VK_NV_ray_tracing_linear_swept_spheres). */
#include <math.h>

#include "cases.h"
#include "exact.h"

static void *build_spheres(const float *centers, const float *radii, uint32_t count)
{
    INPUT(spheres, input, VK_GEOMETRY_TYPE_SPHERES_NV, count, centers, radii, count);
    return case_build(&input);
}

/* Many of all sizes; rays into them, beside them and along their silhouettes. */
CASE(59, 0, 0, "spheres")
{
    enum { COUNT = 40 };
    float centers[3 * COUNT], radii[COUNT];
    uint64_t random = 101;
    for (int i = 0; i < COUNT; i++) {
        radii[i] = ldexpf(fixture_uniform(&random, 0.5f, 1), i % 12 - 8);
        case_uniform(&random, -20, 20, centers + 3 * (size_t)i);
    }
    void *structure = build_spheres(centers, radii, COUNT);
    for (int i = 0; i < 300; i++) {
        uint32_t target = (uint32_t)(fixture_random(&random) % COUNT);
        float far = i % 5 == 0 ? 1e5f : 30, origin[3];
        case_uniform(&random, -far, far, origin);
        struct trace_ray ray = case_ray_to(origin, centers + 3 * target);
        /* across the direction by about the radius, or less */
        int across = (int)(fixture_random(&random) % 3);
        ray.direction[across] += radii[target] * (i % 2 ? fixture_uniform(&random, -1, 1) : 1.01f);
        const struct fixture_hits hits = case_hits(structure, ray);
        uint32_t expected = 0;
        for (uint32_t j = 0; j < COUNT; j++) {
            struct exact_hit truth = exact_sphere(&ray, centers + 3 * j, radii[j]);
            const struct trace_hit *hit = case_find_hit(&hits, j);
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
        bool is_hit = case_meets(structure, fixture_ray(off, -5 * radius, 0, 0, 3, 0));
        EXPECT(i < 4 || is_hit == (i < 8));
    }
    /* an origin one step within, on and outside */
    const float one = 1;
    void *structure = build_spheres(center, &one, 1);
    for (int i = 0; i < 3; i++) {
        float x = (float[]){nextafterf(1, 0), 1, nextafterf(1, 2)}[i];
        EXPECT(case_closest(structure, fixture_ray(x, 0, 0, -1, 0, 0)).t == (i > 0 ? x - 1 : -1));
    }
}

CASE(61, 0, 0, "what counts for spheres")
{
    const float centers[15] = {0, 0, 0, 5, 0, 0, 10, NAN, 0, 15, 0, 0, 20, 0, 0};
    const float radii[5] = {1, NAN, 1, -1, 0};
    INPUT(spheres, input, VK_GEOMETRY_TYPE_SPHERES_NV, 5, centers, radii, 5);
    input.geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    void *structure = case_build(&input);
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
