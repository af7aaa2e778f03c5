/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of host addresses: mapped memory and what lies around it. */
#include "tests/state/fixture.h"

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

TEST_WITH(pieces_end_where_mappings_do, struct resources *resources, make, resources_destroy)
{
    resources_map_memory(resources, memory(1), 0x100, 0x200, at(0x10000));
    resources_map_memory(resources, memory(2), 0, VK_WHOLE_SIZE, at(0x20000));
    EXPECT_PIECES(find(resources, 0x10080, 0x10), {memory(1), 0x180, 0x190});
    EXPECT_PIECES(find(resources, 0x0ff00, 0x12000), {memory_of_host(), 0x0ff00, 0x10000},
                  {memory(1), 0x100, 0x300}, {memory_of_host(), 0x10200, 0x20000},
                  {memory(2), 0, 0x1000}, {memory_of_host(), 0x21000, 0x21f00});
    assert_int_equal(find(resources, 0x10000, 0).count, 0);
    EXPECT_PIECES(find(resources, UINTPTR_MAX - 1, UINT64_MAX),
                  {memory_of_host(), UINT64_MAX - 1, UINT64_MAX});
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
    resources_map_memory(resources, memory(1), 0x800, VK_WHOLE_SIZE, at(0x8000)); /* elsewhere */
    EXPECT_PIECES(find(resources, 0x1000, 0x1000), {memory_of_host(), 0x1000, 0x2000});
    EXPECT_PIECES(find(resources, 0x8000, 0x800), {memory(1), 0x800, 0x1000});
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

TEST(incoherent_memory_is_out_of_reach)
{
    struct resources *resources = make_buffer(VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT);
    resources_map_memory(resources, memory(4), 0, VK_WHOLE_SIZE, at(0x10000));
    assert_int_equal(mapped_at(resources, 1, OFFSET), 0);
    resources_destroy(resources);
}

TEST(usages_that_only_read)
{
    static const VkBufferUsageFlags2 reading[] = {
        VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT,
        VK_BUFFER_USAGE_2_UNIFORM_TEXEL_BUFFER_BIT,
        VK_BUFFER_USAGE_2_UNIFORM_BUFFER_BIT,
        VK_BUFFER_USAGE_2_INDEX_BUFFER_BIT,
        VK_BUFFER_USAGE_2_VERTEX_BUFFER_BIT,
        VK_BUFFER_USAGE_2_INDIRECT_BUFFER_BIT,
        VK_BUFFER_USAGE_2_CONDITIONAL_RENDERING_BIT_EXT,
        VK_BUFFER_USAGE_2_SHADER_BINDING_TABLE_BIT_KHR,
        VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
        VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT,
    };
    for (size_t i = 0; i < sizeof(reading) / sizeof(reading[0]); i++) {
        assert_true(buffer_is_only_read(reading[i]));
        assert_false(buffer_is_only_read(reading[i] | VK_BUFFER_USAGE_2_STORAGE_BUFFER_BIT));
        assert_false(buffer_is_only_read(reading[i] | VK_BUFFER_USAGE_2_TRANSFER_DST_BIT));
    }
}
