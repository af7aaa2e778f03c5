/* SPDX-License-Identifier: Apache-2.0 */
/* What builds need, rays that hit nothing, and what scans of input find. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/bvh/bvh.h"
#include "src/bvh/input/formats.h"
#include "tests/builder/fixture.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

/* ---- sizes: enough, never more than 1.25 times what is used after compaction; and inputs that
 * make trees as uneven as they get */

/* The bytes that a header and the alignment of four parts add, at most. */
#define FIXED_BYTES 512.0

static void check_build(struct fixture_input *input)
{
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++) {
        input->input.quality = (enum builder_quality)quality;
        void *structure = fixture_build(&input->input, NULL);
        assert_non_null(structure);
        double size = (double)builder_size(structure);
        double compacted = (double)builder_compacted_size(structure);
        assert_true(size <= 1.25 * compacted + FIXED_BYTES);
        if (input->geometry.type == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
            assert_true(size <= 70.0 * input->range.primitiveCount + FIXED_BYTES);
    }
}

SCOPE_TEST(test_counts)
{
    for (uint32_t count = 1; count < 700; count += 1 + count / 9) {
        struct fixture_mesh mesh = fixture_soup(count, count);
        VkAabbPositionsKHR *boxes = fixture_allocate(count * sizeof(*boxes));
        INPUT(mesh, input, &mesh);
        check_build(&input);
        for (uint32_t i = 0; i < count; i++)
            memcpy(&boxes[i].minX, &mesh.positions[9 * i], 6 * sizeof(float));
        fixture_input_aabbs(&input, boxes, count);
        check_build(&input);
    }
}

/* One triangle after the other falls off every range: no tree is deeper, or has fuller leaves. */
SCOPE_TEST(test_uneven)
{
    enum { COUNT = 3000 };
    float *corners = fixture_allocate(COUNT * 9 * sizeof(float));
    for (int kind = 0; kind < 4; kind++) {
        for (int i = 0; i < COUNT; i++) {
            float at = kind == 0   ? ldexpf(1, i % 250 - 120)
                       : kind == 1 ? powf(1.03f, (float)i)
                       : kind == 2 ? (float)(i % 3)
                                   : (float)(i * i);
            float one[9] = {at, at, 0, at * 1.01f, 0, at, at, at * 1.02f, at};
            memcpy(corners + (size_t)9 * (size_t)i, one, sizeof(one));
        }
        INPUT(triangles, input, corners, COUNT);
        check_build(&input);
    }
}

SCOPE_TEST(test_instances)
{
    INPUT(triangles, input, fixture_triangle, 1);
    void *blas = fixture_build(&input.input, NULL);
    for (uint32_t count = 1; count < 300; count += 1 + count / 5) {
        VkAccelerationStructureInstanceKHR *instances =
            fixture_allocate(count * sizeof(*instances));
        for (uint32_t i = 0; i < count; i++) {
            instances[i] = fixture_instance(blas);
            instances[i].transform.matrix[0][3] = (float)(i * i % 1000);
        }
        fixture_input_instances(&input, instances, count);
        check_build(&input);
    }
}

SCOPE_TEST(test_smaller_counts_fit)
{
    struct builder_sizes before = {0}, sizes;
    INPUT(triangles, input, NULL, 0);
    for (uint32_t count = 0; count < 100000; count += 1 + count / 3) {
        assert_int_equal(builder_get_sizes(&input.input, &count, &sizes), BUILDER_OK);
        assert_true(sizes.structure >= before.structure);
        assert_true(sizes.build_scratch >= before.build_scratch);
        before = sizes;
    }
    const uint32_t most = BUILDER_MAX_PRIMITIVES, too_many = most + 1;
    assert_int_equal(builder_get_sizes(&input.input, &most, &sizes), BUILDER_OK);
    assert_int_equal(builder_get_sizes(&input.input, &too_many, &sizes),
                     BUILDER_TOO_MANY_PRIMITIVES);
}

/* Displaced triangles are as many as their usages say, and those beyond that stay whole. */
SCOPE_TEST(test_displaced)
{
    VkMicromapUsageEXT usages[2] = {{10, 5, 3}, {100, 2, 1}};
    struct builder_displacement displacement = {.usage_count = 2, .usages = usages};
    struct builder_sizes before = {0}, sizes;
    INPUT(triangles, input, NULL, 0);
    input.geometry.triangles.displacement = &displacement;
    for (uint32_t count = 0; count < 1000; count += 10) {
        double parts = 10 * 1024 + 100 * 16 + (count > 110 ? count - 110 : 0);
        assert_int_equal(builder_get_sizes(&input.input, &count, &sizes), BUILDER_OK);
        assert_true((double)sizes.structure <= 77 * parts + FIXED_BYTES);
        assert_true((double)sizes.structure >= 75 * parts);
        assert_true(sizes.structure >= before.structure);
        assert_true(sizes.build_scratch >= before.build_scratch);
        assert_true(sizes.update_scratch == sizes.build_scratch); /* it may be a build */
        before = sizes;
    }
    uint32_t none = 0, too_many = UINT32_MAX;
    assert_int_equal(builder_get_sizes(&input.input, &too_many, &sizes),
                     BUILDER_TOO_MANY_PRIMITIVES);
    usages[0].count = BUILDER_MAX_PRIMITIVES / 1024 + 1;
    assert_int_equal(builder_get_sizes(&input.input, &none, &sizes), BUILDER_TOO_MANY_PRIMITIVES);
    usages[0].subdivisionLevel = 6;
    assert_int_equal(builder_get_sizes(&input.input, &none, &sizes), BUILDER_UNKNOWN_FORMAT);
}

SCOPE_TEST(test_too_small)
{
    struct builder_sizes sizes;
    uint32_t count = 1;
    INPUT(triangles, input, fixture_triangle, 1);
    builder_get_sizes(&input.input, &count, &sizes);
    void *structure = fixture_allocate(sizes.structure),
         *scratch = fixture_allocate(sizes.build_scratch);
    for (int lacks = 0; lacks < 3; lacks++) /* of the structure, of scratch, nothing */
        assert_int_equal(builder_build(&input.input, structure, sizes.structure - (lacks == 0),
                                       scratch, sizes.build_scratch - (lacks == 1), NULL),
                         lacks < 2 ? BUILDER_TOO_SMALL : BUILDER_OK);
    input.geometry.triangles.vertex_format = VK_FORMAT_R64G64B64_SFLOAT;
    assert_int_equal(builder_get_sizes(&input.input, &count, &sizes), BUILDER_UNKNOWN_FORMAT);
}

/* ---- rays */

SCOPE_TEST(test_rays_that_hit_nothing)
{
    INPUT(triangles, input, fixture_triangle, 1);
    void *blas = fixture_build(&input.input, NULL);
    VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
    fixture_input_instances(&input, &instance, 1);
    void *tlas = fixture_build(&input.input, NULL);
    struct trace_hit hit;
    for (int i = 0; i < 8; i++) {
        struct trace_ray ray = fixture_ray(0.25f, 0.25f, 1, 0, 0, -1);
        float *fields[] = {&ray.origin[0], &ray.direction[2], &ray.direction[2], &ray.t_min,
                           &ray.t_min,     &ray.t_max,        &ray.origin[1],    &ray.direction[0]};
        const float values[] = {NAN, 0, NAN, -1, NAN, NAN, INFINITY, INFINITY};
        *fields[i] = values[i];
        for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++) {
            assert_false(fixture_trace(tlas, (enum trace_accuracy)accuracy, &ray, &hit));
            assert_false(fixture_trace(blas, (enum trace_accuracy)accuracy, &ray, &hit));
        }
    }
}

/* ---- functions that scan many values at once agree with code that reads one at a time */

enum { ROUNDS = 20000, MOST = 70, STRIDE_MAX = 40 };

static uint32_t max_one_by_one(const uint8_t *indices, uint32_t size, uint64_t count)
{
    uint32_t max = 0;
    for (uint64_t i = 0; i < count; i++) {
        uint32_t index = 0;
        memcpy(&index, indices + i * size, size); /* little endian */
        max = index > max ? index : max;
    }
    return max;
}

TEST(test_largest_index)
{
    struct random random = random_of("largest index");
    uint8_t bytes[4 * MOST + 1];
    for (int round = 0; round < ROUNDS; round++) {
        const uint32_t size = 1u << random_below(&random, 3), at = random_below(&random, 2);
        const uint32_t count = random_below(&random, MOST);
        const bool is_small = random_one_in(&random, 2);
        for (size_t i = 0; i < sizeof(bytes); i++)
            bytes[i] = is_small && random_below(&random, 40) ? 0 : (uint8_t)random_next(&random);
        assert_int_equal(indices_max(bytes + at, size, count),
                         max_one_by_one(bytes + at, size, count));
    }
}

/* Infinities, the largest numbers and NaNs of either sign with any fraction. */
static float some_float(struct random *random, bool may_be_nan)
{
    static const uint32_t others[] = {0x7f800000, 0xff800000, 0x7f7fffff, 0, 0x80000000, 1};
    uint32_t bits = others[random_below(random, 6)];
    if (may_be_nan && random_one_in(random, 60))
        bits = 0x7f800000 | (random_one_in(random, 2) ? 0x80000000 : 0) |
               (1u << random_below(random, 23));
    float number;
    memcpy(&number, &bits, sizeof(number));
    return number;
}

TEST(test_positions_with_nan)
{
    struct random random = random_of("positions with nan");
    static uint8_t bytes[STRIDE_MAX * MOST + 16];
    uint32_t found = 0;
    for (int round = 0; round < ROUNDS; round++) {
        const uint32_t at = random_below(&random, 4), count = random_below(&random, MOST);
        const uint32_t stride = random_one_in(&random, 2) ? 12 : 12 + random_below(&random, 28);
        const bool may_be_nan = random_one_in(&random, 2);
        bool has_nan = false;
        memset(bytes, 0xff, sizeof(bytes)); /* NaN between the positions */
        for (uint32_t i = 0; i < 3 * count; i++) {
            const float number = some_float(&random, may_be_nan);
            memcpy(bytes + at + i / 3 * stride + i % 3 * 4, &number, 4);
            has_nan |= isnan(number);
        }
        assert_int_equal(positions_have_nan(bytes + at, stride, count), has_nan);
        found += has_nan;
    }
    assert_true(found > ROUNDS / 10 && found < ROUNDS);
}
