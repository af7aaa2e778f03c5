/* SPDX-License-Identifier: Apache-2.0 */
/* Where structures without a handle may be: at several addresses of the same bytes, too. */
#include "src/state/builds/places.h"

#include "tests/state/fixture.h"

enum { FIRST = 0x100000, SECOND = 0x200000, SIZE = 0x400, BUILT = 0x100, BUILT_SIZE = 0x80 };

static struct resources *resources;

static void have_address(unsigned n, VkDeviceSize offset, VkDeviceAddress address)
{
    have_bound_buffer(resources, n, SIZE, VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, 1, offset);
    resources_set_address(resources, buffer(n), address);
}

/* Two buffers share the memory from its byte 0x100 on. */
static struct places *make(void)
{
    resources = no_resources();
    have_memory(resources, 1);
    have_address(1, 0, FIRST);
    have_address(2, 0x100, SECOND);
    struct places *places = places_create(resources);
    assert_non_null(places);
    return places;
}

static void end(struct places *places)
{
    places_destroy(places);
    resources_destroy(resources);
}

static bool may_hold(struct places *places, VkDeviceAddress address)
{
    return places_may_hold(places, PLACE_CLUSTER, address, resources_destroy_count(resources));
}

static void add(struct places *places, enum place_kind kind, VkDeviceAddress address,
                VkDeviceSize size)
{
    places_add(places, &(struct placed){.kind = kind, .address = address, .size = size});
}

#define PLACES_TEST(name) TEST_WITH(name, struct places *places, make, end)

PLACES_TEST(bytes_have_several_addresses)
{
    assert_false(places_are_used(places, PLACE_CLUSTER));
    assert_false(may_hold(places, FIRST + BUILT));
    add(places, PLACE_CLUSTER, FIRST + BUILT, BUILT_SIZE);
    add(places, PLACE_CLUSTER, FIRST + BUILT + 0x40, 1);
    assert_true(places_are_used(places, PLACE_CLUSTER));
    for (unsigned i = 0; i < 2; i++) {
        assert_false(may_hold(places, SECOND - 1)); /* nowhere */
        assert_true(may_hold(places, SECOND));
        assert_true(may_hold(places, SECOND + BUILT_SIZE - 1));
        assert_false(may_hold(places, SECOND + BUILT_SIZE));
        assert_true(may_hold(places, FIRST + BUILT));
        assert_false(may_hold(places, FIRST + BUILT - 1));
        assert_false(may_hold(places, FIRST + BUILT + BUILT_SIZE));
        assert_false(
            places_may_hold(places, PLACE_TEMPLATE, SECOND, resources_destroy_count(resources)));
        resources_remove_buffer(resources, buffer(1)); /* the bytes stay */
    }
}

PLACES_TEST(an_address_has_other_bytes)
{
    add(places, PLACE_CLUSTER, FIRST + BUILT, BUILT_SIZE);
    resources_remove_buffer(resources, buffer(1));
    have_address(1, 0x200, FIRST);
    assert_true(may_hold(places, FIRST + BUILT)); /* a command writes to the address */
    assert_true(may_hold(places, SECOND));
    assert_false(may_hold(places, SECOND + 0x200));
    add(places, PLACE_CLUSTER, FIRST + BUILT, BUILT_SIZE);
    assert_true(may_hold(places, SECOND + 0x200));
}

PLACES_TEST(other_devices_may_build_in_shared_memory)
{
    resources_share_memory(resources, memory(1));
    assert_true(may_hold(places, FIRST));
    assert_false(may_hold(places, FIRST - 1));
}

PLACES_TEST(what_was_destroyed_is_unknown)
{
    const uint64_t before = resources_destroy_count(resources);
    resources_remove_buffer(resources, buffer(2));
    assert_true(places_may_hold(places, PLACE_CLUSTER, FIRST, before));
    assert_false(may_hold(places, FIRST));
    assert_false(may_hold(places, SECOND));
}

PLACES_TEST(bytes_that_are_unknown_are_anywhere)
{
    have_sparse_buffer(resources, 3, SIZE);
    resources_set_address(resources, buffer(3), 0x300000);
    assert_true(may_hold(places, 0x300000));
    assert_false(may_hold(places, FIRST));
    add(places, PLACE_CLUSTER, 0x300000, 1);
    assert_true(may_hold(places, FIRST));
    assert_false(places_may_hold(places, PLACE_TEMPLATE, FIRST, 0));
}

/* Two templates at one place, and a build of vertices of two formats. */
PLACES_TEST(templates_agree)
{
    const struct placed placed = {PLACE_TEMPLATE, VK_FORMAT_R32G32B32_SFLOAT, FIRST, 0x40};
    const struct placed other = {PLACE_TEMPLATE, VK_FORMAT_R32G32_SFLOAT, FIRST, 0x40};
    const uint64_t destroyed = resources_destroy_count(resources);
    places_add(places, &placed);
    assert_false(places_find_template(places, FIRST, destroyed).has_no_vertices);
    places_set_templates_read(places, FIRST, placed.format, false);
    assert_true(places_find_template(places, FIRST, destroyed).has_no_vertices);
    assert_int_equal(places_find_template(places, FIRST, destroyed).format, placed.format);
    assert_false(places_find_template(places, SECOND, destroyed).has_no_vertices);
    assert_false(places_find_template(places, FIRST, destroyed + 1).has_no_vertices);
    places_add(places, &other);
    assert_int_equal(places_find_template(places, FIRST, destroyed).format, placed.format);
    places_set_templates_read(places, FIRST, other.format, false);
    assert_int_equal(places_find_template(places, FIRST, destroyed).format, VK_FORMAT_UNDEFINED);
    assert_true(places_find_template(places, FIRST, destroyed).has_no_vertices);
    places_set_templates_read(places, FIRST, other.format, true);
    assert_false(places_find_template(places, FIRST, destroyed).has_no_vertices);
}

PLACES_TEST(builds_are_read_in_order)
{
    assert_int_equal(places_execute(places, PLACE_TEMPLATE), 0);
    assert_int_equal(places_execute(places, PLACE_CLUSTER), 1);
    assert_int_equal(places_execute(places, PLACE_PARTITIONED), 1);
    assert_int_equal(places_execute(places, PLACE_CLUSTER), 2);
    assert_true(places_are_read(places, 0));
    assert_false(places_are_read(places, 1));
    places_set_read(places, 0);
    assert_true(places_are_read(places, 1));
    places_set_read(places, 0); /* not again */
    assert_true(places_are_read(places, 1));
    places_set_read(places, 1);
    assert_true(places_are_read(places, 2));
}

PLACES_TEST(each_new_structure_has_an_instance)
{
    places_begin_instances(places);
    places_add_instance(places, 0, true, false);
    places_add_instance(places, 1, true, true);
    places_add_instance(places, 2, false, false);
    assert_true(places_instance_is_fixed(places, 0));
    assert_false(places_instance_is_fixed(places, 1));
    assert_false(places_instance_is_fixed(places, 2));
    places_begin_instances(places);
    assert_false(places_instance_is_fixed(places, 0));
    places_add_instance(places, 0, true, false);
    places_add_instance(places, 0, true, false);
    places_add_instance(places, 2, true, false);
    assert_true(places_instance_is_fixed(places, 0));
    assert_false(places_instance_is_fixed(places, 2));
    places_add_instance(places, 0, false, true);
    places_add_instance(places, 0, true, false);
    assert_false(places_instance_is_fixed(places, 0));
    assert_true(places_are_own(places, FIRST, resources_destroy_count(resources)));
    resources_share_memory(resources, memory(1));
    assert_false(places_are_own(places, FIRST, resources_destroy_count(resources)));
}

PLACES_TEST(devices_without_such_builds_have_none)
{
    assert_false(may_hold(NULL, FIRST));
    assert_false(places_are_used(NULL, PLACE_CLUSTER));
}
