/* SPDX-License-Identifier: Apache-2.0 */
/* Figures of instances: lists with one mistake, and valid ones near them. */
#include <math.h>
#include <string.h>

#include "src/advice/figures/instances.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { COUNT = 6 };

static VkAccelerationStructureInstanceKHR instance(float x, float y, float z)
{
    return (VkAccelerationStructureInstanceKHR){
        .transform = {{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}},
        .mask = 0xff,
        .accelerationStructureReference = 4096};
}

/* In a row. */
static void line_up(VkAccelerationStructureInstanceKHR instances[COUNT])
{
    for (int i = 0; i < COUNT; i++)
        instances[i] = instance((float)i, 0, 0);
}

static struct instance_figures figures_of(const VkAccelerationStructureInstanceKHR *instances,
                                          uint32_t count)
{
    struct instance_figures figures;
    instance_figures_begin(&figures, count);
    for (uint32_t i = 0; i < count; i++)
        instance_figures_add(&figures, &instances[i], NULL);
    instance_figures_end(&figures);
    assert_null(figures.placements);
    return figures;
}

static bool are_by_columns(const VkAccelerationStructureInstanceKHR instances[COUNT])
{
    const struct instance_figures figures = figures_of(instances, COUNT);
    uint32_t first;
    return instances_are_stored_by_columns(&figures, &first);
}

static void rotate(VkTransformMatrixKHR *transform, const float rotation[3][3], float scale)
{
    for (int i = 0; i < 9; i++)
        transform->matrix[i / 3][i % 3] = scale * rotation[i / 3][i % 3];
}

static const float rotation[3][3] = {{0.36F, 0.48F, -0.8F}, {-0.8F, 0.6F, 0}, {0.48F, 0.64F, 0.6F}};
static const float free_rotation[3][3] = {{2 / 3.0F, -1 / 3.0F, 2 / 3.0F},
                                          {2 / 3.0F, 2 / 3.0F, -1 / 3.0F},
                                          {-1 / 3.0F, 2 / 3.0F, 2 / 3.0F}};

TEST(test_plain_instances)
{
    VkAccelerationStructureInstanceKHR instances[COUNT];
    line_up(instances);
    instances[3].mask = 0;
    instances[4].accelerationStructureReference = 0;
    const struct instance_figures figures = figures_of(instances, COUNT);
    assert_int_equal(figures.count, COUNT);
    assert_int_equal(figures.masked, 1);
    assert_int_equal(figures.inactive, 1);
    assert_int_equal(figures.placed, 4);
    assert_int_equal(figures.singular + figures.lossy + figures.repeated, 0);
    assert_false(are_by_columns(instances));
}

/* ---- inverses */

static struct instance_figures with_transform(const VkTransformMatrixKHR *transform)
{
    VkAccelerationStructureInstanceKHR one = instance(0, 0, 0);
    one.transform = *transform;
    return figures_of(&one, 1);
}

TEST(test_scales_lose_nothing)
{
    const float scales[] = {1e-30F, 1e-6F, 1, 1e6F, 1e30F};
    for (int i = 0; i < 125; i++) {
        VkAccelerationStructureInstanceKHR one = instance(0, 0, 0);
        rotate(&one.transform, rotation, 1);
        for (int j = 0; j < 9; j++) /* the object is scaled, then rotated */
            one.transform.matrix[j / 3][j % 3] *= scales[j % 3 == 0   ? i % 5
                                                         : j % 3 == 1 ? i / 5 % 5
                                                                      : i / 25];
        assert_int_equal(with_transform(&one.transform).lossy, 0);
        assert_int_equal(with_transform(&one.transform).placed, 1);
    }
}

TEST(test_nearly_flat_transforms)
{
    VkTransformMatrixKHR transform = {{{1, 1, 0}, {1, 1 + 0x1p-8F, 0}, {0, 0, 1}}};
    struct instance_figures figures = with_transform(&transform);
    assert_int_equal(figures.lossy, 0);
    transform.matrix[1][1] = 1 + 0x1p-10F;
    figures = with_transform(&transform);
    assert_int_equal(figures.lossy, 1);
    assert_true(figures.lost_bits > 10.9 && figures.lost_bits < 11.1);
    transform.matrix[1][1] = 1;
    figures = with_transform(&transform);
    assert_int_equal(figures.lossy, 0);
    assert_int_equal(figures.singular, 1);
}

TEST(test_exactly_singular_transforms)
{
    const VkTransformMatrixKHR rank2 = {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}};
    const VkTransformMatrixKHR beside = {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9.000001F}}};
    assert_int_equal(with_transform(&rank2).singular, 1);
    assert_int_equal(with_transform(&beside).singular, 0);
    assert_int_equal(with_transform(&beside).lossy, 1);
}

TEST(test_numbers_that_are_not_finite)
{
    VkTransformMatrixKHR transform = {{{1, 0, 0, INFINITY}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    assert_int_equal(with_transform(&transform).placed, 0);
    assert_int_equal(with_transform(&transform).singular, 0);
    transform = (VkTransformMatrixKHR){{{NAN, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    assert_int_equal(with_transform(&transform).placed, 0);
}

/* ---- repeated instances */

TEST(test_repeated_instances)
{
    VkAccelerationStructureInstanceKHR instances[COUNT];
    line_up(instances);
    instances[4] = instances[1];
    instances[4].instanceCustomIndex = 7;
    instances[5] = instances[1];
    struct instance_figures figures = figures_of(instances, COUNT);
    assert_int_equal(figures.repeated, 2);
    assert_int_equal(figures.first_repeated, 4);
    assert_int_equal(figures.twin, 1);
    /* For other rays, or to other shaders. */
    instances[1].mask = 1;
    instances[4].mask = 2;
    instances[5].mask = 4;
    assert_int_equal(figures_of(instances, COUNT).repeated, 0);
    instances[5].mask = 6;
    figures = figures_of(instances, COUNT);
    assert_int_equal(figures.repeated, 1);
    assert_int_equal(figures.first_repeated, 5);
    instances[5].instanceShaderBindingTableRecordOffset = 1;
    assert_int_equal(figures_of(instances, COUNT).repeated, 0);
    instances[5] = instances[1];
    instances[5].flags = VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR;
    assert_int_equal(figures_of(instances, COUNT).repeated, 0);
    instances[5] = instances[1];
    instances[5].accelerationStructureReference += 256;
    assert_int_equal(figures_of(instances, COUNT).repeated, 0);
    instances[5] = instances[1];
    instances[5].transform.matrix[2][3] = 0x1p-149F;
    assert_int_equal(figures_of(instances, COUNT).repeated, 0);
}

TEST(test_invisible_instances_repeat_nothing)
{
    VkAccelerationStructureInstanceKHR instances[COUNT] = {0};
    assert_int_equal(figures_of(instances, COUNT).repeated, 0);
    line_up(instances);
    instances[4] = instances[5] = instances[1];
    instances[4].mask = instances[5].mask = 0;
    assert_int_equal(figures_of(instances, COUNT).repeated, 0);
}

TEST(test_many_instances)
{
    enum { MANY = 5000 };
    static VkAccelerationStructureInstanceKHR instances[MANY];
    for (int i = 0; i < MANY; i++)
        instances[i] = instance((float)(i % 4000), 0, 0);
    const struct instance_figures figures = figures_of(instances, MANY);
    assert_int_equal(figures.repeated, 1000);
    assert_int_equal(figures.first_repeated, 4000);
    assert_int_equal(figures.twin, 0);
}

TEST(test_no_memory_for_repeated_instances)
{
    VkAccelerationStructureInstanceKHR instances[COUNT];
    line_up(instances);
    instances[4] = instances[1];
    struct instance_figures figures;
    WITHOUT_MEMORY(instance_figures_begin(&figures, COUNT));
    for (int i = 0; i < COUNT; i++)
        instance_figures_add(&figures, &instances[i], NULL);
    instance_figures_end(&figures);
    assert_int_equal(figures.repeated, 0);
    assert_int_equal(figures.placed, COUNT);
}

/* ---- transforms that are stored by columns */

/* The third row is the translation. */
TEST(test_translation_in_the_third_row)
{
    VkAccelerationStructureInstanceKHR instances[COUNT];
    for (int i = 0; i < COUNT; i++) {
        instances[i] = instance(0, 0, 0);
        instances[i].transform.matrix[2][0] = 10.0F * (float)(i + 1);
        instances[i].transform.matrix[2][1] = 20;
        instances[i].transform.matrix[2][2] = 5;
    }
    assert_true(are_by_columns(instances));
    instances[3].transform.matrix[1][3] = 1; /* a translation after all */
    assert_false(are_by_columns(instances));
}

static void rotate_all(VkAccelerationStructureInstanceKHR instances[COUNT], bool by_columns)
{
    for (int i = 0; i < COUNT; i++) {
        VkTransformMatrixKHR *transform = &instances[i].transform;
        instances[i] = instance((float)(30 * i), 20, 10);
        rotate(transform, i % 2 ? rotation : free_rotation, (float)(i + 1));
        const VkTransformMatrixKHR right = *transform;
        for (int j = 0; j < 12 && by_columns; j++)
            transform->matrix[j / 4][j % 4] = right.matrix[j % 3][j / 3];
    }
}

TEST(test_columns_of_three)
{
    VkAccelerationStructureInstanceKHR instances[COUNT];
    rotate_all(instances, true);
    assert_true(are_by_columns(instances));
    instances[2] = instance(0, 0, 0); /* one is right */
    assert_false(are_by_columns(instances));
    rotate_all(instances, false);
    assert_false(are_by_columns(instances));
}

/* Objects that are stretched along z, or along an axis that is turned to z; and sheared ones. */
TEST(test_transforms_with_a_large_third_row)
{
    VkAccelerationStructureInstanceKHR instances[COUNT];
    for (int i = 0; i < COUNT; i++) {
        instances[i] = instance(0, 0, 0);
        instances[i].transform.matrix[2][2] = 100.0F * (float)(i + 1);
    }
    assert_false(are_by_columns(instances));
    for (int i = 0; i < COUNT; i++)
        instances[i].transform = (VkTransformMatrixKHR){
            {{0, 0, 1, 0}, {0, 1, 0, 0}, {-100.0F * (float)(i + 1), 0, 0, 0}}};
    assert_false(are_by_columns(instances));
    for (int i = 0; i < COUNT; i++) /* all are sheared alike */
        instances[i].transform =
            (VkTransformMatrixKHR){{{1, 0, 0, 0}, {0, 1, 0, 0}, {10, 0, 1, 0}}};
    assert_false(are_by_columns(instances));
    for (int i = 0; i < COUNT; i++) /* a shear that is a permutation by columns */
        instances[i].transform =
            (VkTransformMatrixKHR){{{1, 0, 0, 0}, {0, 1, 0, 0}, {1, 0, 1, (float)i}}};
    assert_false(are_by_columns(instances));
}

/* ---- scenes at random: scaled, turned and moved, as engines do it */

static float uniform(struct random *random, float low, float high)
{
    return low + (high - low) * (float)random_below(random, 1 << 20) / (float)(1 << 20);
}

/* A rotation from a quaternion, behind scales from a thousandth to a thousand. */
static void turn_at_random(struct random *random, VkTransformMatrixKHR *transform)
{
    const float x = uniform(random, -1, 1), y = uniform(random, -1, 1), z = uniform(random, -1, 1),
                w = uniform(random, 0.1F, 1), n = 2 / (x * x + y * y + z * z + w * w);
    const float rows[3][3] = {{1 - n * (y * y + z * z), n * (x * y - z * w), n * (x * z + y * w)},
                              {n * (x * y + z * w), 1 - n * (x * x + z * z), n * (y * z - x * w)},
                              {n * (x * z - y * w), n * (y * z + x * w), 1 - n * (x * x + y * y)}};
    const bool is_turned = random_one_in(random, 2);
    for (int i = 0; i < 3; i++) {
        const float scale = powf(10, uniform(random, -3, 3)) * (random_one_in(random, 4) ? -1 : 1);
        for (int j = 0; j < 3; j++)
            transform->matrix[j][i] = scale * (is_turned ? rows[j][i] : (float)(i == j));
    }
}

TEST(test_random_scenes)
{
    struct random random = random_of("instances");
    for (int round = 0; round < 2000; round++) {
        VkAccelerationStructureInstanceKHR instances[COUNT];
        const bool is_moved = random_one_in(&random, 2);
        for (int i = 0; i < COUNT; i++) {
            instances[i] = instance((float)i, 0, 0);
            turn_at_random(&random, &instances[i].transform);
            for (int j = 0; j < 3; j++)
                instances[i].transform.matrix[j][3] = is_moved ? uniform(&random, -1e4F, 1e4F) : 0;
            instances[i].accelerationStructureReference += (uint64_t)i * 256;
        }
        const struct instance_figures figures = figures_of(instances, COUNT);
        assert_int_equal(figures.placed, COUNT);
        assert_int_equal(figures.lossy + figures.repeated, 0);
        assert_false(are_by_columns(instances));
    }
}
