/* SPDX-License-Identifier: Apache-2.0 */
/* Ray flags, instance flags and geometry flags: what counts as opaque and what is culled. */
#include <math.h>

#include "tests/builder/fixture.h"
#include "tests/unit/unit_test.h"

static struct trace_ray down(uint32_t flags)
{
    struct trace_ray ray = fixture_ray(0.25f, 0.25f, 1, 0, 0, -1);
    ray.flags = flags;
    return ray;
}

/* A TLAS of one instance with these flags, over one triangle with those. */
struct pair {
    void *blas, *tlas;
};

static struct pair make_pair(VkGeometryFlagsKHR geometry, VkGeometryInstanceFlagsKHR flags)
{
    struct pair pair;
    INPUT(triangles, input, fixture_triangle, 1);
    input.geometry.flags = geometry;
    pair.blas = fixture_build(&input.input, NULL);
    VkAccelerationStructureInstanceKHR instance = fixture_instance(pair.blas);
    instance.flags = flags & 0xff;
    fixture_input_instances(&input, &instance, 1);
    pair.tlas = fixture_build(&input.input, NULL);
    return pair;
}

/* 1: hit and opaque, 0: hit and not, -1: no hit */
static int opacity(VkGeometryFlagsKHR geometry, VkGeometryInstanceFlagsKHR flags,
                   uint32_t ray_flags)
{
    struct pair pair = make_pair(geometry, flags);
    struct trace_ray ray = down(ray_flags);
    struct trace_hit hit;
    return fixture_trace(pair.tlas, TRACE_EXACT, &ray, &hit) ? hit.opaque : -1;
}

/* The ray's flags win over the instance's, those over the geometry's. */
SCOPE_TEST(test_opacity)
{
    const VkGeometryFlagsKHR opaque = VK_GEOMETRY_OPAQUE_BIT_KHR;
    const VkGeometryInstanceFlagsKHR force = VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR;
    const VkGeometryInstanceFlagsKHR forbid = VK_GEOMETRY_INSTANCE_FORCE_NO_OPAQUE_BIT_KHR;
    assert_int_equal(opacity(0, 0, 0), 0);
    assert_int_equal(opacity(opaque, 0, 0), 1);
    assert_int_equal(opacity(0, force, 0), 1);
    assert_int_equal(opacity(opaque, forbid, 0), 0);
    assert_int_equal(opacity(opaque, force, TRACE_NO_OPAQUE), 0);
    assert_int_equal(opacity(0, forbid, TRACE_OPAQUE), 1);
    assert_int_equal(opacity(opaque, 0, TRACE_CULL_OPAQUE), -1);
    assert_int_equal(opacity(0, 0, TRACE_CULL_OPAQUE), 0);
    assert_int_equal(opacity(0, 0, TRACE_CULL_NO_OPAQUE), -1);
    assert_int_equal(opacity(0, force, TRACE_CULL_NO_OPAQUE), 1);
}

SCOPE_TEST(test_culling)
{
    const VkGeometryInstanceFlagsKHR both =
        VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
    assert_int_equal(opacity(0, 0, TRACE_CULL_FRONT_FACING), -1);
    assert_int_equal(opacity(0, 0, TRACE_CULL_BACK_FACING), 0);
    assert_int_equal(opacity(0, both, TRACE_CULL_FRONT_FACING), 0);
    assert_int_equal(opacity(0, 0, TRACE_SKIP_TRIANGLES), -1);
    assert_int_equal(opacity(0, 0, TRACE_SKIP_AABBS), 0);
}

SCOPE_TEST(test_first_hit)
{
    float corners[90];
    for (int i = 0; i < 90; i++) {
        int depth = i % 3 == 2 ? i / 9 : 0;
        corners[i] = fixture_triangle[i % 9] - (float)depth;
    }
    INPUT(triangles, input, corners, 10);
    void *structure = fixture_build(&input.input, NULL);
    struct trace_ray ray = down(TRACE_TERMINATE_ON_FIRST_HIT);
    struct trace_hit hit;
    assert_true(fixture_trace(structure, TRACE_ROBUST, &ray, &hit));
    ray.flags = 0;
    assert_true(fixture_trace(structure, TRACE_ROBUST, &ray, &hit));
    assert_int_equal(hit.primitive, 0);
    struct trace_counters counters = {0};
    struct trace_scene scene = {
        .structure = structure, .accuracy = TRACE_ROBUST, .counters = &counters};
    trace_closest(&scene, &ray, &hit);
    assert_true(counters.nodes > 0 && counters.primitives > 0 && counters.exact_calls == 0);
}

SCOPE_TEST(test_rays_that_hit_nothing)
{
    struct pair pair = make_pair(0, 0);
    struct trace_hit hit;
    for (int i = 0; i < 8; i++) {
        struct trace_ray ray = down(0);
        float *fields[] = {&ray.origin[0], &ray.direction[2], &ray.direction[2], &ray.t_min,
                           &ray.t_min,     &ray.t_max,        &ray.origin[1],    &ray.direction[0]};
        const float values[] = {NAN, 0, NAN, -1, NAN, NAN, INFINITY, INFINITY};
        *fields[i] = values[i];
        for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++) {
            assert_false(fixture_trace(pair.tlas, (enum trace_accuracy)accuracy, &ray, &hit));
            assert_false(fixture_trace(pair.blas, (enum trace_accuracy)accuracy, &ray, &hit));
        }
    }
}
