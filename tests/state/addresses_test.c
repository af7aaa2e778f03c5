/* SPDX-License-Identifier: Apache-2.0 */
/* Addresses of buffers and structures beyond those of resources_test.c: details, the end of the
 * address space, and addresses of destroyed structures. */
#include "tests/fixture/make.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"

#define AT 0x7000000000u

RESOURCES_TEST(a_structure_has_its_details)
{
    have_buffer(resources, 1, 0x1000, 0);
    have_accel(resources, 2, 1, 0x100, 0x200);
    have_accel_at(resources, 3, AT, 0x200);
    const struct accel_facts facts = accel_facts(resources, 2);
    assert_false(facts.of_another_device);
    assert_int_equal(facts.type, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    assert_int_equal(facts.create_flags,
                     VK_ACCELERATION_STRUCTURE_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_KHR);
    assert_int_equal(accel_facts(resources, 3).type, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    assert_int_equal(accel_facts(resources, 0).alive, UNKNOWN); /* VK_NULL_HANDLE: nothing to say */
    assert_int_equal(resources_find_id(resources, RESOURCE_ACCEL, 0), 0);
    assert_int_equal(address_facts(resources, 0).status, ADDRESS_NULL);
    resources_remove_memory(resources, VK_NULL_HANDLE);
    resources_destroy(NULL);
}

RESOURCES_TEST(usage_may_have_64_bits)
{
    const VkBufferUsageFlags2 usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | 1ull << 40;
    const STRUCT(VkBufferCreateInfo, create_info,
                 .pNext = &MAKE(VkBufferUsageFlags2CreateInfo, .usage = usage), .size = 0x100,
                 .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    resources_add_buffer(resources, buffer(1), &create_info);
    resources_set_address(resources, buffer(1), AT);
    assert_true(address_facts(resources, AT).usage == usage);
}

/* A range whose end is unknown is not found. */
RESOURCES_TEST(a_buffer_at_the_end_of_the_address_space)
{
    have_memory(resources, 1);
    have_bound_buffer(resources, 2, 0x1000, 0, 1, 0);
    resources_set_address(resources, buffer(2), UINT64_MAX - 0x1000);
    assert_int_equal(address_facts(resources, UINT64_MAX - 1).status, ADDRESS_IN_BUFFER);
    assert_int_equal(address_facts(resources, UINT64_MAX).status, ADDRESS_NOWHERE);
    resources_set_address(resources, buffer(2), UINT64_MAX - 0xfff);
    assert_int_equal(address_facts(resources, UINT64_MAX).status, ADDRESS_UNKNOWN);
}

static bool is_alone(struct resources *resources, uint64_t handle)
{
    return resources_accel_is_alone(resources, accel(handle));
}

RESOURCES_TEST(a_structure_may_share_its_memory)
{
    have_memory(resources, 1);
    have_bound_buffer(resources, 2, 0x1000, 0, 1, 0x1000);
    have_accel(resources, 3, 2, 0x100, 0x200);
    have_accel(resources, 4, 2, 0x300, 0x200);
    assert_true(is_alone(resources, 3));
    assert_true(is_alone(resources, 4));
    have_accel(resources, 5, 2, 0x2ff, 1);
    assert_false(is_alone(resources, 3));
    assert_true(is_alone(resources, 4));
    resources_remove_accel(resources, accel(5));
    have_bound_buffer(resources, 6, 0x100, 0, 1, 0x1400);
    assert_true(is_alone(resources, 3));
    assert_false(is_alone(resources, 4));
    have_memory(resources, 7);
    have_bound_buffer(resources, 8, 0x1000, 0, 7, 0x1000); /* of other memory */
    assert_true(is_alone(resources, 3));
    have_buffer(resources, 9, 0x1000, 0);
    have_accel(resources, 10, 9, 0, 0x100);
    assert_false(is_alone(resources, 10)); /* bound to nothing that is known */
    assert_false(is_alone(resources, 11));
}

TEST(resources_need_memory)
{
    struct resources *resources;
    WITHOUT_MEMORY(assert_int_equal(resources_create(&resources), VK_ERROR_OUT_OF_HOST_MEMORY));
    assert_null(resources);
}

/* The last address counts, for example if a captured address replays elsewhere. */
RESOURCES_TEST(a_structure_has_one_address)
{
    struct accel_facts facts;
    have_accel_at(resources, 1, 0x1000, 0x100);
    for (VkDeviceAddress address = 0x2000; address <= 0x3000; address += 0x1000) {
        resources_set_accel_address(resources, accel(1), address);
        resources_find_referenced(resources, address - 0x1000, 0, &facts);
        assert_int_equal(facts.alive, NO);
        resources_find_referenced(resources, address, 0, &facts);
        assert_int_equal(facts.alive, YES);
    }
}

static enum tristate referenced(struct resources *resources, VkDeviceAddress address,
                                uint64_t destroy_count)
{
    struct accel_facts facts;
    resources_find_referenced(resources, address, destroy_count, &facts);
    return facts.alive;
}

/* One structure at a time, each at an address of its own. */
static void have_many_addresses(struct resources *resources)
{
    for (unsigned i = 1; i <= MANY_REFERENCES; i++) {
        have_accel_at(resources, 1, 0x1000, 0x100);
        resources_set_accel_address(resources, accel(1), (VkDeviceAddress)i << 16);
        resources_remove_accel(resources, accel(1));
    }
}

RESOURCES_TEST(old_addresses_are_forgotten)
{
    have_many_addresses(resources);
    const int blocks = allocations_now();
    const uint64_t before = resources_destroy_count(resources);
    have_many_addresses(resources);
    assert_int_equal(allocations_now(), blocks);
    for (unsigned i = 1; i <= MANY_REFERENCES; i += MANY_REFERENCES - 1) { /* forgotten or not */
        assert_int_equal(
            referenced(resources, (VkDeviceAddress)i << 16, resources_destroy_count(resources)),
            NO);
        /* A submission from then may refer to what was alive. */
        assert_int_equal(referenced(resources, (VkDeviceAddress)i << 16, before), UNKNOWN);
    }
    assert_int_equal(referenced(resources, 0x1234, before), UNKNOWN);

    /* A structure gets a forgotten address. */
    have_accel_at(resources, 1, 0x1000, 0x100);
    resources_set_accel_address(resources, accel(1), 1 << 16);
    assert_int_equal(referenced(resources, 1 << 16, resources_destroy_count(resources)), YES);
    assert_int_equal(referenced(resources, 1 << 16, before), UNKNOWN);
}

/* An address that is used repeatedly takes one place. */
RESOURCES_TEST(an_address_that_is_used_again_is_remembered)
{
    for (unsigned i = 0; i < 2 * MANY_REFERENCES; i++) {
        have_accel_at(resources, 1, 0x1000, 0x100);
        resources_set_accel_address(resources, accel(1), 1 << 16);
        assert_int_equal(referenced(resources, 1 << 16, resources_destroy_count(resources)), YES);
        resources_remove_accel(resources, accel(1));
        assert_int_equal(referenced(resources, 1 << 16, resources_destroy_count(resources)), NO);
    }
}

/* An engine creates structures, and queries their addresses, while submissions are pending. */
RESOURCES_TEST(an_address_that_becomes_known_changes_nothing_before)
{
    have_buffer(resources, 1, 0x1000, VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    have_accel(resources, 2, 1, 0, 0x100);
    resources_set_accel_address(resources, accel(2), 1 << 16);
    const uint64_t before = resources_destroy_count(resources);
    resources_remove_accel(resources, accel(2));
    assert_int_equal(referenced(resources, 0x1234, before), NO);
    have_accel(resources, 3, 1, 0x100, 0x100);
    resources_set_accel_address(resources, accel(3), 0); /* has not been queried */
    assert_int_equal(referenced(resources, 0x1234, before), UNKNOWN);
    resources_set_accel_address(resources, accel(3), 2 << 16);
    assert_int_equal(referenced(resources, 0x1234, before), NO);
    assert_int_equal(referenced(resources, 2 << 16, before), YES);
}
