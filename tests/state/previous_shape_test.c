/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of builds that are like the one before: where one is, the rules that are said to read the
 * shape alone say of it what they say of the other. */
#include <string.h>

#include "random.h"
#include "rows_by_subject.h"
#include "src/check/assemble/views.h"
#include "src/rules/predicates.h"
#include "src/state/builds/previous_shape.h"
#include "tests/fixture/geometry.h"
#include "tests/state/unit_test.h"
#include "vuid-tables/rules.h"

enum { PAIRS = 200000 };

/* A build of one geometry, with members that may be right or wrong. */
struct sample {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildRangeInfoKHR range;
    bool by_pointer; /* of ppGeometries */
};

enum { JUNK = 0x12345678 };

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};

/* A member, and the values that it may have. */
struct member {
    size_t offset, size;
    uint64_t values[12];
    uint32_t value_count;
};

#define MEMBER(name, ...)                                                                          \
    {                                                                                              \
        offsetof(struct sample, name), sizeof(((struct sample *)0)->name), {__VA_ARGS__},          \
            sizeof((const uint64_t[]){__VA_ARGS__}) / sizeof(uint64_t)                             \
    }
#define DATA(name, ...) MEMBER(geometry.geometry.name, __VA_ARGS__)
#define ADDRESS(name) DATA(name, 0, 0x1000, 0x1001)
/* Seldom there is a chain. */
#define CHAIN(name) MEMBER(name, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, (uintptr_t)&stray)

enum { MEMBERS = 23, FIRST_OF_TRIANGLES = 17 };

/* The members that can be changed one by one, those of triangles last. */
static const struct member members[MEMBERS] = {
    MEMBER(info.sType, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR, JUNK),
    CHAIN(info.pNext),
    MEMBER(info.type, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
           VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
           VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR,
           VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR, JUNK),
    MEMBER(info.flags, 0, 1, 4 | 8, 1 << 20),
    MEMBER(info.mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
           VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR, JUNK),
    MEMBER(info.srcAccelerationStructure, 0, 0x10),
    MEMBER(info.dstAccelerationStructure, 0, 0x20),
    MEMBER(info.scratchData, 0, 0x100, 0x101),
    MEMBER(by_pointer, false, true),
    MEMBER(geometry.sType, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR, JUNK),
    CHAIN(geometry.pNext),
    MEMBER(geometry.flags, 0, 1, 1 << 9),
    DATA(triangles.sType, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
         VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
         VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR, JUNK),
    MEMBER(geometry.geometryType, VK_GEOMETRY_TYPE_TRIANGLES_KHR, VK_GEOMETRY_TYPE_AABBS_KHR,
           VK_GEOMETRY_TYPE_INSTANCES_KHR, JUNK),
    MEMBER(range.primitiveCount, 0, 1),
    MEMBER(range.primitiveOffset, 0, 1, 2),
    MEMBER(range.transformOffset, 0, 1, 2),
    DATA(triangles.vertexFormat, VK_FORMAT_R32G32B32_SFLOAT, VK_FORMAT_R16G16_SFLOAT,
         VK_FORMAT_UNDEFINED, JUNK),
    DATA(triangles.vertexStride, 12, 13, UINT64_C(1) << 33),
    DATA(triangles.indexType, VK_INDEX_TYPE_UINT16, VK_INDEX_TYPE_UINT32, VK_INDEX_TYPE_NONE_KHR,
         VK_INDEX_TYPE_UINT8, JUNK),
    ADDRESS(triangles.vertexData),
    ADDRESS(triangles.indexData),
    ADDRESS(triangles.transformData)};

/* Those of the union, which is filled as one of its members. */
static const struct member more_of_triangles[] = {CHAIN(geometry.geometry.triangles.pNext),
                                                  DATA(triangles.maxVertex, 0, 1)};
static const struct member aabbs[] = {CHAIN(geometry.geometry.aabbs.pNext), ADDRESS(aabbs.data),
                                      DATA(aabbs.stride, 24, 25, UINT64_C(1) << 33)};
static const struct member instances[] = {CHAIN(geometry.geometry.instances.pNext),
                                          DATA(instances.arrayOfPointers, VK_FALSE, VK_TRUE),
                                          ADDRESS(instances.data)};

static void draw(struct random *random, struct sample *sample, const struct member *drawn,
                 size_t count)
{
    for (const struct member *member = drawn; member < drawn + count; member++) {
        const uint64_t value = member->values[random_below(random, member->value_count)];
        memcpy((char *)sample + member->offset, &value, member->size);
    }
}

static struct sample some_sample(struct random *random)
{
    static const VkGeometryTypeKHR types[] = {
        VK_GEOMETRY_TYPE_TRIANGLES_KHR, VK_GEOMETRY_TYPE_AABBS_KHR, VK_GEOMETRY_TYPE_INSTANCES_KHR};
    const uint32_t type = random_below(random, 3);
    struct sample sample = {.info.geometryCount = 1};
    draw(random, &sample, members, type == 0 ? MEMBERS : FIRST_OF_TRIANGLES);
    if (type == 0)
        draw(random, &sample, more_of_triangles, 2);
    else
        draw(random, &sample, type == 1 ? aabbs : instances, 3);
    if (!random_one_in(random, 8))
        sample.geometry.geometryType = types[type];
    return sample;
}

static bool has_triangles(const struct sample *sample)
{
    return sample->geometry.geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR;
}

/* One member becomes that of another build. */
static void change_member(struct random *random, struct sample *sample)
{
    const uint32_t member = random_below(random, MEMBERS);
    struct sample other = some_sample(random);
    if (member >= FIRST_OF_TRIANGLES && !has_triangles(sample))
        return;
    while (member >= FIRST_OF_TRIANGLES && !has_triangles(&other))
        other = some_sample(random);
    memcpy((char *)sample + members[member].offset, (char *)&other + members[member].offset,
           members[member].size);
}

/* What the rules that read the shape alone say of a build: true where they hold. */
struct verdicts {
    bool asked[RULE_COUNT], has_references[RULE_COUNT];
};

#define ASK(name, level, view)                                                                     \
    if (READS_SHAPE_##level) {                                                                     \
        verdicts->asked[RULE_##name] = true;                                                       \
        verdicts->has_references[RULE_##name] = name(view, NULL);                                  \
    }

static void judge(struct sample *sample, struct verdicts *verdicts)
{
    static const struct device_facts device = {.acceleration_structure = true};
    const VkAccelerationStructureGeometryKHR *pointer = &sample->geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range = &sample->range;
    struct readable_cache readable = {0};
    struct check_context context = {.readable = &readable};
    sample->info.pGeometries = sample->by_pointer ? NULL : pointer;
    sample->info.ppGeometries = sample->by_pointer ? &pointer : NULL;
    struct call_view call = {.command = COMMAND_DEVICE,
                             .info_count = 1,
                             .device = &device,
                             .infos = &sample->info,
                             .build_ranges = &range};
    struct build_view build;
    struct geometry_view geometry;
    view_call(&context, &call);
    view_build(&context, &call, 0, &build);
    view_geometry(&context, &build, 0, &geometry);
    memset(verdicts, 0, sizeof(*verdicts));
    ROWS_OF_build(ASK, &build);
    ROWS_OF_geometry(ASK, &geometry);
    sample->info.pGeometries = pointer;
    sample->info.ppGeometries = NULL;
}

static const VkAccelerationStructureBuildTypeKHR type =
    VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR;

/* With sizes that are known, and some number of primitives. */
static void keep(struct previous_shape *recent, const struct sample *sample,
                 uint32_t primitive_count, bool passes)
{
    previous_shape_set(recent, &sample->info, primitive_count, type,
                       &(struct size_facts){.known = true}, passes);
}

static bool is_alike(const struct sample *a, const struct sample *b)
{
    struct previous_shape recent;
    keep(&recent, a, a->range.primitiveCount, true);
    return previous_shape_is_same(&recent, &b->info, b->range.primitiveCount, type) &&
           previous_shape_matches(&recent, &b->info);
}

/* Compares a build with one of which a few members are others. Returns whether they are alike. */
static bool compare_with_another(struct random *random, bool broken[RULE_COUNT])
{
    struct sample a = some_sample(random), b = a;
    struct verdicts of_a, of_b;
    for (uint32_t i = 1 + random_below(random, 3); i; i--)
        change_member(random, &b);
    judge(&a, &of_a);
    judge(&b, &of_b);
    a.info.pGeometries = &a.geometry;
    b.info.pGeometries = &b.geometry;
    const bool alike = is_alike(&a, &b);
    for (int rule = 0; rule < RULE_COUNT; rule++) {
        broken[rule] |= of_a.asked[rule] && !of_a.has_references[rule];
        if (alike && of_a.has_references[rule] != of_b.has_references[rule])
            fail_msg("%s is said to read the shape alone", rule_infos[rule].name);
    }
    return alike;
}

/* A build of one geometry, with no chain that means anything, can't break these. */
static bool can_be_broken(enum rule rule)
{
    return rule != RULE_tlas_has_one_geometry && rule != RULE_blas_geometries_have_one_type &&
           rule != RULE_geometry_chain_has_no_duplicates &&
           rule != RULE_triangles_chain_has_no_duplicates;
}

TEST(test_rules_of_the_shape_read_nothing_else)
{
    struct random random = random_of("previous_shape");
    bool broken[RULE_COUNT] = {false};
    uint32_t alike = 0;
    for (uint32_t i = 0; i < PAIRS; i++)
        alike += compare_with_another(&random, broken);
    assert_in_range(alike, PAIRS / 20, PAIRS / 2);

    struct sample sample = some_sample(&random);
    struct verdicts verdicts;
    judge(&sample, &verdicts);
    for (int rule = 0; rule < RULE_COUNT; rule++)
        if (verdicts.asked[rule] && can_be_broken((enum rule)rule) && !broken[rule])
            fail_msg("%s was never broken", rule_infos[rule].name);
}

static struct sample a_sample(void)
{
    return (struct sample){.info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                                        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                        .geometryCount = 1),
                           .geometry = triangles_geometry(0, 0, VK_INDEX_TYPE_NONE_KHR, 0)};
}

TEST(test_a_build_of_the_same_shape_has_its_sizes)
{
    struct sample a = a_sample();
    struct previous_shape recent = {0};
    a.info.pGeometries = &a.geometry;
    assert_false(previous_shape_is_same(&recent, &a.info, 1, type));
    keep(&recent, &a, 1, false);
    assert_true(previous_shape_is_same(&recent, &a.info, 1, type));
    assert_false(previous_shape_matches(&recent, &a.info));
    assert_false(previous_shape_is_same(&recent, &a.info, 2, type));
    assert_false(
        previous_shape_is_same(&recent, &a.info, 1, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR));
    keep(&recent, &a, 1, true);
    assert_true(previous_shape_matches(&recent, &a.info));
    a.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    assert_true(previous_shape_is_same(&recent, &a.info, 1, type));
    assert_false(previous_shape_matches(&recent, &a.info));
}

/* One with a chain isn't kept, nor the one before it. */
TEST(test_a_build_with_a_chain_is_like_none)
{
    struct sample a = a_sample();
    struct previous_shape recent = {0};
    a.info.pGeometries = &a.geometry;
    keep(&recent, &a, 1, true);
    a.geometry.pNext = &stray;
    assert_false(previous_shape_is_same(&recent, &a.info, 1, type));
    keep(&recent, &a, 1, true);
    a.geometry.pNext = NULL;
    assert_false(previous_shape_is_same(&recent, &a.info, 1, type));
}
