/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what is known of structures of VK_NV_ray_tracing, and of buffers by their handles. */
#include "src/state/resources/nv_shape.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"

enum { OBJECT = 0x1000, MEMORY = 1 << 20 }; /* have_memory's size */

static VkAccelerationStructureNV nv(unsigned n)
{
    return (VkAccelerationStructureNV)(uintptr_t)(0x400 + n);
}

static const VkGeometryNV geometries[] = {
    {.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_NV,
     .geometry = {.triangles = {.vertexCount = 5, .indexCount = 6}, .aabbs = {.numAABBs = 7}}},
    {.geometryType = VK_GEOMETRY_TYPE_AABBS_NV,
     .geometry = {.triangles = {.vertexCount = 5, .indexCount = 6}, .aabbs = {.numAABBs = 7}}},
    {.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
     .geometry = {.triangles = {.vertexCount = 5, .indexCount = 6}, .aabbs = {.numAABBs = 7}}},
};

static const VkAccelerationStructureInfoNV info = {
    .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
    .flags = VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_NV,
    .instanceCount = 9,
    .geometryCount = 3,
    .pGeometries = geometries,
};

static void have_nv(struct resources *resources, unsigned n)
{
    const struct nv_size_facts sizes = {
        .known = true, .object = OBJECT, .build_scratch = 2, .update_scratch = 3};
    resources_add_nv_accel(resources, nv(n), nv_shape_create(&info), &sizes);
}

/* The caller has no use for the reference. */
static struct nv_accel_facts nv_facts(struct resources *resources, unsigned n)
{
    struct nv_accel_facts facts;
    resources_look_up_nv_accel(resources, nv(n), &facts);
    nv_shape_release(facts.created);
    return facts;
}

static struct buffer_facts buffer_facts(struct resources *resources, unsigned n)
{
    struct buffer_facts facts;
    resources_look_up_buffer(resources, buffer(n), &facts);
    return facts;
}

static void assert_binding(struct resources *resources, unsigned n, enum nv_binding binding)
{
    struct nv_accel_facts facts = nv_facts(resources, n);
    assert_int_equal(facts.binding, binding);
    if (binding != NV_BOUND)
        assert_null(facts.span.memory);
}

TEST(test_a_structure_has_its_details)
{
    struct resources *resources = no_resources();
    have_nv(resources, 1);
    struct nv_accel_facts facts;
    resources_find_nv_accel(resources, nv(1), &facts);
    assert_int_equal(facts.alive, YES);
    assert_int_equal(facts.id, resources_find_id(resources, RESOURCE_ACCEL_NV, 0x401));
    assert_true(facts.sizes.known && facts.sizes.object == OBJECT);
    resources_remove_nv_accel(resources, nv(1)); /* the copy outlives it */
    resources_destroy(resources);
    assert_int_equal(facts.created->type, info.type);
    assert_int_equal(facts.created->flags, info.flags);
    assert_int_equal(facts.created->instance_count, 9);
    assert_int_equal(facts.created->geometry_count, 3);
    const struct nv_counts *counts = facts.created->geometries;
    assert_true(counts[0].vertices == 5 && counts[0].indices == 6 && counts[0].aabbs == 0);
    assert_true(counts[1].vertices == 0 && counts[1].indices == 0 && counts[1].aabbs == 7);
    assert_true(counts[2].vertices == 0 && counts[2].indices == 0 && counts[2].aabbs == 0);
    nv_shape_release(facts.created);
}

RESOURCES_TEST(test_handles_are_of_their_extension)
{
    have_nv(resources, 1);
    have_accel(resources, 1, 0, 0, 16);
    assert_int_equal(nv_facts(resources, 2).alive, NO);
    assert_int_equal(resources_find_id(resources, RESOURCE_ACCEL, 0x401), 0);
    assert_int_equal(resources_find_id(resources, RESOURCE_ACCEL_NV, 0x301), 0);
    assert_int_not_equal(nv_facts(resources, 1).id, accel_facts(resources, 1).id);
}

RESOURCES_TEST(test_a_handle_that_is_used_again_is_another_structure)
{
    have_memory(resources, 1);
    have_nv(resources, 1);
    resources_bind_nv_accel(resources, nv(1), memory(1), 0, false);
    uint64_t id = nv_facts(resources, 1).id, deaths = resources_destroy_count(resources);
    have_nv(resources, 1);
    assert_int_not_equal(nv_facts(resources, 1).id, id);
    assert_true(resources_destroy_count(resources) > deaths);
    assert_binding(resources, 1, NV_UNBOUND);
    assert_int_not_equal(resources_remove_nv_accel(resources, nv(1)), 0);
    assert_int_equal(resources_remove_nv_accel(resources, nv(1)), 0);
    assert_int_equal(nv_facts(resources, 1).alive, NO);
}

RESOURCES_TEST(test_a_handle_that_is_used_again_is_another_micromap)
{
    const VkMicromapEXT micromap = (VkMicromapEXT)(uintptr_t)0x501;
    const VkMicromapCreateInfoEXT created = {.size = 16};
    resources_add_micromap(resources, micromap, &created);
    const uint64_t id = resources_find_id(resources, RESOURCE_MICROMAP, 0x501);
    const uint64_t deaths = resources_destroy_count(resources);
    resources_add_micromap(resources, micromap, &created);
    assert_int_not_equal(resources_find_id(resources, RESOURCE_MICROMAP, 0x501), id);
    assert_true(resources_destroy_count(resources) > deaths);
    assert_int_not_equal(resources_remove_micromap(resources, micromap), 0);
    assert_int_equal(resources_remove_micromap(resources, micromap), 0);
}

RESOURCES_TEST(test_where_a_structure_lies)
{
    have_memory(resources, 1);
    have_nv(resources, 1);
    assert_binding(resources, 1, NV_UNBOUND);
    resources_bind_nv_accel(resources, nv(1), memory(1), 0x100, false);
    assert_binding(resources, 1, NV_BOUND);
    assert_span(nv_facts(resources, 1).span, 1, 0x100, 0x100 + OBJECT);

    resources_bind_nv_accel(resources, nv(1), memory(1), 0x100, true);
    struct nv_accel_facts facts = nv_facts(resources, 1);
    assert_int_equal(facts.binding, NV_BOUND);
    assert_null(facts.span.memory);

    resources_bind_nv_accel(resources, nv(1), memory(1), MEMORY - OBJECT, false);
    assert_binding(resources, 1, NV_BOUND);
    resources_bind_nv_accel(resources, nv(1), memory(1), MEMORY - OBJECT + 1, false);
    assert_binding(resources, 1, NV_MEMORY_TOO_SMALL);
    resources_bind_nv_accel(resources, nv(1), memory(1), UINT64_MAX, false);
    assert_binding(resources, 1, NV_MEMORY_TOO_SMALL);
}

RESOURCES_TEST(test_memory_that_goes_away)
{
    have_memory(resources, 1);
    have_nv(resources, 1);
    have_nv(resources, 2);
    resources_bind_nv_accel(resources, nv(1), memory(1), 0, false);
    resources_bind_nv_accel(resources, nv(2), memory(2), 0, false);
    assert_binding(resources, 2, NV_BINDING_UNKNOWN); /* of memory that was never allocated */
    resources_remove_memory(resources, memory(1));
    assert_binding(resources, 1, NV_MEMORY_FREED);
    have_memory(resources, 1);
    assert_binding(resources, 1, NV_MEMORY_FREED); /* the new one is another */
    resources_forget_nv_binding(resources, nv(1));
    assert_binding(resources, 1, NV_BINDING_UNKNOWN);
    resources_forget_nv_binding(resources, nv(7));
    resources_bind_nv_accel(resources, nv(7), memory(1), 0, false);
}

RESOURCES_TEST(test_imported_memory_may_be_of_any_size)
{
    resources_add_memory(resources, memory(1), 0, 0, 0, false);
    have_nv(resources, 1);
    resources_bind_nv_accel(resources, nv(1), memory(1), 0, false);
    assert_binding(resources, 1, NV_BOUND);
}

static void assert_reference(struct resources *resources, uint64_t reference, uint64_t deaths,
                             enum nv_reference expected)
{
    assert_int_equal(resources_find_nv_reference(resources, reference, deaths), expected);
}

RESOURCES_TEST(test_references_of_what_was_destroyed)
{
    enum { REFERENCE = 0xabc0, SHARED = 0xdef0, NOBODYS = 0x1230 };
    have_nv(resources, 1);
    resources_add_nv_reference(resources, nv(1), REFERENCE);
    resources_add_nv_reference(resources, nv(1), REFERENCE); /* asked for twice */
    assert_reference(resources, REFERENCE, 0, NV_REFERENCE_BOTTOM_LEVEL);
    assert_reference(resources, NOBODYS, 0, NV_REFERENCE_INVALID);

    /* What was submitted before may have executed before. */
    uint64_t before = resources_destroy_count(resources);
    assert_int_not_equal(resources_remove_nv_accel(resources, nv(1)), 0);
    assert_reference(resources, REFERENCE, before, NV_REFERENCE_BOTTOM_LEVEL);
    assert_reference(resources, REFERENCE, resources_destroy_count(resources),
                     NV_REFERENCE_DESTROYED);

    /* A driver may use the value again. */
    have_nv(resources, 2);
    resources_add_nv_reference(resources, nv(2), REFERENCE);
    assert_reference(resources, REFERENCE, resources_destroy_count(resources),
                     NV_REFERENCE_BOTTOM_LEVEL);

    /* Two structures had this value, and one is alive. */
    have_nv(resources, 3);
    resources_add_nv_reference(resources, nv(2), SHARED);
    resources_add_nv_reference(resources, nv(3), SHARED);
    resources_remove_nv_accel(resources, nv(2));
    assert_reference(resources, SHARED, resources_destroy_count(resources),
                     NV_REFERENCE_BOTTOM_LEVEL);

    /* The device has no such structure, so nothing is known to be destroyed. */
    resources_add_nv_reference(resources, nv(9), NOBODYS);
    resources_remove_nv_accel(resources, nv(9));
    assert_reference(resources, NOBODYS, resources_destroy_count(resources), NV_REFERENCE_UNKNOWN);
}

RESOURCES_TEST(test_old_references_are_forgotten)
{
    int blocks = 0;
    uint64_t before = 0;
    for (unsigned i = 1; i <= 2 * MANY_REFERENCES; i++) {
        have_nv(resources, 1);
        resources_add_nv_reference(resources, nv(1), i);
        resources_remove_nv_accel(resources, nv(1));
        if (i == MANY_REFERENCES) {
            blocks = allocations_now();
            before = resources_destroy_count(resources);
        }
    }
    const uint64_t now = resources_destroy_count(resources);
    assert_int_equal(allocations_now(), blocks);
    assert_reference(resources, 2 * MANY_REFERENCES, now, NV_REFERENCE_DESTROYED);
    assert_reference(resources, MANY_REFERENCES, now, NV_REFERENCE_INVALID);
    /* A submission from then may refer to what was alive. */
    assert_reference(resources, MANY_REFERENCES, before, NV_REFERENCE_UNKNOWN);
    assert_reference(resources, 2 * MANY_REFERENCES, before, NV_REFERENCE_UNKNOWN);
}

TEST(test_geometries_that_cannot_be_read)
{
    VkAccelerationStructureInfoNV bad = info;
    bad.pGeometries = (const VkGeometryNV *)16;
    assert_null(nv_shape_create(&bad));
    bad.pGeometries = NULL;
    assert_null(nv_shape_create(&bad));
    bad.geometryCount = 0;
    nv_shape_release(nv_shape_create(&bad));
    nv_shape_release(NULL);
    assert_null(nv_shape_share(NULL));
}

TEST(test_without_memory)
{
    bool failed = true;
    for (int i = 0; failed; i++) {
        struct resources *resources = no_resources();
        memory_fail_after(i);
        have_nv(resources, 1);
        failed = memory_fail_no_more();
        struct nv_accel_facts facts = nv_facts(resources, 1);
        assert_true(facts.alive == YES || (failed && facts.alive == UNKNOWN));
        assert_true(facts.alive == YES || nv_facts(resources, 2).alive == UNKNOWN);
        resources_destroy(resources);
    }
}

RESOURCES_TEST(test_buffers_by_handle)
{
    have_buffer(resources, 1, 0x123, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    struct buffer_facts facts = buffer_facts(resources, 1);
    assert_int_equal(facts.alive, YES);
    assert_int_equal(facts.size, 0x123);
    assert_int_equal(facts.usage, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    assert_int_equal(facts.id, resources_find_id(resources, RESOURCE_BUFFER, 0x201));
    assert_int_equal(buffer_facts(resources, 2).alive, NO);
    assert_int_equal(buffer_facts(resources, 0).alive, UNKNOWN);
    resources_remove_buffer(resources, buffer(1));
    assert_int_equal(buffer_facts(resources, 1).alive, NO);
    assert_int_equal(buffer_facts(resources, 1).id, 0);
}
