/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs that the comparer retains, at the limit of their size and with memory that runs out: an
 * input lives as long as a build refers to it. */
#include "layer/compare/retained_inputs.h"

#include <stdlib.h>

#include "layer/compare/comparer.h"
#include "tests/fixture/geometry.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum { SOURCE_ID = 101, UPDATED_ID, OTHER_ID };

static struct layer_device device;
static struct comparer comparer;
static const VkAabbPositionsKHR box = {0, 0, 0, 1, 1, 1};
static VkAccelerationStructureGeometryKHR geometry;
static VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 1};
static const struct build_parameters parameters = {
    .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, .geometryCount = 1},
    .geometries = &geometry,
    .ranges = &range,
};

static uint64_t find(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    *bytes = (const void *)(uintptr_t)address;
    return size;
}

static const struct input_memory memory = {.find = find};
static const struct order_batch batch;

static void begin(void)
{
    comparer = (struct comparer){.device = &device, .last = &comparer.builds};
    device.structures = structures_create(KEEPS_NOTHING, comparison.inputs);
    assert_non_null(device.structures);
    geometry = boxes_geometry((uintptr_t)&box, sizeof(box));
}

static void end(void)
{
    while (comparer.builds) {
        struct retained_build *build = comparer.builds;
        comparer.builds = build->next;
        retained_free_build(build);
    }
    structures_destroy(device.structures);
    assert_int_equal(comparer.retained_size, 0);
}

/* A build of the box, or an update of the structure `source_id`. */
static void keep(uint64_t id, uint64_t source_id)
{
    struct recorded_build build = {.parameters = parameters};
    build.parameters.info.mode = source_id ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                           : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    const struct journal_entry entry = {
        .dst = id, .dst_id = id, .src = source_id, .src_id = source_id};
    comparison.keep(&comparer,
                    &(struct executed_input){
                        .entry = &entry, .build = &build, .memory = &memory, .batch = &batch});
}

/* The build that was retained first is compared, and no longer needed. */
static void compare_first(void)
{
    struct retained_build *build = comparer.builds;
    assert_non_null(build);
    comparer.builds = build->next;
    if (!comparer.builds)
        comparer.last = &comparer.builds;
    retained_free_build(build);
}

/* Counts the references to the input of a structure, without the one that finds it. */
static uint64_t references_of(uint64_t id)
{
    struct retained_input *input = structures_find_input(device.structures, id);
    uint64_t references = input ? input->references - 1 : 0;
    retained_release(input);
    return references;
}

/* Leaves room for `count` more inputs. Returns what the end has to give back. */
static uint64_t fill_up(uint64_t size, uint64_t count)
{
    const uint64_t filled = RETAINED_MAX - count * size - comparer.retained_size;
    comparer.retained_size += filled;
    return filled;
}

/* To make room for the input of the update, the inputs of structures without records are released.
 * The structure that is updated is one of them. */
TEST_BETWEEN(test_source_is_released_meanwhile, begin, end)
{
    keep(SOURCE_ID, 0);
    compare_first();
    assert_int_equal(references_of(SOURCE_ID), 1);
    const uint64_t filled = fill_up(comparer.retained_size, 0);
    keep(UPDATED_ID, SOURCE_ID);
    comparer.retained_size -= filled;
    assert_int_equal(references_of(SOURCE_ID), 0);
    assert_null(comparer.builds);
    assert_int_equal(comparer.input_unknown, 1);
}

TEST_BETWEEN(test_source_is_released_and_there_is_room, begin, end)
{
    keep(SOURCE_ID, 0);
    compare_first();
    const uint64_t size = comparer.retained_size;
    keep(OTHER_ID, 0);
    compare_first();
    const uint64_t filled = fill_up(size, 0);
    keep(UPDATED_ID, SOURCE_ID);
    comparer.retained_size -= filled;
    assert_int_equal(references_of(SOURCE_ID), 0);
    assert_int_equal(references_of(OTHER_ID), 0);
    assert_int_equal(references_of(UPDATED_ID), 2);
    assert_non_null(comparer.builds);
    assert_int_equal(comparer.builds->source->references, 1);
    assert_int_equal(comparer.retained_size, 2 * size);
}

/* A structure that is alive keeps its input, also one that is a copy of a destroyed structure. */
TEST_BETWEEN(test_live_structures_keep_inputs, begin, end)
{
    const struct built built = {.state = BUILT_BEFORE};
    for (uint64_t id = SOURCE_ID; id <= OTHER_ID; id++)
        assert_true(structures_set(device.structures, id, &built, timestamp_never()));
    keep(SOURCE_ID, 0);
    compare_first();
    structures_copy_input(device.structures, OTHER_ID, SOURCE_ID);
    structures_note_destroyed(device.structures, SOURCE_ID, 1);
    structures_forget_destroyed(device.structures);
    assert_int_equal(references_of(SOURCE_ID), 2);
    const uint64_t filled = fill_up(comparer.retained_size, 0);
    keep(UPDATED_ID, OTHER_ID);
    comparer.retained_size -= filled;
    assert_int_equal(references_of(SOURCE_ID), 0);
    assert_int_equal(references_of(OTHER_ID), 1);
    assert_null(comparer.builds);
}

static void keep_without_memory(void)
{
    const int before = memory_pause();
    begin();
    memory_resume(before);
    keep(SOURCE_ID, 0);
    const int after = memory_pause();
    end();
    memory_resume(after);
}

TEST(test_keeping_without_memory)
{
    for (int count = 0; memory_is_scarce(count); count++)
        keep_without_memory();
    memory_fail_no_more();
}
