/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 68 and 71 to 74: single displaced triangles (VK_NV_displacement_micromap). */
#include <math.h>

#include "cases.h"
#include "displacement_encoder.h"

/* ---- a triangle in the plane z = 0 that rises and sinks: all of it can be seen from above */

static const float flat[9] = {0, 0, 0, 4, 0, 0, 0, 4, 0};
static const float up[9] = {0, 0, 1, 0, 0, 2, 0, 0, 0.5f};
static const float biases[6] = {0, 1, 0.25f, 2, -1, 4};

static double height(const struct encoder_values *values, uint32_t level, uint32_t u, uint32_t v)
{
    double edge = 1u << level, w[3] = {(edge - u - v) / edge, u / edge, v / edge};
    double base = 0, along = 0;
    for (int i = 0; i < 3; i++) {
        base += w[i] * up[3 * i + 2] * biases[2 * i];
        along += w[i] * up[3 * i + 2] * biases[2 * i + 1];
    }
    return base + along * values->at[u][v] / 2047;
}

/* At barycentrics u, v: of the microtriangle that holds them. */
static double height_at(const struct encoder_values *values, uint32_t level, double u, double v)
{
    uint32_t edge = 1u << level, column = (uint32_t)(u * edge), row = (uint32_t)(v * edge);
    double x = u * edge - column, y = v * edge - row;
    double right = height(values, level, column + 1, row);
    double above = height(values, level, column, row + 1);
    if (x + y <= 1)
        return height(values, level, column, row) * (1 - x - y) + right * x + above * y;
    return height(values, level, column + 1, row + 1) * (x + y - 1) + right * (1 - y) +
           above * (1 - x);
}

/* Displaced by a micromap of random values. */
static void input_flat(struct fixture_input *input, struct displaced *displaced, uint32_t format,
                       uint32_t count, const uint8_t *levels, uint64_t *random)
{
    open_displaced(displaced, format, count, levels, random_value, random, up, sizeof(up));
    displaced->displacement.biases_and_scales = biases;
    displaced->displacement.biases_and_scales_size = sizeof(biases);
    fixture_input_triangles(input, flat, 1);
    input->geometry.triangles.displacement = &displaced->displacement;
}

static bool is_about(double a, double b)
{
    return fabs(a - b) < 1e-4;
}

static void check_from_above(const void *structure, const struct encoder_values *values,
                             uint32_t level, float time, float rise)
{
    uint64_t random = 101;
    for (int i = 0; i < 40; i++) {
        float u = fixture_uniform(&random, 0.01f, 0.95f),
              v = fixture_uniform(&random, 0.01f, 0.98f - u);
        struct trace_ray ray = fixture_ray(4 * u, 4 * v, 100, 0, 0, -1);
        ray.time = time;
        if (v < 0.01f)
            continue;
        const struct trace_hit hit = case_closest(structure, ray);
        EXPECT(hit.primitive == 0 && hit.geometry == 0 && hit.front_face);
        EXPECT(is_about(hit.u, u) && is_about(hit.v, v));
        EXPECT(is_about(100 - hit.t, height_at(values, level, u, v) + rise));
    }
}

CASE(68, 0, 0, "displaced triangles of every format and level", "displacement")
{
    uint64_t random = 103;
    for (uint32_t i = 0; i < 18; i++) {
        uint32_t format = 1 + i / 6;
        uint8_t level = i % 6;
        struct displaced displaced;
        struct fixture_input input;
        input_flat(&input, &displaced, format, 1, &level, &random);
        void *structure = case_build(&input);
        EXPECT(report.active == 1u << 2 * level && report.inactive == 0);
        check_from_above(structure, displaced.coded, level, 0, 0);
    }
}

/* ---- indices, and what isn't displaced or can't be */

CASE(71, 0, 0, "displaced triangles by index, and not", "displacement")
{
    uint64_t random = 113;
    const uint8_t levels[3] = {1, 2, 3}, bytes[8] = {9, 1, 9, 0xff};
    struct displaced displaced;
    struct fixture_input input;
    input_flat(&input, &displaced, 1, 3, levels, &random);
    struct builder_displacement *displacement = &displaced.displacement;
    displacement->index_type = VK_INDEX_TYPE_UINT8_KHR;
    displacement->indices = bytes + 1;
    displacement->indices_size = 1;
    displacement->base_triangle = 1;
    void *structure = case_build(&input);
    EXPECT(report.active == 64);
    check_from_above(structure, &displaced.coded[2], 3, 0, 0);
    displacement->indices = bytes + 3; /* special: it stays flat */
    structure = case_build(&input);
    const struct trace_ray ray = fixture_ray(1, 1, 5, 0, 0, -1);
    EXPECT(report.active == 1 && case_closest(structure, ray).t == 5);
    displacement->micromap = 0; /* nothing is asked of indices then */
    displacement->indices_size = 0;
    structure = case_build(&input);
    EXPECT(report.active == 1 && case_closest(structure, ray).t == 5);
}

CASE(72, 0, 0, "displaced triangles without values", "displacement")
{
    uint64_t random = 127;
    const uint8_t levels[4] = {2, 2, 2, 2};
    float corners[36], vectors[36];
    struct displaced displaced;
    for (int i = 0; i < 36; i++) {
        corners[i] = flat[i % 9];
        vectors[i] = up[i % 9];
    }
    open_displaced(&displaced, 1, 4, levels, random_value, &random, vectors, sizeof(vectors));
    struct builder_displacement *displacement = &displaced.displacement;
    INPUT(triangles, input, corners, 4);
    input.geometry.triangles.displacement = displacement;
    corners[3] = NAN;
    case_build(&input);
    EXPECT(report.active == 48 && report.inactive == 1 && report.undefined == 0);
    corners[3] = 4;
    vectors[11] = NAN;
    case_build(&input);
    EXPECT(report.active == 48 && report.undefined == 1 && report.first_undefined.primitive == 1);
    vectors[11] = 0;
    displacement->vectors_size--;
    EXPECT(case_fails(&input) && report.first_out_of_range.primitive == 3);
    displacement->vectors_size++;
    displacement->base_triangle = 1;
    EXPECT(case_fails(&input) && report.first_out_of_range.primitive == 3);
    displacement->base_triangle = 0;
    displaced.usages[2].count = 1; /* one of level 2 and others that are flat */
    EXPECT(case_fails(&input) && report.first_out_of_range.primitive == 1);
    displaced.usages[2].count = 0;
    displaced.usages[3].count = 1; /* enough parts for four of level 2, but not enough vertices */
    EXPECT(case_fails(&input) && report.first_out_of_range.primitive == 3);
    displaced.usages[2].count = 4;
    displacement->flags = levels;
    displacement->flags_size = displacement->flags_stride = 1; /* of the first alone */
    EXPECT(case_fails(&input) && report.first_out_of_range.primitive == 1);
    displacement->flags = NULL;
    input.input.micromaps.find = NULL;
    EXPECT(case_fails(&input) && report.out_of_range == 4);
    displaced.usages[0].subdivisionLevel = 6;
    EXPECT(case_fails(&input));
}

/* ---- beside other effects */

CASE(73, 0, 0, "displaced triangles that move or are transformed", "displacement")
{
    uint64_t random = 131;
    uint8_t level = 3;
    float then[9];
    struct displaced displaced;
    struct fixture_input input;
    for (int i = 0; i < 9; i++)
        then[i] = flat[i] + (i % 3 == 2 ? 8 : 0);
    input_flat(&input, &displaced, 3, 1, &level, &random);
    fixture_input_motion(&input, then);
    void *structure = case_build(&input);
    check_from_above(structure, displaced.coded, level, 0, 0);
    check_from_above(structure, displaced.coded, level, 0.75f, 6);
    EXPECT(fixture_refit(&input.input, structure, structure, NULL) == BUILDER_OK);
    check_from_above(structure, displaced.coded, level, 1, 8);
    /* a transform moves what is displaced */
    const VkTransformMatrixKHR raised = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 2.5f}}};
    input.input.flags = 0;
    fixture_input_transform(&input, &raised);
    structure = case_build(&input);
    check_from_above(structure, displaced.coded, level, 0, 2.5f);
}

/* Opacities are found by the barycentrics of the base triangle. */
CASE(74, 0, 0, "displaced triangles with opacities", "displacement")
{
    uint64_t random = 137;
    uint8_t level = 3, opaque = 5; /* of its quarters those at vertices 0 and 1 */
    struct displaced displaced;
    struct fixture_input input;
    VkMicromapUsageEXT usage = {1, 1, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    VkMicromapTriangleEXT triangle = {0, 1, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    const struct micromap_input opacities = fixture_micromap_input(
        VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT, 1, &usage, &opaque, 1, 1, &triangle);
    struct builder_opacity opacity = {.index_type = VK_INDEX_TYPE_NONE_KHR,
                                      .micromap = (uintptr_t)fixture_micromap(&opacities)};
    input_flat(&input, &displaced, 1, 1, &level, &random);
    input.geometry.triangles.opacity = &opacity;
    void *structure = case_build(&input);
    for (int i = 0; i < 30; i++) {
        float u = fixture_uniform(&random, 0.01f, 0.9f),
              v = fixture_uniform(&random, 0.01f, 0.99f - u);
        EXPECT(case_meets(structure, fixture_ray(4 * u, 4 * v, 100, 0, 0, -1)) ==
               (micromap_curve_index(u, v, 1) % 2 == 0));
    }
}
