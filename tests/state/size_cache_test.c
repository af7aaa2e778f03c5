/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the cache of build sizes: what makes a shape, and what doesn't. */
#include <string.h>

#include "src/state/builds/size_cache.h"
#include "tests/fixture/geometry.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { GEOMETRIES = 3 };

/* A build, in arrays of its own so that a test can change one member. */
struct build {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometries[GEOMETRIES];
    const VkAccelerationStructureGeometryKHR *pointers[GEOMETRIES];
    uint32_t counts[GEOMETRIES];
    VkAccelerationStructureBuildTypeKHR type;
};

/* The second geometry has a transform if it has triangles. */
static struct build a_build(VkGeometryTypeKHR type)
{
    struct build build = {
        .info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                     .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
                     .geometryCount = GEOMETRIES),
        .counts = {5, 6, 7},
        .type = VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
    };
    for (int i = 0; i < GEOMETRIES; i++)
        build.geometries[i] = type == VK_GEOMETRY_TYPE_TRIANGLES_KHR
                                  ? triangles_geometry(0, 99, VK_INDEX_TYPE_UINT32, 0)
                              : type == VK_GEOMETRY_TYPE_AABBS_KHR ? boxes_geometry(0, 24)
                                                                   : instances_geometry(0, false);
    if (type == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
        build.geometries[1].geometry.triangles.transformData.deviceAddress = 0x100;
    return build;
}

static bool shape_of(struct build *build, struct build_shape *shape)
{
    build->info.pGeometries = build->geometries;
    return build_shape_of(&build->info, build->counts, build->type, shape);
}

static bool is_same_shape(const struct build_shape *a, const struct build_shape *b)
{
    return a->low == b->low && a->high == b->high;
}

/* A member of a build of one type of geometry that becomes another value, and what that makes. */
struct change {
    VkGeometryTypeKHR geometry_type;
    size_t offset, size;
    uint64_t value;
    const char *name;
    enum outcome { OTHER_SHAPE, SAME_SHAPE, NO_SHAPE } outcome;
};
#define CHANGE(type, member, value, outcome)                                                       \
    {                                                                                              \
        VK_GEOMETRY_TYPE_##type##_KHR, offsetof(struct build, member),                             \
            sizeof(((struct build *)0)->member), value, #member, outcome                           \
    }
#define TRIANGLES_OF(i) geometries[i].geometry.triangles
#define UPDATE_MODE VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
#define COMPACTION VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR

static const struct change changes[] = {
    /* What the sizes depend on (VkAccelerationStructureBuildSizesInfoKHR). */
    CHANGE(TRIANGLES, type, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, OTHER_SHAPE),
    CHANGE(TRIANGLES, info.type, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, OTHER_SHAPE),
    CHANGE(TRIANGLES, info.flags, COMPACTION, OTHER_SHAPE),
    CHANGE(TRIANGLES, info.geometryCount, GEOMETRIES - 1, OTHER_SHAPE),
    CHANGE(TRIANGLES, info.geometryCount, 0, OTHER_SHAPE),
    CHANGE(TRIANGLES, counts[0], 6, OTHER_SHAPE),
    CHANGE(TRIANGLES, counts[GEOMETRIES - 1], 8, OTHER_SHAPE),
    CHANGE(TRIANGLES, counts, 6 | UINT64_C(5) << 32, OTHER_SHAPE), /* exchanged */
    CHANGE(TRIANGLES, geometries[0].flags, VK_GEOMETRY_OPAQUE_BIT_KHR, OTHER_SHAPE),
    CHANGE(TRIANGLES, geometries[2].flags, VK_GEOMETRY_OPAQUE_BIT_KHR, OTHER_SHAPE),
    CHANGE(TRIANGLES, geometries[1].geometryType, VK_GEOMETRY_TYPE_AABBS_KHR, OTHER_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(0).vertexFormat, VK_FORMAT_R16G16B16A16_SFLOAT, OTHER_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(1).vertexStride, 16, OTHER_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(1).vertexStride, 12 + (1ull << 32), OTHER_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(2).maxVertex, 98, OTHER_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(0).indexType, VK_INDEX_TYPE_NONE_KHR, OTHER_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(2).transformData, 16, OTHER_SHAPE),
    CHANGE(AABBS, geometries[1].geometry.aabbs.stride, 32, OTHER_SHAPE),
    CHANGE(AABBS, counts[GEOMETRIES - 1], 8, OTHER_SHAPE),
    CHANGE(AABBS, info.flags, COMPACTION, OTHER_SHAPE),
    CHANGE(INSTANCES, geometries[1].geometry.instances.arrayOfPointers, VK_TRUE, OTHER_SHAPE),
    CHANGE(INSTANCES, counts[0], 6, OTHER_SHAPE),
    /* And what they do not. */
    CHANGE(TRIANGLES, counts[0], 5, SAME_SHAPE), /* nothing changes */
    CHANGE(AABBS, counts[0], 5, SAME_SHAPE),
    CHANGE(INSTANCES, counts[0], 5, SAME_SHAPE),
    CHANGE(TRIANGLES, info.mode, UPDATE_MODE, SAME_SHAPE),
    CHANGE(TRIANGLES, info.srcAccelerationStructure, 7, SAME_SHAPE),
    CHANGE(TRIANGLES, info.dstAccelerationStructure, 8, SAME_SHAPE),
    CHANGE(TRIANGLES, info.scratchData, 0x100, SAME_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(0).vertexData, 0x100, SAME_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(1).indexData, 0x100, SAME_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(1).transformData, 0x2000, SAME_SHAPE), /* it has one before */
    CHANGE(AABBS, geometries[2].geometry.aabbs.data, 0x100, SAME_SHAPE),
    CHANGE(AABBS, TRIANGLES_OF(0).vertexStride, 0x5a, SAME_SHAPE), /* of another type */
    CHANGE(AABBS, TRIANGLES_OF(0).maxVertex, 0x5a, SAME_SHAPE),
    CHANGE(AABBS, TRIANGLES_OF(0).indexType, 0x5a, SAME_SHAPE),
    CHANGE(AABBS, TRIANGLES_OF(0).transformData, 0x5a, SAME_SHAPE),
    CHANGE(INSTANCES, geometries[2].geometry.instances.data, 0x100, SAME_SHAPE),
    /* Nothing is known of what is chained. */
    CHANGE(TRIANGLES, info.pNext, 0x1000, NO_SHAPE),
    CHANGE(TRIANGLES, geometries[0].pNext, 0x1000, NO_SHAPE),
    CHANGE(TRIANGLES, geometries[2].pNext, 0x1000, NO_SHAPE),
    CHANGE(TRIANGLES, TRIANGLES_OF(2).pNext, 0x1000, NO_SHAPE),
    CHANGE(AABBS, TRIANGLES_OF(1).pNext, 0x1000, NO_SHAPE),
    CHANGE(INSTANCES, TRIANGLES_OF(0).pNext, 0x1000, NO_SHAPE),
    CHANGE(TRIANGLES, geometries[1].geometryType, VK_GEOMETRY_TYPE_SPHERES_NV, NO_SHAPE),
};

TEST(a_change_makes_another_shape_or_none_or_does_not_matter)
{
    for (size_t i = 0; i < sizeof(changes) / sizeof(changes[0]); i++) {
        const struct change *change = &changes[i];
        struct build original = a_build(change->geometry_type), changed = original;
        struct build_shape shape, other;
        memcpy((char *)&changed + change->offset, &change->value,
               change->size < 8 ? change->size : 8);
        assert_true(shape_of(&original, &shape));
        const enum outcome outcome = !shape_of(&changed, &other)     ? NO_SHAPE
                                     : is_same_shape(&shape, &other) ? SAME_SHAPE
                                                                     : OTHER_SHAPE;
        if (outcome != change->outcome)
            fail_msg("%s = %#llx: %d", change->name, (unsigned long long)change->value, outcome);
    }
}

TEST(an_array_of_pointers_has_the_shape_of_an_array)
{
    struct build build = a_build(VK_GEOMETRY_TYPE_TRIANGLES_KHR);
    struct build_shape shape, other;
    assert_true(shape_of(&build, &shape));
    for (int i = 0; i < GEOMETRIES; i++)
        build.pointers[i] = &build.geometries[i];
    build.info.pGeometries = NULL;
    build.info.ppGeometries = build.pointers;
    assert_true(build_shape_of(&build.info, build.counts, build.type, &other));
    assert_true(is_same_shape(&shape, &other));
}

static struct size_facts sizes_of(const struct build_shape *shape)
{
    return (struct size_facts){.known = true,
                               .acceleration_structure = shape->low,
                               .build_scratch = shape->high,
                               .update_scratch = ~shape->low};
}

static bool are_sizes_of(const struct size_facts *sizes, const struct build_shape *shape)
{
    return sizes->known && sizes->acceleration_structure == shape->low &&
           sizes->build_scratch == shape->high && sizes->update_scratch == ~shape->low;
}

struct sharer {
    struct size_cache *cache;
    struct random random;
    bool is_alone;
    unsigned found, wrong;
};

/* Finds and adds shapes. Those that take the same entry differ in their other half, or in high bits
 * of this one. A cache that no other thread uses has what was added last. */
static void *share(void *context)
{
    struct sharer *sharer = context;
    for (int step = 0; step < 10000; step++) {
        const struct build_shape shape = {.low = random_below(&sharer->random, 2048) |
                                                 (uint64_t)random_below(&sharer->random, 2) << 40,
                                          .high = random_below(&sharer->random, 2)};
        struct size_facts sizes;
        if (size_cache_find(sharer->cache, &shape, &sizes)) {
            sharer->wrong += !are_sizes_of(&sizes, &shape);
            sharer->found++;
        }
        sizes = sizes_of(&shape);
        size_cache_add(sharer->cache, &shape, &sizes);
        if (sharer->is_alone)
            sharer->wrong +=
                !size_cache_find(sharer->cache, &shape, &sizes) || !are_sizes_of(&sizes, &shape);
    }
    return NULL;
}

TEST(only_what_was_added_is_found_by_one_thread_and_by_several)
{
    enum { THREADS = 4 };
    const struct build_shape zero = {0};
    struct random random = random_of("size_cache");
    struct size_facts sizes;
    for (size_t threads = 1; threads <= THREADS; threads += THREADS - 1) {
        struct sharer sharers[THREADS];
        struct size_cache *cache;
        assert_int_equal(size_cache_create(&cache), VK_SUCCESS);
        assert_false(size_cache_find(cache, &zero, &sizes));
        for (size_t i = 0; i < threads; i++)
            sharers[i] = (struct sharer){
                .cache = cache, .random = {random_next(&random)}, .is_alone = threads == 1};
        unit_test_run_threads(threads, share, sharers, sizeof(sharers[0]));
        for (size_t i = 0; i < threads; i++) {
            assert_int_equal(sharers[i].wrong, 0);
            assert_true(sharers[i].found > 500);
        }
        size_cache_destroy(cache);
    }
    size_cache_destroy(NULL);
}
