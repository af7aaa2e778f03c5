/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 59 to 64: spheres, then swept ones (VK_NV_ray_tracing_linear_swept_spheres). */
#include <math.h>
#include <string.h>

#include "cases.h"

static void *build_spheres(const float *centers, const float *radii, uint32_t count)
{
    INPUT(spheres, input, VK_GEOMETRY_TYPE_SPHERES_NV, count, centers, radii, count);
    return case_build(&input);
}

/* Many of all sizes; rays into them, beside them and along their silhouettes. */
CASE(59, 0, 0, "spheres", "spheres")
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
CASE(60, 0, 0, "silhouettes of spheres", "spheres")
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

CASE(61, 0, 0, "what counts for spheres", "spheres")
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

/* ---- linear swept spheres */

struct swept {
    float ends[6], radii[2];
};

/* How far outside a point is, by the sphere that is nearest to it; `s` says which. */
static long double outside(const struct swept *swept, const long double at[3], long double *s)
{
    long double axis[3], to[3], length = 0, along = 0, distance = 0;
    long double shrink = (long double)swept->radii[0] - swept->radii[1];
    for (int i = 0; i < 3; i++) {
        axis[i] = (long double)swept->ends[3 + i] - swept->ends[i];
        to[i] = at[i] - swept->ends[i];
        length += axis[i] * axis[i];
        along += axis[i] * to[i];
    }
    long double stable = length - shrink * shrink;
    *s = stable > 0 ? (along - shrink * swept->radii[0]) / stable : shrink < 0;
    *s = *s < 0 ? 0 : *s > 1 ? 1 : *s;
    for (int i = 0; i < 3; i++) {
        long double offset = to[i] - *s * axis[i];
        distance += offset * offset;
    }
    return sqrtl(distance) - (swept->radii[0] - *s * shrink);
}

static long double outside_at(const struct swept *swept, const struct trace_ray *ray, long double t,
                              long double *s)
{
    long double at[3];
    for (int i = 0; i < 3; i++)
        at[i] = ray->origin[i] + t * ray->direction[i];
    return outside(swept, at, s);
}

/* Where the ray comes from outside to inside, by steps and halving; infinity: nowhere. */
static long double first_entry(const struct swept *swept, const struct trace_ray *ray,
                               long double *s)
{
    enum { STEPS = 4000 };
    long double before = 0;
    if (outside_at(swept, ray, 0, s) < 0)
        return INFINITY;
    for (int i = 1; i <= STEPS; i++) {
        long double t = 2.0L * i / STEPS;
        if (outside_at(swept, ray, t, s) < 0) {
            for (int j = 0; j < 60; j++) {
                long double middle = (before + t) / 2;
                if (outside_at(swept, ray, middle, s) < 0)
                    t = middle;
                else
                    before = middle;
            }
            outside_at(swept, ray, t, s);
            return t;
        }
        before = t;
    }
    return INFINITY;
}

static struct swept random_swept(uint64_t *random, int kind)
{
    struct swept swept;
    for (int i = 0; i < 6; i++)
        swept.ends[i] = fixture_uniform(random, -2, 2);
    for (int i = 0; i < 2; i++)
        swept.radii[i] = fixture_uniform(random, 0.1f, 0.8f);
    if (kind == 1)
        swept.radii[1] = swept.radii[0];
    if (kind == 2) /* one end holds the other */
        swept.radii[0] = 6;
    if (kind == 3)
        swept.radii[1] = 0;
    if (kind == 4)
        memcpy(swept.ends + 3, swept.ends, 12);
    return swept;
}

static void *build_swept(const struct swept *swept, bool has_caps)
{
    INPUT(spheres, input, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, 1, swept->ends, swept->radii,
          2);
    if (!has_caps)
        input.geometry.spheres.end_caps_mode = VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_NONE_NV;
    return case_build(&input);
}

/* Against marching along the ray, with caps and without. The truth is the same at every setting. */
CASE(62, 0, 0, "swept spheres", "spheres")
{
    static struct {
        long double t, s;
        bool is_known;
    } truths[40][4];
    uint64_t random = 103;
    for (int i = 0; i < 40; i++) {
        struct swept swept = random_swept(&random, i % 6);
        void *capped = build_swept(&swept, true);
        void *open = build_swept(&swept, false);
        for (int j = 0; j < 4; j++) {
            struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
            struct trace_hit hit = {0};
            for (int k = 0; k < 3; k++) {
                ray.origin[k] = fixture_uniform(&random, -9, 9);
                ray.direction[k] = 0.5f * (swept.ends[k] + swept.ends[3 + k]) +
                                   fixture_uniform(&random, -1, 1) - ray.origin[k];
            }
            if (!truths[i][j].is_known)
                truths[i][j].t = first_entry(&swept, &ray, &truths[i][j].s);
            truths[i][j].is_known = true;
            const long double t = truths[i][j].t, s = truths[i][j].s;
            bool is_hit = case_trace(capped, ray, &hit);
            EXPECT(is_hit == (t < INFINITY));
            if (is_hit && t < INFINITY) {
                EXPECT(fabsl(hit.t - t) < 1e-5L && hit.is_swept && !hit.is_sphere);
                EXPECT(fabsl(hit.u - s) < 1e-3L);
            }
            is_hit = case_trace(open, ray, &hit);
            bool is_between = t < INFINITY && s > 1e-6L && s < 1 - 1e-6L;
            bool is_beyond = t == INFINITY || s < -1e-6L || s == 0 || s == 1;
            EXPECT(is_hit ? !is_beyond : !is_between);
        }
    }
}

/* Where a midsection meets its caps no ray passes between, near or far. */
CASE(63, 0, 0, "seams of swept spheres", "spheres")
{
    uint64_t random = 107;
    for (int i = 0; i < 30; i++) {
        struct swept swept = random_swept(&random, i % 2);
        double axis[3], side[3] = {0}, length = 0, shrink = (double)swept.radii[0] - swept.radii[1];
        for (int j = 0; j < 3; j++) {
            axis[j] = (double)swept.ends[3 + j] - swept.ends[j];
            length += axis[j] * axis[j];
        }
        length = sqrt(length);
        if (length < 1)
            continue;
        void *structure = build_swept(&swept, true);
        int least = fabs(axis[0]) < fabs(axis[1]) ? 0 : 1; /* across the axis */
        side[(least + 1) % 3] = axis[(least + 2) % 3];
        side[(least + 2) % 3] = -axis[(least + 1) % 3];
        double across = hypot(side[(least + 1) % 3], side[(least + 2) % 3]);
        for (int j = 0; j < 20; j++) {
            double sine = shrink / length, cosine = sqrt(1 - sine * sine);
            float target[3], far = j % 4 == 3 ? 1e5f : 8;
            int end = j % 2;
            for (int k = 0; k < 3; k++) /* the seam's circle, a bit within */
                target[k] = (float)(swept.ends[3 * end + k] +
                                    0.98 * swept.radii[end] *
                                        (sine * axis[k] / length + cosine * side[k] / across));
            float origin[3];
            for (int k = 0; k < 3; k++)
                origin[k] = target[k] + (float)(side[k] / across) * far +
                            fixture_uniform(&random, -0.2f, 0.2f) * far;
            EXPECT(case_count(structure, case_ray_to(origin, target)) == 1);
        }
    }
}

/* Which ends have caps, and which vertices each primitive has. */
CASE(64, 0, 0, "indices and caps of swept spheres", "spheres")
{
    enum { COUNT = 6 };
    float centers[3 * COUNT] = {0}, radii[COUNT];
    uint16_t half[COUNT];
    for (int i = 0; i < COUNT; i++) {
        centers[3 * i] = (float)(10 * i);
        radii[i] = 1;
        half[i] = 0x3c00;
    }
    const uint16_t successive[] = {9, 0, 1, 2, 4}, list[] = {9, 5, 4, 4, 3, 2, 1};
    const VkRayTracingLssIndexingModeNV each = VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
    const VkRayTracingLssIndexingModeNV pairs = VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV;
    const struct {
        const uint16_t *indices;
        VkRayTracingLssIndexingModeNV mode;
        uint32_t count, skipped;
        struct {
            float x; /* of a ray along +X that begins there: the primitive that it enters there */
            int primitive;
            float u;
        } rays[5];
    } tables[] = {
        {NULL, 0, 3, 0, {{-5, 0, 0}, {13, 1, 0}, {33, 2, 0}, {13, 1, 0}, {52, -1, 0}}},
        {successive, each, 4, 1, {{-5, 0, 0}, {15, 3, 0}, {35, 3, 0}, {5, 3, 0}, {52, -1, 0}}},
        {list, pairs, 3, 1, {{-5, 2, 1}, {15, 2, -1}, {25, 1, 1}, {35, 0, 1}, {52, -1, 0}}},
    };
    for (int i = 0; i < 3; i++) {
        INPUT(spheres, input, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, tables[i].count, centers,
              radii, COUNT);
        struct builder_spheres *geometry = &input.geometry.spheres;
        if (tables[i].indices) {
            geometry->index_type = VK_INDEX_TYPE_UINT16;
            geometry->indices = tables[i].indices;
            geometry->index_stride = 2;
            geometry->indices_size =
                2 * (tables[i].skipped + tables[i].count * (tables[i].mode == 1 ? 1u : 2u));
            geometry->indexing_mode = tables[i].mode;
            input.range.primitiveOffset = 2 * tables[i].skipped;
            geometry->radius_format = VK_FORMAT_R16_SFLOAT;
            geometry->radii = half;
            geometry->radii_size = sizeof(half);
            geometry->radius_stride = 2;
        }
        void *structure = case_build(&input);
        for (int j = 0; j < 5; j++) {
            const struct trace_hit hit =
                case_closest(structure, fixture_ray(tables[i].rays[j].x, 0.5f, 0, 1, 0, 0));
            if (tables[i].rays[j].u < 0)
                continue;
            EXPECT((int)hit.primitive == tables[i].rays[j].primitive);
            EXPECT(hit.t < 0 || hit.u == tables[i].rays[j].u);
        }
        geometry->indices_size--;
        geometry->vertices_size -= 12;
        geometry->radii_size = 1;
        EXPECT(case_fails(&input) && report.out_of_range > 0);
    }
}
