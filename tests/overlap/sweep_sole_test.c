/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of builds of which it is plain, before anything is collected, that they make no pair. */
#include <stdlib.h>

#include "src/check/overlap/pairs.h"
#include "tests/overlap/sweep_fixture.h"
#include "tests/unit/property.h"
#include "tests/unit/random.h"

enum { MEMORIES = 3, PLACES = 8 };

struct sole {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    struct call_view call;
    struct micromap_use micromap;
    struct micromap_uses micromaps;
    struct build_view view;
};

/* Nothing is known about memory 0. */
static struct accel_facts random_accel(struct random *random, uintptr_t handle)
{
    return (struct accel_facts){
        .handle = (VkAccelerationStructureKHR)handle,
        .size = 1 + random_below(random, PLACES),
        .memory = (VkDeviceMemory)(uintptr_t)random_below(random, MEMORIES),
        .begin = random_below(random, PLACES),
        .is_sparse = random_one_in(random, 20),
    };
}

static struct address_facts random_scratch(struct random *random)
{
    return (struct address_facts){
        .status = random_one_in(random, 20) ? ADDRESS_UNKNOWN : ADDRESS_IN_BUFFER,
        .bytes_left = random_below(random, PLACES),
        .memory = (VkDeviceMemory)(uintptr_t)random_below(random, MEMORIES),
        .begin = random_below(random, PLACES),
        .is_sparse = random_one_in(random, 20),
    };
}

static struct size_facts random_sizes(struct random *random)
{
    if (random_one_in(random, 20))
        return (struct size_facts){0};
    return (struct size_facts){.known = true,
                               .acceleration_structure = random_below(random, PLACES),
                               .build_scratch = random_below(random, PLACES),
                               .update_scratch = random_below(random, PLACES)};
}

/* A structure that the build reads beside its dst: one that is updated, or a micromap. */
static void add_source(struct random *random, struct sole *sole)
{
    const uintptr_t handle = 1 + random_below(random, 2);
    if (random_one_in(random, 2)) {
        sole->info.srcAccelerationStructure = (VkAccelerationStructureKHR)handle;
        sole->view.src = random_accel(random, handle);
        return;
    }
    sole->micromap = (struct micromap_use){.handle = handle, .accel = random_accel(random, handle)};
    sole->micromaps = (struct micromap_uses){.items = &sole->micromap, .count = 1};
    sole->view.micromaps = &sole->micromaps;
}

static void make_random(struct random *random, struct sole *sole)
{
    *sole = (struct sole){
        .info.mode = random_one_in(random, 3) ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                              : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
        .call.command = COMMAND_DEVICE,
        .call.info_count = 1,
    };
    sole->view = (struct build_view){.call = &sole->call,
                                     .info = &sole->info,
                                     .dst = random_accel(random, 1),
                                     .scratch = random_scratch(random),
                                     .sizes = random_sizes(random)};
    if (random_one_in(random, 4))
        add_source(random, sole);
}

/* What the whole way finds: pairs, and ranges that are to be compared later. */
static uint32_t count_by_sweep(const struct check_context *context, const struct build_view *build)
{
    struct sweep sweep;
    sweep_init(&sweep);
    pairs_collect(context, &sweep, build);
    const uint32_t found = sweep.noted_count + count_pairs(&sweep);
    sweep_release(&sweep);
    return found;
}

static uint32_t plain, without_pairs;

/* A build that depends on the operand. */
static void sole_check(void *state, const uint32_t *operands)
{
    const struct check_context context = {.level = LEVEL_STATE};
    struct sole *sole = state;
    make_random(&(struct random){operands[0]}, sole);
    const bool is_plain = pairs_has_none_within(&context, &sole->view);
    const uint32_t found = count_by_sweep(&context, &sole->view);
    EXPECT(!is_plain || found == 0);
    plain += is_plain;
    without_pairs += found == 0;
}

PROPERTY_TEST(plain_builds, .size = sizeof(struct sole),
              .operations = {{"build", sole_check, {1 << 24}, 1}}, .sequences = 100, .steps = 200)

TEST(most_builds_without_pairs_are_plain)
{
    assert_in_range(plain, without_pairs / 2, without_pairs);
    assert_true(getenv("ASSAY_TEST_STEPS") || (without_pairs > 10000 && without_pairs < 18000));
}
