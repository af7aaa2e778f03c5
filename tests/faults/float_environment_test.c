/* SPDX-License-Identifier: Apache-2.0 */
/* Applications whose floating-point exceptions are signals: input data with NaN, and transforms
 * whose determinant no float can represent, are valid. */
#define _GNU_SOURCE // NOLINT
#include "tests/snapshots/scene.h"

#include <fenv.h>
#include <math.h>
#include <string.h>

static const int traps = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW | FE_UNDERFLOW;
static struct device_buffer instances;

static void open_scene(void)
{
    enum { SIZE = 1 << 16 };
    SCENE_OPEN(.boxes_size = SIZE, .structure_size = SIZE, .has_tlas = true);
    instances = scene_input(SIZE);
    scene_write_instance(&instances, true);
}

static void scale_instance(float scale)
{
    VkAccelerationStructureInstanceKHR instance;
    memcpy(&instance, instances.bytes, sizeof(instance));
    for (int i = 0; i < 3; i++)
        instance.transform.matrix[i][i] = scale;
    memcpy(instances.bytes, &instance, sizeof(instance));
}

static void build(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    scene_build_boxes(commands, 2);
    scene_build_instance(commands, instances.address, false);
    scene_submit(commands);
    GET(fixture.vk.QueueWaitIdle(fixture.queue));
}

static void build_with_traps(void)
{
    feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(traps); /* most ARM processors have no such traps */
    const int enabled = fegetexcept();
#ifdef __x86_64__
    assert_int_equal(enabled, traps);
#endif
    build();
    assert_int_equal(fedisableexcept(traps), enabled);
    assert_int_equal(fetestexcept(traps), 0);
}

SCENE_TEST(inactive_boxes)
{
    ((VkAabbPositionsKHR *)scene.boxes.bytes)->minX = NAN;
    build_with_traps();
    fixture_expect_silence(&fixture);
}

SCENE_TEST(large_and_small_transforms)
{
    scale_instance(1e30F);
    build_with_traps();
    scale_instance(1e-30F);
    build_with_traps();
    fixture_expect_silence(&fixture);
}

SCENE_TEST(mistake)
{
    scale_instance(0);
    build_with_traps();
    expect_messages(1, "transform");
}

/* Rounding does not decide what is invertible. */
SCENE_TEST(other_rounding)
{
    const int roundings[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
    for (size_t i = 0; i < ARRAY_COUNT(roundings); i++) {
        assert_int_equal(fesetround(roundings[i]), 0);
        scale_instance(1e-30F);
        build();
        fixture_expect_silence(&fixture);
        scale_instance(0);
        build();
        expect_messages(1, "transform");
        assert_int_equal(fegetround(), roundings[i]);
    }
    fesetround(FE_TONEAREST);
}
