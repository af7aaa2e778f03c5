/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what is known of acceleration structures, their buffers and their memory. */
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"

enum { SIZE = 0x1000 };

static void assert_backed(struct resources *resources, unsigned n, enum tristate backed)
{
    struct accel_facts facts = accel_facts(resources, n);
    assert_int_equal(facts.alive, YES);
    assert_int_equal(facts.backed, backed);
    if (backed != YES)
        assert_null(facts.memory);
}

static void assert_lies_at(struct resources *resources, unsigned n, unsigned memory_n,
                           VkDeviceSize begin, VkDeviceSize end)
{
    struct accel_facts facts = accel_facts(resources, n);
    assert_int_equal(facts.backed, YES);
    assert_span(accel_span(&facts), memory_n, begin, end);
}

/* Buffer 1, at the beginning of memory 1. */
static struct resources *one_bound_buffer(void)
{
    struct resources *resources = no_resources();
    have_memory(resources, 1);
    have_bound_buffer(resources, 1, SIZE, 0, 1, 0);
    return resources;
}

#define BOUND_BUFFER_TEST(name)                                                                    \
    TEST_WITH(name, struct resources *resources, one_bound_buffer, resources_destroy)

RESOURCES_TEST(test_a_structure_has_its_details)
{
    have_buffer(resources, 1, SIZE, 0);
    have_accel(resources, 2, 1, 0x100, 0x200);
    struct accel_facts facts = accel_facts(resources, 2);
    assert_int_equal(facts.alive, YES);
    assert_false(facts.of_another_device);
    assert_true(facts.details_known);
    assert_int_equal(facts.type, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    assert_int_equal(facts.create_flags,
                     VK_ACCELERATION_STRUCTURE_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_KHR);
    assert_int_equal(facts.size, 0x200);
    assert_int_equal(facts.begin, 0x100);
    assert_ptr_equal(facts.buffer, buffer(1));
    resources_destroy(NULL);
}

RESOURCES_TEST(test_a_buffer_may_be_bound_before_or_after)
{
    have_memory(resources, 1);
    have_buffer(resources, 1, SIZE, 0);
    have_buffer(resources, 2, SIZE, 0);
    bind_at(resources, 1, 1, 0x4000);
    have_accel(resources, 1, 1, 0x100, 0x200);
    have_accel(resources, 2, 2, 0x100, 0x200);
    assert_lies_at(resources, 1, 1, 0x4100, 0x4300);
    assert_backed(resources, 2, NO);
    bind_at(resources, 2, 1, 0x8000);
    assert_lies_at(resources, 2, 1, 0x8100, 0x8300);
}

BOUND_BUFFER_TEST(test_memory_freed_is_memory_lost)
{
    have_accel(resources, 1, 1, 0, 0x100);
    resources_remove_memory(resources, memory(1));
    assert_backed(resources, 1, NO);
    have_memory(resources, 1); /* the driver gives the handle out again */
    assert_backed(resources, 1, NO);
    assert_int_equal(accel_facts(resources, 1).alive, YES);
    resources_remove_memory(resources, memory(1));
    resources_remove_memory(resources, memory(1));
    resources_remove_memory(resources, VK_NULL_HANDLE);
}

BOUND_BUFFER_TEST(test_a_buffer_destroyed_takes_its_place_along)
{
    have_accel(resources, 1, 1, 0, 0x100);
    resources_remove_buffer(resources, buffer(1));
    assert_backed(resources, 1, NO);
    assert_ptr_equal(accel_facts(resources, 1).buffer, buffer(1));
    have_buffer(resources, 1, SIZE, 0); /* the handle again, of another buffer */
    bind_at(resources, 1, 1, 0);
    assert_backed(resources, 1, NO);
    have_accel(resources, 1, 1, 0x80, 0x100);
    assert_lies_at(resources, 1, 1, 0x80, 0x180);
}

RESOURCES_TEST(test_a_structure_destroyed_is_no_structure)
{
    have_buffer(resources, 1, SIZE, 0);
    have_accel(resources, 1, 1, 0, 0x100);
    assert_true(resources_find_id(resources, RESOURCE_ACCEL, (uint64_t)(uintptr_t)accel(1)));
    uint64_t id = accel_facts(resources, 1).id;
    assert_int_equal(resources_remove_accel(resources, accel(1)), id);
    assert_int_equal(resources_remove_accel(resources, accel(1)), 0);
    assert_int_equal(accel_facts(resources, 1).alive, NO);
    assert_int_equal(accel_facts(resources, 1).id, 0);
    assert_false(accel_facts(resources, 1).details_known);
    assert_false(resources_find_id(resources, RESOURCE_ACCEL, (uint64_t)(uintptr_t)accel(1)));
    have_accel(resources, 1, 1, 0, 0x100);
    assert_int_not_equal(accel_facts(resources, 1).id, id);
    assert_int_equal(accel_facts(resources, 0).alive, UNKNOWN); /* VK_NULL_HANDLE: nothing to say */
    assert_false(resources_find_id(resources, RESOURCE_ACCEL, 0));
}

/* A handle that comes again without having gone: the layer missed nothing, so the old one is dead.
 */
RESOURCES_TEST(test_a_handle_created_again_is_another)
{
    have_memory(resources, 1);
    have_memory(resources, 2);
    have_bound_buffer(resources, 1, SIZE, 0, 1, 0);
    have_accel(resources, 1, 1, 0, 0x100);
    have_accel(resources, 2, 1, 0, 0x100);
    have_accel(resources, 1, 1, 0x200, 0x100);
    assert_lies_at(resources, 1, 1, 0x200, 0x300);
    have_memory(resources, 1);
    assert_backed(resources, 1, NO);
    have_bound_buffer(resources, 1, SIZE, 0, 2, 0);
    assert_backed(resources, 2, NO);
}

RESOURCES_TEST(test_buffers_share_memory)
{
    have_memory(resources, 1);
    for (unsigned n = 1; n <= 3; n++) {
        have_bound_buffer(resources, n, SIZE, 0, 1, 0x1000 * (n / 2));
        have_accel(resources, n, n, 0x10 * n, 0x100);
    }
    assert_lies_at(resources, 1, 1, 0x10, 0x110);
    assert_lies_at(resources, 2, 1, 0x1020, 0x1120);
    assert_lies_at(resources, 3, 1, 0x1030, 0x1130);
    resources_remove_buffer(resources, buffer(2));
    assert_backed(resources, 2, NO);
    assert_lies_at(resources, 3, 1, 0x1030, 0x1130);
}

RESOURCES_TEST(test_a_failed_bind_leaves_the_binding_unknown)
{
    have_memory(resources, 1);
    have_buffer(resources, 1, SIZE, 0);
    have_accel(resources, 1, 1, 0, 0x100);
    resources_forget_binding(resources, buffer(1));
    assert_backed(resources, 1, UNKNOWN);
    bind_at(resources, 1, 1, 0x100);
    assert_lies_at(resources, 1, 1, 0x100, 0x200);
    resources_forget_binding(resources, buffer(1));
    assert_backed(resources, 1, UNKNOWN);
    resources_forget_binding(resources, buffer(9));
}

RESOURCES_TEST(test_a_binding_to_unknown_memory_is_unknown)
{
    have_buffer(resources, 1, SIZE, 0);
    have_accel(resources, 1, 1, 0, 0x100);
    bind_at(resources, 1, 7, 0);
    assert_backed(resources, 1, UNKNOWN);
    have_memory(resources, 7);
    assert_backed(resources, 1, UNKNOWN);
    bind_at(resources, 9, 7, 0); /* nor is that buffer known */
}

/* Offsets in memory whose instances are exchanged are not comparable, but the memory is there. */
RESOURCES_TEST(test_bindings_with_instances_of_their_choice_have_no_span)
{
    resources_add_memory(resources, memory(1), 1 << 20, 0, true);
    have_buffer(resources, 1, SIZE, 0);
    resources_bind_buffer(resources, buffer(1), memory(1), 0, true);
    resources_set_address(resources, buffer(1), 0x10000);
    have_accel(resources, 1, 1, 0, 0x100);
    struct accel_facts facts = accel_facts(resources, 1);
    assert_int_equal(facts.backed, YES);
    assert_null(facts.memory);
    struct address_facts address = address_facts(resources, 0x10010);
    assert_int_equal(address.status, ADDRESS_IN_BUFFER);
    assert_null(address.memory);
    resources_remove_memory(resources, memory(1));
    assert_backed(resources, 1, NO);
}

RESOURCES_TEST(test_a_structure_in_an_unknown_buffer_is_backed_by_who_knows)
{
    have_accel(resources, 1, 5, 0, 0x100);
    assert_backed(resources, 1, UNKNOWN);
    assert_null(accel_facts(resources, 1).buffer);
    have_buffer(resources, 5, SIZE, 0);
    assert_backed(resources, 1, UNKNOWN);
}

RESOURCES_TEST(test_what_was_lost_is_unknown)
{
    have_buffer(resources, 1, SIZE, 0);
    have_accel(resources, 1, 1, 0, 0x100);
    assert_int_equal(accel_facts(resources, 2).alive, NO);
    WITHOUT_MEMORY(have_accel(resources, 2, 1, 0, 0x100));
    assert_int_equal(accel_facts(resources, 1).alive, YES);
    assert_int_equal(accel_facts(resources, 2).alive, UNKNOWN);
    assert_int_equal(accel_facts(resources, 3).alive, UNKNOWN);
}

RESOURCES_TEST(test_memory_that_was_lost_makes_bindings_unknown)
{
    have_buffer(resources, 1, SIZE, 0);
    have_accel(resources, 1, 1, 0, 0x100);
    WITHOUT_MEMORY(have_memory(resources, 1));
    bind_at(resources, 1, 1, 0);
    assert_backed(resources, 1, UNKNOWN);
}

/* A record that could not be replaced is gone: its handle has another owner now. */
BOUND_BUFFER_TEST(test_a_lost_successor_removes_its_predecessor)
{
    resources_set_address(resources, buffer(1), 0x10000);
    have_accel(resources, 1, 1, 0, 0x100);
    WITHOUT_MEMORY(have_buffer(resources, 1, SIZE, 0));
    assert_backed(resources, 1, NO);
    assert_int_equal(address_facts(resources, 0x10000).status, ADDRESS_UNKNOWN);
    have_accel(resources, 2, 1, 0, 0x100);
    assert_backed(resources, 2, UNKNOWN);
    WITHOUT_MEMORY(have_accel(resources, 1, 1, 0, 0x100));
    assert_int_equal(accel_facts(resources, 1).alive, UNKNOWN);
}

TEST(test_resources_need_memory)
{
    struct resources *resources;
    WITHOUT_MEMORY(assert_int_equal(resources_create(&resources), VK_ERROR_OUT_OF_HOST_MEMORY));
    assert_null(resources);
}

/* A captured address that replays elsewhere, say: the last one counts. */
RESOURCES_TEST(test_a_structure_has_one_address)
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

RESOURCES_TEST(test_old_addresses_are_forgotten)
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
RESOURCES_TEST(test_an_address_that_is_used_again_is_remembered)
{
    for (unsigned i = 0; i < 2 * MANY_REFERENCES; i++) {
        have_accel_at(resources, 1, 0x1000, 0x100);
        resources_set_accel_address(resources, accel(1), 1 << 16);
        assert_int_equal(referenced(resources, 1 << 16, resources_destroy_count(resources)), YES);
        resources_remove_accel(resources, accel(1));
        assert_int_equal(referenced(resources, 1 << 16, resources_destroy_count(resources)), NO);
    }
}
