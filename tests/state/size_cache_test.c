/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the cache of build sizes: what makes a shape, and what doesn't. */
#include <stdatomic.h>
#include <string.h>

#include "random.h"
#include "src/state/builds/size_cache.h"
#include "tests/fixture/make.h"
#include "tests/state/unit_test.h"

enum { GEOMETRIES = 3 };

/* A build, in arrays of its own so that a test can change one member. */
struct build {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometries[GEOMETRIES];
    const VkAccelerationStructureGeometryKHR *pointers[GEOMETRIES];
    uint32_t counts[GEOMETRIES];
    VkAccelerationStructureBuildTypeKHR type;
};

static void set_triangles(VkAccelerationStructureGeometryKHR *geometry)
{
    *geometry = MAKE(
        VkAccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .geometry.triangles = MAKE(VkAccelerationStructureGeometryTrianglesDataKHR,
                                   .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexStride = 12,
                                   .maxVertex = 99, .indexType = VK_INDEX_TYPE_UINT32));
}

static void set_aabbs(VkAccelerationStructureGeometryKHR *geometry)
{
    *geometry =
        MAKE(VkAccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_AABBS_KHR,
             .geometry.aabbs = MAKE(VkAccelerationStructureGeometryAabbsDataKHR, .stride = 24));
}

static void set_instances(VkAccelerationStructureGeometryKHR *geometry)
{
    *geometry =
        MAKE(VkAccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
             .geometry.instances = MAKE(VkAccelerationStructureGeometryInstancesDataKHR));
}

static struct build a_build(void (*set)(VkAccelerationStructureGeometryKHR *geometry))
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
        set(&build.geometries[i]);
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

typedef void (*change)(struct build *build);

/* ---- what the sizes depend on (VkAccelerationStructureBuildSizesInfoKHR), each a change */

#define CHANGE(name, statement)                                                                    \
    static void change_##name(struct build *build)                                                 \
    {                                                                                              \
        statement;                                                                                 \
    }

CHANGE(build_type, build->type = VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR)
CHANGE(type, build->info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR)
CHANGE(flags, build->info.flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR)
CHANGE(geometry_count, build->info.geometryCount--)
CHANGE(no_geometry, build->info.geometryCount = 0)
CHANGE(first_count, build->counts[0]++)
CHANGE(last_count, build->counts[GEOMETRIES - 1]++)
CHANGE(exchanged_counts, build->counts[1] = 7; build->counts[2] = 6)
CHANGE(first_flags, build->geometries[0].flags = VK_GEOMETRY_OPAQUE_BIT_KHR)
CHANGE(last_flags, build->geometries[2].flags = VK_GEOMETRY_OPAQUE_BIT_KHR)
CHANGE(geometry_type, set_aabbs(&build->geometries[1]))
CHANGE(vertex_format,
       build->geometries[0].geometry.triangles.vertexFormat = VK_FORMAT_R16G16B16A16_SFLOAT)
CHANGE(vertex_stride, build->geometries[1].geometry.triangles.vertexStride = 16)
CHANGE(large_stride, build->geometries[1].geometry.triangles.vertexStride = 12 + (1ull << 32))
CHANGE(max_vertex, build->geometries[2].geometry.triangles.maxVertex = 98)
CHANGE(index_type, build->geometries[0].geometry.triangles.indexType = VK_INDEX_TYPE_NONE_KHR)
CHANGE(transform, build->geometries[2].geometry.triangles.transformData.deviceAddress = 16)
CHANGE(aabb_stride, build->geometries[1].geometry.aabbs.stride = 32)
CHANGE(array_of_pointers, build->geometries[1].geometry.instances.arrayOfPointers = VK_TRUE)

/* ---- and what they do not */

CHANGE(nothing, (void)build)
CHANGE(mode, build->info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR)
CHANGE(src, build->info.srcAccelerationStructure = (VkAccelerationStructureKHR)(uintptr_t)7)
CHANGE(dst, build->info.dstAccelerationStructure = (VkAccelerationStructureKHR)(uintptr_t)8)
CHANGE(scratch, build->info.scratchData.deviceAddress = 0x100)
CHANGE(vertices, build->geometries[0].geometry.triangles.vertexData.deviceAddress = 0x100)
CHANGE(indices, build->geometries[1].geometry.triangles.indexData.deviceAddress = 0x100)
CHANGE(aabbs, build->geometries[2].geometry.aabbs.data.deviceAddress = 0x100)
CHANGE(instances, build->geometries[2].geometry.instances.data.deviceAddress = 0x100)

static void assert_all(const change *changes, size_t count, const struct build *build,
                       bool expected)
{
    for (size_t i = 0; i < count; i++) {
        struct build original = *build, changed = *build;
        changes[i](&changed);
        if (same_shape(&original, &changed) != expected)
            fail_msg("change %zu makes %s shape", i, expected ? "another" : "the same");
    }
}

#define ASSERT_ALL(changes, build, expected)                                                       \
    assert_all(changes, sizeof(changes) / sizeof(changes[0]), build, expected)

TEST(test_what_matters_makes_another_shape)
{
    const struct build triangles = a_build(set_triangles), aabbs = a_build(set_aabbs),
                       instances = a_build(set_instances);
    const change to_triangles[] = {
        change_build_type,    change_type,         change_flags,         change_geometry_count,
        change_no_geometry,   change_first_count,  change_last_count,    change_exchanged_counts,
        change_first_flags,   change_last_flags,   change_geometry_type, change_vertex_format,
        change_vertex_stride, change_large_stride, change_max_vertex,    change_index_type,
        change_transform,
    };
    const change to_aabbs[] = {change_aabb_stride, change_last_count, change_flags};
    const change to_instances[] = {change_array_of_pointers, change_first_count};
    ASSERT_ALL(to_triangles, &triangles, false);
    ASSERT_ALL(to_aabbs, &aabbs, false);
    ASSERT_ALL(to_instances, &instances, false);
}

TEST(test_what_does_not_matter_leaves_the_shape)
{
    const struct build triangles = a_build(set_triangles), aabbs = a_build(set_aabbs),
                       instances = a_build(set_instances);
    const change to_triangles[] = {change_nothing, change_mode,     change_src,    change_dst,
                                   change_scratch, change_vertices, change_indices};
    const change to_aabbs[] = {change_nothing, change_aabbs};
    const change to_instances[] = {change_nothing, change_instances};
    ASSERT_ALL(to_triangles, &triangles, true);
    ASSERT_ALL(to_aabbs, &aabbs, true);
    ASSERT_ALL(to_instances, &instances, true);
}

/* Only whether there is a transform matters. */
TEST(test_two_transforms_have_one_shape)
{
    struct build a = a_build(set_triangles), b = a;
    a.geometries[0].geometry.triangles.transformData.deviceAddress = 0x100;
    b.geometries[0].geometry.triangles.transformData.deviceAddress = 0x2000;
    assert_true(same_shape(&a, &b));
}

/* What a geometry's union holds beside the member that its type selects is nobody's. */
TEST(test_the_rest_of_the_union_does_not_matter)
{
    struct build a = a_build(set_aabbs), b = a;
    memset((char *)&b.geometries[0].geometry + sizeof(b.geometries[0].geometry.aabbs), 0x5a,
           sizeof(b.geometries[0].geometry) - sizeof(b.geometries[0].geometry.aabbs));
    assert_true(same_shape(&a, &b));
}

TEST(test_an_array_of_pointers_has_the_shape_of_an_array)
{
    struct build a = a_build(set_triangles), b = a;
    struct build_shape x, y;
    for (int i = 0; i < GEOMETRIES; i++)
        b.pointers[i] = &b.geometries[i];
    b.info.ppGeometries = b.pointers;
    assert_true(shape_of(&a, &x));
    assert_true(build_shape_of(&b.info, b.counts, b.type, &y));
    assert_true(x.low == y.low && x.high == y.high);
}

TEST(test_chains_have_no_shape)
{
    const VkBaseInStructure other = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
    void (*const sets[])(VkAccelerationStructureGeometryKHR *) = {set_triangles, set_aabbs,
                                                                  set_instances};
    struct build_shape shape;
    struct build build = a_build(set_triangles);
    build.info.pNext = &other;
    assert_false(shape_of(&build, &shape));
    for (int i = 0; i < GEOMETRIES; i++) {
        build = a_build(set_triangles);
        build.geometries[i].pNext = &other;
        assert_false(shape_of(&build, &shape));
        for (int j = 0; j < 3; j++) {
            build = a_build(sets[j]);
            build.geometries[i].geometry.triangles.pNext = &other; /* of any type of data */
            assert_false(shape_of(&build, &shape));
        }
        build = a_build(set_triangles);
        build.geometries[i].geometryType = VK_GEOMETRY_TYPE_SPHERES_NV;
        assert_false(shape_of(&build, &shape));
    }
}

/* ---- the cache */

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
static struct build_shape some_shape(struct random *random)
{
    return (struct build_shape){.low = random_below(random, 2048) |
                                       (uint64_t)random_below(random, 2) << 40,
                                .high = random_below(random, 2)};
}

TEST(test_it_answers_only_what_it_was_told)
{
    struct random random = random_of("size_cache");
    struct size_cache *cache;
    assert_int_equal(size_cache_create(&cache), VK_SUCCESS);
    const struct build_shape zero = {0};
    struct size_facts sizes;
    assert_false(size_cache_find(cache, &zero, &sizes));
    unsigned found = 0;
    for (int step = 0; step < 50000; step++) {
        struct build_shape shape = some_shape(&random);
        if (size_cache_find(cache, &shape, &sizes)) {
            assert_true(are_sizes_of(&sizes, &shape));
            found++;
            continue;
        }
        sizes = sizes_of(&shape);
        size_cache_add(cache, &shape, &sizes);
        memset(&sizes, 0, sizeof(sizes));
        assert_true(size_cache_find(cache, &shape, &sizes));
        assert_true(are_sizes_of(&sizes, &shape));
    }
    assert_true(found > 1000);
    size_cache_destroy(cache);
    size_cache_destroy(NULL);
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
        struct build_shape shape = some_shape(&sharer->random);
        struct size_facts sizes;
        if (size_cache_find(sharer->cache, &shape, &sizes))
            sharer->wrong += !are_sizes_of(&sizes, &shape);
        sizes = sizes_of(&shape);
        size_cache_add(sharer->cache, &shape, &sizes);
    }
    return NULL;
}

TEST(test_threads_share_it)
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
