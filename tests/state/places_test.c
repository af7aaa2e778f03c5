/* SPDX-License-Identifier: Apache-2.0 */
/* Where structures without a handle may be: at several addresses of the same bytes, too, to the
 * last byte. tests/programs/life/cluster_instances.cases has the rest. */
#include "src/state/builds/places.h"

#include "tests/state/fixture.h"

enum { FIRST = 0x100000, SECOND = 0x200000, PLACE_SIZE = 0x400, BUILT = 0x100, BUILT_SIZE = 0x80 };

static struct resources *resources;

static void have_address(unsigned n, VkDeviceSize offset, VkDeviceAddress address)
{
    have_bound_buffer(resources, n, PLACE_SIZE, VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, 1,
                      offset);
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

static void add_placed(struct places *places, enum place_kind kind, VkDeviceAddress address,
                       VkDeviceSize size)
{
    places_add(places, &(struct placed){.kind = kind, .address = address, .size = size});
}

#define PLACES_TEST(name) TEST_WITH(name, struct places *places, make, end)

PLACES_TEST(bytes_have_several_addresses)
{
    assert_false(places_are_used(places, PLACE_CLUSTER));
    assert_false(may_hold(places, FIRST + BUILT));
    add_placed(places, PLACE_CLUSTER, FIRST + BUILT, BUILT_SIZE);
    add_placed(places, PLACE_CLUSTER, FIRST + BUILT + 0x40, 1);
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
