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

#define PLACES_TEST(name) TEST_WITH(name, struct places *places, make, end)

PLACES_TEST(bytes_have_several_addresses)
{
    assert_false(places_are_used(places, PLACE_CLUSTER));
    assert_false(may_hold(places, FIRST + BUILT));
    places_add(places, PLACE_CLUSTER, FIRST + BUILT, BUILT_SIZE);
    places_add(places, PLACE_CLUSTER, FIRST + BUILT + 0x40, 1);
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
    places_add(places, PLACE_CLUSTER, FIRST + BUILT, BUILT_SIZE);
    resources_remove_buffer(resources, buffer(1));
    have_address(1, 0x200, FIRST);
    assert_true(may_hold(places, FIRST + BUILT)); /* a command writes to the address */
    assert_true(may_hold(places, SECOND));
    assert_false(may_hold(places, SECOND + 0x200));
    places_add(places, PLACE_CLUSTER, FIRST + BUILT, BUILT_SIZE);
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
    places_add(places, PLACE_CLUSTER, 0x300000, 1);
    assert_true(may_hold(places, FIRST));
    assert_false(places_may_hold(places, PLACE_TEMPLATE, FIRST, 0));
}

PLACES_TEST(devices_without_such_builds_have_none)
{
    assert_false(may_hold(NULL, FIRST));
    assert_false(places_are_used(NULL, PLACE_CLUSTER));
}
