/* SPDX-License-Identifier: Apache-2.0 */
/* Scopes against the registry: each stage with each access flag, on both sides. */
#include "src/hazards/scopes.h"

#include <string.h>

#include "tests/unit/unit_test.h"

struct stage_row {
    const char *name;
    VkPipelineStageFlags2 flag;
    stage_set named, src, dst; /* src and dst: with logically earlier and later stages */
};

struct access_row {
    const char *name;
    VkAccessFlags2 flag, with_equivalents;
    VkPipelineStageFlags2 stages; /* that support it; 0: all */
};

#include "sync_registry.h"

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
#define ALL_FLAGS (VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT)

static const struct barrier_features all_features = {true, true, true, true};

/* Finds flags by their names without prefix, which may be those of vkCmdPipelineBarrier. */
static const struct access_row *named_access(const char *name)
{
    for (size_t i = 0; i < COUNT_OF(access_rows); i++)
        if (!strcmp(access_rows[i].name + strlen("VK_ACCESS_2_"), name))
            return &access_rows[i];
    fail_msg("no access flag %s", name);
    return NULL;
}

static const struct stage_row *named_stage(const char *name)
{
    const bool is_old = strcmp(name, "TRANSFER_BIT") == 0;
    for (size_t i = 0; i < COUNT_OF(stage_rows); i++)
        if (!strcmp(stage_rows[i].name + strlen("VK_PIPELINE_STAGE_2_"),
                    is_old ? "ALL_TRANSFER_BIT" : name))
            return &stage_rows[i];
    fail_msg("no stage %s", name);
    return NULL;
}

static bool includes(const struct access_row *access, enum access_kind kind)
{
    VkAccessFlags2 memory =
        access_is_write(kind) ? VK_ACCESS_2_MEMORY_WRITE_BIT : VK_ACCESS_2_MEMORY_READ_BIT;
    return access->flag == memory ||
           (access->with_equivalents &
            named_access(access_names(kind, &all_features).access)->with_equivalents);
}

static kind_set expected_kinds(stage_set named, const struct access_row *access)
{
    kind_set kinds = 0;
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (named & access_stages((enum access_kind)kind) &&
            includes(access, (enum access_kind)kind))
            kinds |= 1u << kind;
    return kinds;
}

TEST(each_stage_and_access_has_the_scopes_of_the_registry)
{
    for (size_t i = 0; i < COUNT_OF(stage_rows); i++)
        for (size_t j = 0; j < COUNT_OF(access_rows); j++) {
            const struct stage_row *stage = &stage_rows[i];
            const struct access_row *access = &access_rows[j];
            kind_set kinds = expected_kinds(stage->named, access);
            struct dependency src = dependency_of(stage->flag, access->flag, 0, 0);
            struct dependency dst = dependency_of(0, 0, stage->flag, access->flag);
            if (src.src != stage->src || dst.dst != stage->dst || src.src_kinds != kinds ||
                dst.dst_kinds != kinds || src.dst || src.dst_kinds || dst.src || dst.src_kinds)
                fail_msg("%s %s: %x %x -> %x %x instead of %x %x -> %x %x", stage->name,
                         access->name, src.src, src.src_kinds, dst.dst, dst.dst_kinds, stage->src,
                         kinds, stage->dst, kinds);
        }
}

/* Waits and signals have no access masks: all accesses at their stages, whether a flag names or
 * implies them. */
TEST(semaphores_have_all_accesses_at_their_stages)
{
    static const struct access_row all = {"all", ALL_FLAGS, UINT64_MAX, 0};
    for (size_t i = 0; i < COUNT_OF(stage_rows); i++) {
        const struct stage_row *stage = &stage_rows[i];
        struct dependency signal = dependency_of_signal(stage->flag);
        struct dependency wait = dependency_of_wait(stage->flag);
        assert_int_equal(signal.src, stage->src);
        assert_int_equal(wait.dst, stage->dst);
        assert_int_equal(signal.src_kinds, expected_kinds(stage->src, &all));
        assert_int_equal(wait.dst_kinds, expected_kinds(stage->dst, &all));
    }
}

TEST(masks_of_several_bits_are_unions)
{
    struct dependency copies = dependency_of(
        VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
        VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
        VK_PIPELINE_STAGE_2_HOST_BIT | VK_PIPELINE_STAGE_2_MICROMAP_BUILD_BIT_EXT,
        VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_MICROMAP_READ_BIT_EXT);
    assert_int_equal(copies.src_kinds,
                     1u << ACCESS_TRANSFER_WRITE | 1u << ACCESS_FILL_WRITE |
                         1u << ACCESS_MARKER_WRITE | 1u << ACCESS_BUILD_ACCEL_WRITE |
                         1u << ACCESS_COPY_ACCEL_WRITE | 1u << ACCESS_COPY_ACCEL_TRANSFER_WRITE);
    assert_int_equal(copies.dst_kinds, 1u << ACCESS_HOST_READ | 1u << ACCESS_MICROMAP_READ);
    assert_int_equal(copies.dst, 1u << SYNC_HOST | 1u << SYNC_MICROMAP);
}

TEST(unknown_bits_are_all_stages_and_accesses)
{
    struct dependency src = dependency_of(1ull << 63, 0, 0, 0);
    struct dependency access =
        dependency_of(VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, 1ull << 63,
                      1ull << 63, 1ull << 63);
    assert_int_equal(src.src, ALL_SYNC_STAGES);
    assert_int_equal(src.src_kinds, 0);
    assert_true(access.src_kinds & 1u << ACCESS_BUILD_ACCEL_WRITE);
    assert_false(access.src_kinds & 1u << ACCESS_TRANSFER_WRITE);
    assert_int_equal(access.dst, ALL_SYNC_STAGES);
    assert_int_equal(access.dst_kinds, (1u << ACCESS_KINDS) - 1);
}

/* The registry allows the barrier, and the device has enabled what it names. */
static void expect_allowed(const struct stage_row *stage, const struct access_row *access,
                           const struct barrier_features *features)
{
    if (!(access->stages & stage->flag) && access->stages &&
        stage->flag != VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT)
        fail_msg("%s does not support %s", stage->name, access->name);
    if (!features->synchronization2)
        assert_false((stage->flag | access->flag) >> 32 ||
                     stage->flag == VK_PIPELINE_STAGE_2_COPY_BIT);
    if (!features->structures)
        assert_int_not_equal(stage->flag, VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR);
    if (!features->structure_copies)
        assert_int_not_equal(stage->flag, VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_COPY_BIT_KHR);
    if (!features->micromaps) {
        assert_int_not_equal(stage->flag, VK_PIPELINE_STAGE_2_MICROMAP_BUILD_BIT_EXT);
        assert_int_not_equal(access->flag, VK_ACCESS_2_MICROMAP_READ_BIT_EXT);
        assert_int_not_equal(access->flag, VK_ACCESS_2_MICROMAP_WRITE_BIT_EXT);
    }
}

/* A barrier as the message advises orders the access, whatever the device has enabled. */
TEST(names_of_a_kind_make_a_barrier_that_includes_it)
{
    for (uint32_t i = 0; i < ACCESS_KINDS * 16; i++) {
        const struct barrier_features features = {i & 1, i & 2, i & 4, i & 8};
        enum access_kind kind = (enum access_kind)(i / 16);
        const struct access_names names = access_names(kind, &features);
        const struct stage_row *stage = named_stage(names.stage);
        const struct access_row *access = named_access(names.access);
        struct dependency src = dependency_of(stage->flag, access->flag, 0, 0);
        assert_true(src.src >> access_stage(kind) & 1);
        assert_true(src.src_kinds >> kind & 1);
        expect_allowed(stage, access, &features);
        assert_true(access_is_write(kind) == (strstr(access->name, "WRITE") != NULL));
        assert_int_equal(strstr(names.stage_prefix, "_2_") != NULL, features.synchronization2);
        assert_int_equal(strstr(names.access_prefix, "_2_") != NULL, features.synchronization2);
    }
}
