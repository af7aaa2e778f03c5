/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what is known of device addresses. */
#include "tests/fixture/make.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"

enum {
    STORAGE = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
    INPUT = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
};

#define AT 0x7000000000u

/* Memory 1, and buffer 1 of 0x1000 bytes at its offset 0x400 and at address AT. */
static struct resources *one_buffer(void)
{
    struct resources *resources = no_resources();
    have_memory(resources, 1);
    have_bound_buffer(resources, 1, 0x1000, STORAGE, 1, 0x400);
    resources_set_address(resources, buffer(1), AT);
    return resources;
}

#define ADDRESS_TEST(name)                                                                         \
    TEST_WITH(name, struct resources *resources, one_buffer, resources_destroy)

static void assert_status(struct resources *resources, VkDeviceAddress address,
                          enum address_status status)
{
    struct address_facts facts = address_facts(resources, address);
    if (facts.status != status)
        fail_msg("address %#lx has status %d, not %d", (unsigned long)address, facts.status,
                 status);
    if (status != ADDRESS_IN_BUFFER)
        assert_null(facts.memory);
}

ADDRESS_TEST(test_an_address_in_a_buffer)
{
    struct address_facts facts = address_facts(resources, AT + 0x30);
    assert_int_equal(facts.status, ADDRESS_IN_BUFFER);
    assert_ptr_equal(facts.buffer, buffer(1));
    assert_int_equal(facts.usage, STORAGE);
    assert_int_equal(facts.bytes_left, 0xfd0);
    assert_span(address_span(&facts), 1, 0x430, 0x1400);
    assert_status(resources, AT - 1, ADDRESS_NOWHERE);
    assert_status(resources, AT, ADDRESS_IN_BUFFER);
    assert_status(resources, AT + 0xfff, ADDRESS_IN_BUFFER);
    assert_status(resources, AT + 0x1000, ADDRESS_NOWHERE);
    assert_status(resources, 0, ADDRESS_NULL);
}

ADDRESS_TEST(test_an_address_needs_memory_behind_it)
{
    resources_remove_memory(resources, memory(1));
    assert_status(resources, AT, ADDRESS_UNBOUND);
    assert_ptr_equal(address_facts(resources, AT).buffer, buffer(1));
    resources_forget_binding(resources, buffer(1));
    assert_status(resources, AT, ADDRESS_UNKNOWN);
    resources_remove_buffer(resources, buffer(1));
    assert_status(resources, AT, ADDRESS_NOWHERE);
}

RESOURCES_TEST(test_an_address_may_be_asked_for_before_the_memory_is_bound)
{
    have_memory(resources, 1);
    have_buffer(resources, 1, 0x1000, STORAGE);
    resources_set_address(resources, buffer(1), AT);
    assert_status(resources, AT, ADDRESS_UNBOUND);
    bind_at(resources, 1, 1, 0);
    assert_status(resources, AT, ADDRESS_IN_BUFFER);
}

ADDRESS_TEST(test_an_address_that_changes_leaves_the_old_one)
{
    resources_set_address(resources, buffer(1), AT);
    resources_set_address(resources, buffer(1), AT + 0x100000);
    assert_status(resources, AT, ADDRESS_NOWHERE);
    assert_status(resources, AT + 0x100000, ADDRESS_IN_BUFFER);
    resources_set_address(resources, buffer(1), 0);
    assert_status(resources, AT + 0x100000, ADDRESS_NOWHERE);
    resources_set_address(resources, buffer(9), AT); /* nobody's */
    assert_status(resources, AT, ADDRESS_NOWHERE);
}

ADDRESS_TEST(test_a_recycled_address_is_of_its_new_buffer)
{
    resources_remove_buffer(resources, buffer(1));
    have_bound_buffer(resources, 2, 0x800, INPUT, 1, 0);
    resources_set_address(resources, buffer(2), AT);
    struct address_facts facts = address_facts(resources, AT);
    assert_ptr_equal(facts.buffer, buffer(2));
    assert_int_equal(facts.usage, INPUT);
    assert_status(resources, AT + 0x800, ADDRESS_NOWHERE);
}

RESOURCES_TEST(test_usage_may_have_64_bits)
{
    const STRUCT(VkBufferCreateInfo, create_info,
                 .pNext = &MAKE(VkBufferUsageFlags2CreateInfo, .usage = INPUT | 1ull << 40),
                 .size = 0x100, .usage = STORAGE);
    have_memory(resources, 1);
    resources_add_buffer(resources, buffer(1), &create_info);
    bind_at(resources, 1, 1, 0);
    resources_set_address(resources, buffer(1), AT);
    assert_true(address_facts(resources, AT).usage == (INPUT | 1ull << 40));
}

/* ---- buffers that share addresses */

ADDRESS_TEST(test_aliasing_buffers_add_up)
{
    have_bound_buffer(resources, 2, 0x3000, INPUT, 1, 0x200);
    resources_set_address(resources, buffer(2), AT - 0x200);
    have_bound_buffer(resources, 3, 0x100, VK_BUFFER_USAGE_TRANSFER_DST_BIT, 1, 0x400);
    resources_set_address(resources, buffer(3), AT);
    struct address_facts facts = address_facts(resources, AT + 0x10);
    assert_int_equal(facts.status, ADDRESS_IN_BUFFER);
    assert_int_equal(facts.usage, STORAGE | INPUT | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    assert_ptr_equal(facts.buffer, buffer(2));
    assert_int_equal(facts.bytes_left, 0x3000 - 0x210);
    assert_span(address_span(&facts), 1, 0x410, 0x3200);
    assert_int_equal(address_facts(resources, AT + 0x100).usage, STORAGE | INPUT);
    assert_int_equal(address_facts(resources, AT + 0x1000).usage, INPUT);
    resources_remove_buffer(resources, buffer(2));
    assert_int_equal(address_facts(resources, AT + 0x10).bytes_left, 0xff0);
}

ADDRESS_TEST(test_a_bound_buffer_outweighs_an_unbound_one)
{
    have_memory(resources, 2);
    have_bound_buffer(resources, 2, 0x3000, INPUT, 2, 0);
    resources_set_address(resources, buffer(2), AT);
    resources_remove_memory(resources, memory(2));
    for (int round = 0; round < 2; round++) {
        struct address_facts facts = address_facts(resources, AT);
        assert_int_equal(facts.status, ADDRESS_IN_BUFFER);
        assert_ptr_equal(facts.buffer, buffer(1));
        assert_int_equal(facts.usage, STORAGE);
        assert_int_equal(facts.bytes_left, 0x1000);
        resources_set_address(resources, buffer(1), 0); /* the other order of insertion */
        resources_set_address(resources, buffer(1), AT);
    }
}

/* What isn't known to be bound may be what the application relies on. */
ADDRESS_TEST(test_an_unknown_binding_makes_the_address_unknown)
{
    have_buffer(resources, 2, 0x3000, INPUT);
    resources_set_address(resources, buffer(2), AT);
    resources_forget_binding(resources, buffer(2));
    assert_status(resources, AT, ADDRESS_UNKNOWN);
    resources_set_address(resources, buffer(1), 0);
    resources_set_address(resources, buffer(1), AT);
    assert_status(resources, AT, ADDRESS_UNKNOWN);
}

/* ---- without memory */

ADDRESS_TEST(test_a_lost_buffer_may_be_anywhere)
{
    WITHOUT_MEMORY(have_buffer(resources, 2, 0x3000, INPUT));
    resources_set_address(resources, buffer(2), AT);
    assert_status(resources, 0, ADDRESS_NULL);
    assert_status(resources, AT + 0x2000, ADDRESS_UNKNOWN);
    assert_status(resources, AT, ADDRESS_UNKNOWN); /* or aliases one that is known */
}

RESOURCES_TEST(test_a_lost_address_may_be_anywhere)
{
    have_memory(resources, 1);
    have_bound_buffer(resources, 1, 0x1000, STORAGE, 1, 0);
    WITHOUT_MEMORY(resources_set_address(resources, buffer(1), AT));
    assert_status(resources, AT, ADDRESS_UNKNOWN);
    assert_status(resources, AT + 0x10000, ADDRESS_UNKNOWN);
    resources_set_address(resources, buffer(1), AT);
    resources_remove_buffer(resources, buffer(1));
}

/* A range without an end that can be told is as good as lost. */
ADDRESS_TEST(test_a_buffer_at_the_end_of_the_address_space)
{
    have_bound_buffer(resources, 2, 0x1000, STORAGE, 1, 0);
    resources_set_address(resources, buffer(2), UINT64_MAX - 0x1000);
    assert_status(resources, UINT64_MAX - 1, ADDRESS_IN_BUFFER);
    assert_status(resources, UINT64_MAX, ADDRESS_NOWHERE);
    resources_set_address(resources, buffer(2), UINT64_MAX - 0xfff);
    assert_status(resources, UINT64_MAX, ADDRESS_UNKNOWN);
}

/* ---- structures over addresses */

ADDRESS_TEST(test_a_structure_over_an_address_range_lies_in_its_buffer)
{
    have_accel_at(resources, 1, AT + 0x100, 0x200);
    struct accel_facts facts = accel_facts(resources, 1);
    assert_int_equal(facts.type, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    assert_ptr_equal(facts.buffer, buffer(1));
    assert_int_equal(facts.size, 0x200);
    assert_int_equal(facts.backed, YES);
    assert_span(accel_span(&facts), 1, 0x500, 0x700);
    resources_remove_buffer(resources, buffer(1));
    assert_int_equal(accel_facts(resources, 1).backed, NO);
}

ADDRESS_TEST(test_a_structure_over_no_buffer_or_over_several_is_backed_by_who_knows)
{
    have_accel_at(resources, 1, AT + 0x10000, 0x200);
    have_accel_at(resources, 2, AT + 0xf00, 0x101);
    have_buffer(resources, 2, 0x1000, STORAGE);
    resources_set_address(resources, buffer(2), AT);
    have_accel_at(resources, 3, AT, 0x100);
    for (unsigned n = 1; n <= 3; n++) {
        struct accel_facts facts = accel_facts(resources, n);
        assert_int_equal(facts.alive, YES);
        assert_int_equal(facts.backed, UNKNOWN);
        assert_null(facts.buffer);
        assert_null(facts.memory);
    }
}

static uint64_t readable_at(struct resources *resources, VkDeviceAddress address, uint64_t size)
{
    return resources_find_readable(resources, address, size, &all_of_queue_1);
}

ADDRESS_TEST(test_what_can_be_read_ends_with_the_buffer)
{
    assert_int_equal(readable_at(resources, AT, 0x800), 0x800);
    assert_int_equal(readable_at(resources, AT + 0xf00, 0x800), 0x100);
    assert_int_equal(readable_at(resources, AT + 0x1000, 0x800), 0);
    resources_remove_memory(resources, memory(1));
    assert_int_equal(readable_at(resources, AT, 0x800), 0);
}

ADDRESS_TEST(test_no_protected_buffer_can_be_read)
{
    const STRUCT(VkBufferCreateInfo, info, .flags = VK_BUFFER_CREATE_PROTECTED_BIT, .size = 0x800);
    resources_add_buffer(resources, buffer(2), &info);
    bind_at(resources, 2, 1, 0x400);
    resources_set_address(resources, buffer(2), AT);
    assert_int_equal(readable_at(resources, AT, 0x10), 0);
    assert_int_equal(readable_at(resources, AT + 0x800, 0x10), 0x10);
    resources_remove_buffer(resources, buffer(2));
    assert_int_equal(readable_at(resources, AT, 0x10), 0x10);
}

RESOURCES_TEST(test_of_a_sparse_buffer_all_is_read_or_nothing)
{
    const struct execution_clock nothing = {0};
    have_memory(resources, 1);
    have_sparse_buffer(resources, 1, 0x1000);
    resources_set_address(resources, buffer(1), AT);
    assert_int_equal(readable_at(resources, AT, 0x100), 0);
    bind_sparse(resources, 1, 0, 0x800, 1, 0);
    assert_int_equal(readable_at(resources, AT, 0x800), 0x800);
    assert_int_equal(readable_at(resources, AT, 0x801), 0);
    assert_int_equal(resources_find_readable(resources, AT, 0x800, &nothing), 0);
}
