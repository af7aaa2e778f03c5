/* SPDX-License-Identifier: Apache-2.0 */
/* What no program shows of resources: the end of the address space, addresses and references that
 * are reused or forgotten, structures that share memory, and which bytes of mapped memory only the
 * host writes; the ring of destroyed objects. */
#include "src/state/resources/destroyed.h"
#include "src/state/resources/nv_shape.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/fixture.h"

#define AT 0x7000000000u
enum { MANY_REFERENCES = 1025 }; /* one more than are remembered of destroyed structures */

/* ---- addresses */

static void have_accel_at(struct resources *resources, unsigned n, VkDeviceAddress address,
                          VkDeviceSize size)
{
    const STRUCT(VkAccelerationStructureCreateInfo2KHR, create_info,
                 .addressRange = {.address = address, .size = size},
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    resources_add_accel_at(resources, accel(n), &create_info);
}

static struct address_facts address_facts(struct resources *resources, VkDeviceAddress address)
{
    struct address_facts facts;
    const unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &facts);
    resources_end_reading(resources, token);
    return facts;
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

static enum tristate backed(struct resources *resources, unsigned n)
{
    struct accel_facts facts;
    const struct resource_queries queries = {.accel_count = 1, .accels = {{accel(n), &facts}}};
    resources_find_all(resources, &queries);
    return facts.backed;
}

/* Lists of what is in a buffer, and of what is bound to memory, lose one in the middle. */
RESOURCES_TEST(what_backs_several_objects_ends)
{
    have_memory(resources, 1);
    for (unsigned n = 1; n <= 3; n++)
        have_bound_buffer(resources, n, 0x1000, 0, 1, 0x1000 * n);
    for (unsigned n = 1; n <= 5; n++)
        have_accel(resources, n, n <= 3 ? 1 : n - 2, 0, 0x100);
    resources_bind_buffer(resources, buffer(2), memory(1), 0, false);
    for (unsigned n = 2; n <= 4; n += 2)
        resources_remove_accel(resources, accel(n));
    resources_remove_buffer(resources, buffer(2));
    for (unsigned n = 1; n <= 5; n += 2)
        assert_int_equal(backed(resources, n), YES);
    resources_remove_buffer(resources, buffer(1));
    assert_int_equal(backed(resources, 1), NO);
    assert_int_equal(backed(resources, 3), NO);
    assert_int_equal(backed(resources, 5), YES);
    resources_remove_memory(resources, memory(1));
    assert_int_equal(backed(resources, 5), NO);
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

RESOURCES_TEST(a_buffer_has_one_address)
{
    have_memory(resources, 1);
    have_bound_buffer(resources, 2, 0x1000, 0, 1, 0);
    for (VkDeviceAddress address = AT; address <= AT + 0x2000; address += 0x2000) {
        resources_set_address(resources, buffer(2), address);
        assert_int_equal(address_facts(resources, address).status, ADDRESS_IN_BUFFER);
    }
    assert_int_equal(address_facts(resources, AT).status, ADDRESS_NOWHERE);
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

/* ---- mapped memory */

static const void *at(uintptr_t address)
{
    return (const void *)address;
}

static struct pieces find(struct resources *resources, uintptr_t address, uint64_t size)
{
    struct pieces pieces = {.count = 0};
    resources_find_host_pieces(resources, at(address), size, note_piece, &pieces);
    return pieces;
}

static struct resources *make(void)
{
    struct resources *resources = no_resources();
    for (unsigned n = 1; n <= 3; n++)
        resources_add_memory(resources, memory(n), 0x1000, 0, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT,
                             false);
    return resources;
}

TEST_WITH(mappings_end, struct resources *resources, make, resources_destroy)
{
    for (unsigned i = 1; i <= 3; i++)
        resources_map_memory(resources, memory(i), 0, VK_WHOLE_SIZE, at(i * 0x1000));
    resources_unmap_memory(resources, memory(2));
    resources_unmap_memory(resources, memory(2));
    resources_unmap_memory(resources, memory(9));
    EXPECT_PIECES(find(resources, 0x1000, 0x3000), {memory(1), 0, 0x1000},
                  {memory_of_host(), 0x2000, 0x3000}, {memory(3), 0, 0x1000});
    resources_remove_memory(resources, memory(3)); /* freed while it is mapped */
    EXPECT_PIECES(find(resources, 0x1000, 0x3000), {memory(1), 0, 0x1000},
                  {memory_of_host(), 0x2000, 0x4000});
    resources_map_memory(resources, memory(1), 0x800, 0x801,
                         at(0x8000)); /* elsewhere, and beyond */
    EXPECT_PIECES(find(resources, 0x1000, 0x1000), {memory_of_host(), 0x1000, 0x2000});
    EXPECT_PIECES(find(resources, 0x8000, 0x801), {memory(1), 0x800, 0x1000},
                  {memory_of_host(), 0x8800, 0x8801});
    resources_map_memory(resources, memory(1), 0x2000, 1, at(0x9000)); /* beyond its end */
    assert_ptr_equal(find(resources, 0x9000, 1).spans[0].memory, memory_of_host());
}

/* ---- by device addresses */

enum { BUFFER_AT = 0x100000, BUFFER_SIZE = 0x400, OFFSET = 0x200 /* in the memory */ };

static struct resources *make_buffer(VkMemoryPropertyFlags properties)
{
    struct resources *resources = make();
    resources_add_memory(resources, memory(4), 0x1000, 0, properties, false);
    have_bound_buffer(resources, 1, BUFFER_SIZE, VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, 4,
                      OFFSET);
    resources_set_address(resources, buffer(1), BUFFER_AT);
    return resources;
}

static void expect_mapped(struct resources *resources, VkDeviceAddress address, uint64_t size,
                          uint64_t found, uintptr_t pointer)
{
    const void *bytes = NULL;
    assert_int_equal(resources_find_mapped(resources, address, size, &bytes), found);
    assert_ptr_equal(bytes, at(pointer));
}

TEST(addresses_lead_to_what_is_mapped)
{
    struct resources *resources =
        make_buffer(VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    expect_mapped(resources, BUFFER_AT, 8, 0, 0);
    resources_map_memory(resources, memory(4), 0, VK_WHOLE_SIZE, at(0x10000));
    expect_mapped(resources, BUFFER_AT, 8, 8, 0x10000 + OFFSET);
    expect_mapped(resources, BUFFER_AT + 0x3f8, 16, 8, 0x10000 + OFFSET + 0x3f8);
    expect_mapped(resources, BUFFER_AT + BUFFER_SIZE, 8, 0, 0);
    expect_mapped(resources, BUFFER_AT - 8, 8, 0, 0);
    resources_map_memory(resources, memory(4), 0x300, 0x40, at(0x20000)); /* in the middle */
    expect_mapped(resources, BUFFER_AT, 8, 0, 0);
    expect_mapped(resources, BUFFER_AT + 0x120, 0x80, 0x20, 0x20020);
    expect_mapped(resources, BUFFER_AT + 0x140, 8, 0, 0);
    resources_unmap_memory(resources, memory(4));
    expect_mapped(resources, BUFFER_AT + 0x120, 8, 0, 0);
    resources_destroy(resources);

    resources = make_buffer(VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT);
    resources_map_memory(resources, memory(4), 0, VK_WHOLE_SIZE, at(0x10000));
    expect_mapped(resources, BUFFER_AT, 8, 0, 0); /* what is flushed is unknown */
    resources_remove_memory(resources, memory(4));
    expect_mapped(resources, BUFFER_AT, 8, 0, 0);
    resources_destroy(resources);
}

/* ---- what only the host writes */

#define COHERENT (VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT)

static void note_mapped(void *user, const void *bytes, uint64_t size)
{
    assert_int_equal(size, 8);
    *(const void **)user = bytes;
}

/* Returns the address of 8 bytes of a buffer, or 0 if they are out of reach. */
static uintptr_t mapped_at(struct resources *resources, unsigned n, uint64_t begin)
{
    const void *bytes = NULL;
    const struct mapped_bytes wanted = {buffer(n), resources_find_memory_id(resources, memory(4)),
                                        begin, 8};
    const bool is_found = resources_visit_mapped(resources, &wanted, note_mapped, &bytes);
    assert_int_equal(is_found, bytes != NULL);
    return (uintptr_t)bytes;
}

static struct resources *make_mapped(void)
{
    struct resources *resources = make_buffer(COHERENT);
    resources_map_memory(resources, memory(4), 0x100, 0x400, at(0x10000));
    return resources;
}

TEST_WITH(bytes_that_only_the_host_writes, struct resources *resources, make_mapped,
          resources_destroy)
{
    assert_int_equal(mapped_at(resources, 1, OFFSET), 0x10100);
    assert_int_equal(mapped_at(resources, 1, 0x100), 0x10000);
    assert_int_equal(mapped_at(resources, 1, 0xf8), 0);
    assert_int_equal(mapped_at(resources, 1, 0x4f8), 0x103f8);
    assert_int_equal(mapped_at(resources, 1, 0x4f9), 0); /* the mapping ends */
    assert_int_equal(mapped_at(resources, 1, UINT64_MAX), 0);
    assert_int_equal(mapped_at(resources, 2, OFFSET), 0); /* unknown */
    have_bound_buffer(resources, 2, 0x10, VK_BUFFER_USAGE_TRANSFER_DST_BIT, 4, 0x300);
    assert_int_equal(mapped_at(resources, 1, 0x2f8), 0x101f8);
    assert_int_equal(mapped_at(resources, 1, 0x2f9), 0); /* a command may write it */
    assert_int_equal(mapped_at(resources, 1, 0x30f), 0);
    assert_int_equal(mapped_at(resources, 1, 0x310), 0x10210);
    assert_int_equal(mapped_at(resources, 2, 0x300), 0);
    resources_unmap_memory(resources, memory(4));
    assert_int_equal(mapped_at(resources, 1, OFFSET), 0);
}

TEST_WITH(others_may_write_memory, struct resources *resources, make_mapped, resources_destroy)
{
    const struct mapped_bytes of_other_memory = {
        buffer(1), resources_find_memory_id(resources, memory(3)), OFFSET, 8};
    assert_false(resources_visit_mapped(resources, &of_other_memory, note_mapped, NULL));
    assert_int_not_equal(mapped_at(resources, 1, OFFSET), 0);
    resources_share_memory(resources, memory(4));
    assert_int_equal(mapped_at(resources, 1, OFFSET), 0);
}

TEST(usages_that_only_read)
{
    static const VkBufferUsageFlags2 reading =
        VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_2_UNIFORM_TEXEL_BUFFER_BIT |
        VK_BUFFER_USAGE_2_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_2_INDEX_BUFFER_BIT |
        VK_BUFFER_USAGE_2_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_2_INDIRECT_BUFFER_BIT |
        VK_BUFFER_USAGE_2_CONDITIONAL_RENDERING_BIT_EXT |
        VK_BUFFER_USAGE_2_SHADER_BINDING_TABLE_BIT_KHR |
        VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT;
    assert_true(buffer_is_only_read(reading));
    for (VkBufferUsageFlags2 bit = 1; bit; bit <<= 1) {
        assert_true(!(bit & reading) || buffer_is_only_read(bit));
        assert_false(buffer_is_only_read(bit | VK_BUFFER_USAGE_2_STORAGE_BUFFER_BIT));
        assert_false(buffer_is_only_read(bit | VK_BUFFER_USAGE_2_TRANSFER_DST_BIT));
    }
}

/* ---- structures of VK_NV_ray_tracing */

static VkAccelerationStructureNV nv(unsigned n)
{
    return (VkAccelerationStructureNV)(uintptr_t)(0x400 + n);
}

static void have_nv(struct resources *resources, unsigned n)
{
    const VkAccelerationStructureInfoNV info = {.type =
                                                    VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV};
    const struct nv_size_facts sizes = {.known = true, .object = 0x1000};
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

RESOURCES_TEST(bindings_that_are_not_known)
{
    have_memory(resources, 1);
    have_nv(resources, 1);
    resources_bind_nv_accel(resources, nv(1), memory(1), 0, false);
    assert_ptr_equal(nv_facts(resources, 1).span.memory, memory(1));
    resources_bind_nv_accel(resources, nv(1), memory(1), 0, true); /* elsewhere in each instance */
    assert_int_equal(nv_facts(resources, 1).binding, NV_BOUND);
    assert_null(nv_facts(resources, 1).span.memory);
    resources_forget_nv_binding(resources, nv(1));
    assert_int_equal(nv_facts(resources, 1).binding, NV_BINDING_UNKNOWN);
    resources_bind_nv_accel(resources, nv(1), memory(2), 0, false); /* never allocated */
    assert_int_equal(nv_facts(resources, 1).binding, NV_BINDING_UNKNOWN);
    resources_forget_nv_binding(resources, nv(7));
    resources_bind_nv_accel(resources, nv(7), memory(1), 0, false);
}

static void assert_reference(struct resources *resources, uint64_t reference, uint64_t deaths,
                             enum nv_reference expected)
{
    assert_int_equal(resources_find_nv_reference(resources, reference, deaths), expected);
}

RESOURCES_TEST(references_of_what_was_destroyed)
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

RESOURCES_TEST(old_references_are_forgotten)
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

/* ---- the ring of destroyed objects, by their addresses */

TEST(destroyed_objects_are_found_until_others_take_their_places)
{
    struct destroyed_objects *destroyed;
    struct destroyed_object object = {.type = VK_OBJECT_TYPE_BUFFER, .handle = 1, .size = 16};
    assert_int_equal(destroyed_objects_create(&destroyed), VK_SUCCESS);
    destroyed_objects_add(destroyed, &object); /* had no address */
    assert_false(destroyed_objects_find_range(destroyed, 0, &object));
    for (uint64_t i = 1; i <= DESTROYED_MAX + 1; i++) {
        object.handle = i;
        object.address = 256 * i;
        destroyed_objects_add(destroyed, &object);
    }
    assert_false(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 256, &object));
    assert_false(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 512 + 16, &object));
    assert_true(destroyed_objects_find(destroyed, VK_OBJECT_TYPE_BUFFER, 512 + 15, &object));
    assert_int_equal(object.handle, 2);
    destroyed_objects_count_submission(destroyed);
    object = (struct destroyed_object){
        .type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, .handle = 7, .address = 512, .size = 64};
    destroyed_objects_add(destroyed, &object);
    assert_true(
        destroyed_objects_find(destroyed, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 512, &object));
    assert_int_equal(object.handle, 7);
    assert_int_equal(object.submissions, 1);
    assert_true(
        destroyed_objects_find(destroyed, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, 768, &object));
    assert_int_equal(object.type, VK_OBJECT_TYPE_BUFFER);
    assert_true(destroyed_objects_find_range(destroyed, 512 + 63, &object));
    assert_int_equal(object.handle, 7);
    destroyed_objects_destroy(destroyed);
}
