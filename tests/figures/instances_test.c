/* SPDX-License-Identifier: Apache-2.0 */
/* Figures of instances that are placed as engines do it, and without memory.
 * tests/programs/advice/data.cases has the mistakes. */
#include <math.h>
#include <string.h>

#include "src/advice/figures/instances.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { COUNT = 6 };

static VkAccelerationStructureInstanceKHR instance(float x)
{
    return (VkAccelerationStructureInstanceKHR){
        .transform = {{{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
        .mask = 0xff,
        .accelerationStructureReference = 4096};
}

TEST(test_no_memory_for_repeated_instances)
{
    const VkAccelerationStructureInstanceKHR one = instance(0);
    struct instance_figures figures;
    WITHOUT_MEMORY(instance_figures_begin(&figures, COUNT));
    for (int i = 0; i < COUNT; i++)
        instance_figures_add(&figures, &one, NULL);
    instance_figures_end(&figures);
    assert_int_equal(figures.repeated, 0);
    assert_int_equal(figures.placed, COUNT);
}

/* ---- scenes at random: scaled, turned and moved, as engines do it */

static float uniform(struct random *random, float low, float high)
{
    return low + (high - low) * (float)random_below(random, 1 << 20) / (float)(1 << 20);
}

/* A rotation from a quaternion, behind scales from 1e-30 to 1e30. */
static void turn_at_random(struct random *random, VkTransformMatrixKHR *transform)
{
    const float x = uniform(random, -1, 1), y = uniform(random, -1, 1), z = uniform(random, -1, 1),
                w = uniform(random, 0.1F, 1), n = 2 / (x * x + y * y + z * z + w * w);
    const float rows[3][3] = {{1 - n * (y * y + z * z), n * (x * y - z * w), n * (x * z + y * w)},
                              {n * (x * y + z * w), 1 - n * (x * x + z * z), n * (y * z - x * w)},
                              {n * (x * z - y * w), n * (y * z + x * w), 1 - n * (x * x + y * y)}};
    const bool is_turned = random_one_in(random, 2);
    for (int i = 0; i < 3; i++) {
        const float scale =
            powf(10, uniform(random, -30, 30)) * (random_one_in(random, 4) ? -1 : 1);
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
            instances[i] = instance((float)i);
            turn_at_random(&random, &instances[i].transform);
            for (int j = 0; j < 3; j++)
                instances[i].transform.matrix[j][3] = is_moved ? uniform(&random, -1e4F, 1e4F) : 0;
            instances[i].accelerationStructureReference += (uint64_t)i * 256;
        }
        struct instance_figures figures;
        uint32_t first;
        instance_figures_begin(&figures, COUNT);
        for (uint32_t i = 0; i < COUNT; i++)
            instance_figures_add(&figures, &instances[i], NULL);
        instance_figures_end(&figures);
        assert_null(figures.placements);
        assert_int_equal(figures.placed, COUNT);
        assert_int_equal(figures.lossy + figures.repeated, 0);
        assert_false(instances_are_stored_by_columns(&figures, &first));
    }
}
