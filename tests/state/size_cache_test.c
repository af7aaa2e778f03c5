/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the cache of build sizes: what makes a shape, and what doesn't. */
#include <stdlib.h>
#include <string.h>

#include "src/state/builds/size_cache.h"
#include "tests/fixture/geometry.h"
#include "tests/unit/property.h"
#include "tests/unit/random.h"

enum { GEOMETRIES = 3 };

/* A build, in arrays of its own so that a test can change one member. */
struct build {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometries[GEOMETRIES];
    const VkAccelerationStructureGeometryKHR *pointers[GEOMETRIES];
    uint32_t counts[GEOMETRIES];
    VkAccelerationStructureBuildTypeKHR type;
};

static const VkGeometryTypeKHR types[] = {
    VK_GEOMETRY_TYPE_TRIANGLES_KHR, VK_GEOMETRY_TYPE_AABBS_KHR, VK_GEOMETRY_TYPE_INSTANCES_KHR};

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
    return build;
}

static bool shape_of(struct build *build, struct build_shape *shape)
{
    build->info.pGeometries = build->geometries;
    return build_shape_of(&build->info, build->counts, build->type, shape);
}

static bool same_shape(struct build *a, struct build *b)
{
    struct build_shape x = {0}, y = {0};
    assert_true(shape_of(a, &x) && shape_of(b, &y));
    return x.low == y.low && x.high == y.high;
}

/* A member of a build of one type of geometry that becomes another value. */
struct change {
    VkGeometryTypeKHR geometry_type;
    size_t offset, size;
    uint64_t value;
    const char *name;
};
#define CHANGE(type, member, value)                                                                \
    {                                                                                              \
        VK_GEOMETRY_TYPE_##type##_KHR, offsetof(struct build, member),                             \
            sizeof(((struct build *)0)->member), value, #member                                    \
    }
#define TRIANGLES_OF(i) geometries[i].geometry.triangles

/* What the sizes depend on (VkAccelerationStructureBuildSizesInfoKHR). */
static const struct change other_shapes[] = {
    CHANGE(TRIANGLES, type, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR),
    CHANGE(TRIANGLES, info.type, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR),
    CHANGE(TRIANGLES, info.flags, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR),
    CHANGE(TRIANGLES, info.geometryCount, GEOMETRIES - 1),
    CHANGE(TRIANGLES, info.geometryCount, 0),
    CHANGE(TRIANGLES, counts[0], 6),
    CHANGE(TRIANGLES, counts[GEOMETRIES - 1], 8),
    CHANGE(TRIANGLES, counts, 6 | UINT64_C(5) << 32), /* exchanged */
    CHANGE(TRIANGLES, geometries[0].flags, VK_GEOMETRY_OPAQUE_BIT_KHR),
    CHANGE(TRIANGLES, geometries[2].flags, VK_GEOMETRY_OPAQUE_BIT_KHR),
    CHANGE(TRIANGLES, geometries[1].geometryType, VK_GEOMETRY_TYPE_AABBS_KHR),
    CHANGE(TRIANGLES, TRIANGLES_OF(0).vertexFormat, VK_FORMAT_R16G16B16A16_SFLOAT),
    CHANGE(TRIANGLES, TRIANGLES_OF(1).vertexStride, 16),
    CHANGE(TRIANGLES, TRIANGLES_OF(1).vertexStride, 12 + (1ull << 32)),
    CHANGE(TRIANGLES, TRIANGLES_OF(2).maxVertex, 98),
    CHANGE(TRIANGLES, TRIANGLES_OF(0).indexType, VK_INDEX_TYPE_NONE_KHR),
    CHANGE(TRIANGLES, TRIANGLES_OF(2).transformData, 16),
    CHANGE(AABBS, geometries[1].geometry.aabbs.stride, 32),
    CHANGE(AABBS, counts[GEOMETRIES - 1], 8),
    CHANGE(AABBS, info.flags, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR),
    CHANGE(INSTANCES, geometries[1].geometry.instances.arrayOfPointers, VK_TRUE),
    CHANGE(INSTANCES, counts[0], 6),
};

/* And what they do not. */
static const struct change same_shapes[] = {
    CHANGE(TRIANGLES, counts[0], 5), /* nothing changes */
    CHANGE(AABBS, counts[0], 5),
    CHANGE(INSTANCES, counts[0], 5),
    CHANGE(TRIANGLES, info.mode, VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR),
    CHANGE(TRIANGLES, info.srcAccelerationStructure, 7),
    CHANGE(TRIANGLES, info.dstAccelerationStructure, 8),
    CHANGE(TRIANGLES, info.scratchData, 0x100),
    CHANGE(TRIANGLES, TRIANGLES_OF(0).vertexData, 0x100),
    CHANGE(TRIANGLES, TRIANGLES_OF(1).indexData, 0x100),
    CHANGE(AABBS, geometries[2].geometry.aabbs.data, 0x100),
    CHANGE(INSTANCES, geometries[2].geometry.instances.data, 0x100),
};

static void assert_all(const struct change *changes, size_t count, bool expected)
{
    for (const struct change *change = changes; change < changes + count; change++) {
        struct build original = a_build(change->geometry_type), changed = original;
        const size_t size = change->size < 8 ? change->size : 8;
        memcpy((char *)&changed + change->offset, &change->value, size);
        if (same_shape(&original, &changed) != expected)
            fail_msg("%s = %#llx makes %s shape", change->name, (unsigned long long)change->value,
                     expected ? "another" : "the same");
    }
}

TEST(what_matters_makes_another_shape)
{
    assert_all(other_shapes, sizeof(other_shapes) / sizeof(other_shapes[0]), false);
}

TEST(what_does_not_matter_leaves_the_shape)
{
    assert_all(same_shapes, sizeof(same_shapes) / sizeof(same_shapes[0]), true);
}

/* Only whether there is a transform matters. */
TEST(two_transforms_have_one_shape)
{
    struct build a = a_build(VK_GEOMETRY_TYPE_TRIANGLES_KHR), b = a;
    a.geometries[0].geometry.triangles.transformData.deviceAddress = 0x100;
    b.geometries[0].geometry.triangles.transformData.deviceAddress = 0x2000;
    assert_true(same_shape(&a, &b));
}

/* The members of a geometry's union that its type does not select are ignored. */
TEST(the_rest_of_the_union_does_not_matter)
{
    struct build a = a_build(VK_GEOMETRY_TYPE_AABBS_KHR), b = a;
    memset((char *)&b.geometries[0].geometry + sizeof(b.geometries[0].geometry.aabbs), 0x5a,
           sizeof(b.geometries[0].geometry) - sizeof(b.geometries[0].geometry.aabbs));
    assert_true(same_shape(&a, &b));
}

TEST(an_array_of_pointers_has_the_shape_of_an_array)
{
    struct build a = a_build(VK_GEOMETRY_TYPE_TRIANGLES_KHR), b = a;
    struct build_shape x, y;
    for (int i = 0; i < GEOMETRIES; i++)
        b.pointers[i] = &b.geometries[i];
    b.info.ppGeometries = b.pointers;
    assert_true(shape_of(&a, &x));
    assert_true(build_shape_of(&b.info, b.counts, b.type, &y));
    assert_true(x.low == y.low && x.high == y.high);
}

TEST(chains_have_no_shape)
{
    const VkBaseInStructure other = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
    struct build_shape shape;
    struct build build = a_build(VK_GEOMETRY_TYPE_TRIANGLES_KHR);
    build.info.pNext = &other;
    assert_false(shape_of(&build, &shape));
    for (int i = 0; i < GEOMETRIES; i++) {
        build = a_build(VK_GEOMETRY_TYPE_TRIANGLES_KHR);
        build.geometries[i].pNext = &other;
        assert_false(shape_of(&build, &shape));
        for (int j = 0; j < 3; j++) {
            build = a_build(types[j]);
            build.geometries[i].geometry.triangles.pNext = &other; /* of any type of data */
            assert_false(shape_of(&build, &shape));
        }
        build = a_build(VK_GEOMETRY_TYPE_TRIANGLES_KHR);
        build.geometries[i].geometryType = VK_GEOMETRY_TYPE_SPHERES_NV;
        assert_false(shape_of(&build, &shape));
    }
}

static unsigned found;

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

/* Shapes that take the same entry differ in their other half, or in high bits of this one. */
static struct build_shape shape_at(const uint32_t *operands)
{
    return (struct build_shape){.low = operands[0] | (uint64_t)operands[1] << 40,
                                .high = operands[2]};
}

static void cache_begin(void *state)
{
    EXPECT(size_cache_create(state) == VK_SUCCESS);
    const struct build_shape zero = {0};
    EXPECT(!size_cache_find(*(struct size_cache **)state, &zero, &(struct size_facts){0}));
}

/* The cache answers only what was added to it, and what was added last. */
static void cache_find_or_add(void *state, const uint32_t *operands)
{
    struct size_cache *cache = *(struct size_cache **)state;
    const struct build_shape shape = shape_at(operands);
    struct size_facts sizes = {0};
    if (!size_cache_find(cache, &shape, &sizes)) {
        sizes = sizes_of(&shape);
        size_cache_add(cache, &shape, &sizes);
        sizes = (struct size_facts){0};
        EXPECT(size_cache_find(cache, &shape, &sizes));
    } else {
        found++;
    }
    EXPECT(are_sizes_of(&sizes, &shape));
}

static void cache_end(void *state)
{
    size_cache_destroy(*(struct size_cache **)state);
    size_cache_destroy(NULL);
}

PROPERTY_TEST(size_cache, .size = sizeof(struct size_cache *), .begin = cache_begin,
              .end = cache_end, .operations = {{"find_or_add", cache_find_or_add, {2048, 2, 2}, 1}},
              .sequences = 4, .steps = 10000)

TEST(sizes_are_found_again)
{
    assert_true(found > 1000 || getenv("ASSAY_TEST_STEPS"));
}

struct sharer {
    struct size_cache *cache;
    struct random random;
    unsigned wrong;
};

static void *share(void *context)
{
    struct sharer *sharer = context;
    for (int step = 0; step < 5000; step++) {
        const struct build_shape shape = shape_at(
            (const uint32_t[]){random_below(&sharer->random, 2048),
                               random_below(&sharer->random, 2), random_below(&sharer->random, 2)});
        struct size_facts sizes;
        if (size_cache_find(sharer->cache, &shape, &sizes))
            sharer->wrong += !are_sizes_of(&sizes, &shape);
        sizes = sizes_of(&shape);
        size_cache_add(sharer->cache, &shape, &sizes);
    }
    return NULL;
}

TEST(threads_share_it)
{
    enum { THREADS = 4 };
    struct random random = random_of("size_cache threads");
    struct sharer sharers[THREADS];
    struct size_cache *cache;
    assert_int_equal(size_cache_create(&cache), VK_SUCCESS);
    for (int i = 0; i < THREADS; i++)
        sharers[i] = (struct sharer){.cache = cache, .random = {random_next(&random)}};
    unit_test_run_threads(THREADS, share, sharers, sizeof(sharers[0]));
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(sharers[i].wrong, 0);
    size_cache_destroy(cache);
}
