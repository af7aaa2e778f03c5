/* SPDX-License-Identifier: Apache-2.0 */
/* Filling and asking resources. */
#include "tests/state/fixture.h"
#include "tests/fixture/make.h"

struct resources *no_resources(void)
{
    struct resources *resources = NULL;
    assert_int_equal(resources_create(&resources), VK_SUCCESS);
    return resources;
}

void have_memory(struct resources *resources, unsigned n)
{
    resources_add_memory(resources, memory(n), 1 << 20, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                         false);
}

static void add_buffer(struct resources *resources, unsigned n, VkDeviceSize size,
                       VkBufferUsageFlags usage, VkBufferCreateFlags flags)
{
    const STRUCT(VkBufferCreateInfo, create_info, .flags = flags, .size = size,
                 .usage = usage ? usage : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    resources_add_buffer(resources, buffer(n), &create_info);
}

void have_buffer(struct resources *resources, unsigned n, VkDeviceSize size,
                 VkBufferUsageFlags usage)
{
    add_buffer(resources, n, size, usage, 0);
}

void have_sparse_buffer(struct resources *resources, unsigned n, VkDeviceSize size)
{
    add_buffer(resources, n, size, 0, VK_BUFFER_CREATE_SPARSE_BINDING_BIT);
}

void bind_at(struct resources *resources, unsigned n, unsigned memory_n, VkDeviceSize offset)
{
    resources_bind_buffer(resources, buffer(n), memory(memory_n), offset, false);
}

void have_bound_buffer(struct resources *resources, unsigned n, VkDeviceSize size,
                       VkBufferUsageFlags usage, unsigned memory_n, VkDeviceSize offset)
{
    have_buffer(resources, n, size, usage);
    bind_at(resources, n, memory_n, offset);
}

const struct execution_clock all_of_queue_1 = {.queues = 2, .counts = {0, UINT64_MAX}};

void bind_sparse(struct resources *resources, unsigned n, VkDeviceSize begin, VkDeviceSize size,
                 unsigned memory_n, VkDeviceSize offset)
{
    const VkSparseMemoryBind bind = {
        .resourceOffset = begin, .size = size, .memory = memory(memory_n), .memoryOffset = offset};
    struct sparse_binding binding = resources_announce_sparse(resources, buffer(n), &bind);
    resources_bind_sparse(resources, &binding, (struct timestamp){1, 1}, &all_of_queue_1);
    resources_settle_sparse(resources, &binding);
}

void have_accel(struct resources *resources, unsigned n, unsigned buffer_n, VkDeviceSize offset,
                VkDeviceSize size)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, create_info,
                 .createFlags =
                     VK_ACCELERATION_STRUCTURE_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_KHR,
                 .buffer = buffer(buffer_n), .offset = offset, .size = size,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    resources_add_accel(resources, accel(n), &create_info);
}

void have_accel_at(struct resources *resources, unsigned n, VkDeviceAddress address,
                   VkDeviceSize size)
{
    const STRUCT(VkAccelerationStructureCreateInfo2KHR, create_info,
                 .addressRange = {.address = address, .size = size},
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    resources_add_accel_at(resources, accel(n), &create_info);
}

struct accel_facts accel_facts(struct resources *resources, unsigned n)
{
    struct accel_facts facts, others;
    struct resource_queries queries = {.accel_count = RESOURCE_ACCEL_QUERIES,
                                       .accels = {{accel(n), &facts}}};
    for (unsigned i = 1; i < RESOURCE_ACCEL_QUERIES; i++) {
        queries.accels[i].handle = accel(n + i);
        queries.accels[i].facts = &others;
    }
    resources_find_all(resources, &queries);
    assert_ptr_equal(facts.handle, accel(n));
    return facts;
}

static void assert_facts_agree(const struct address_facts *a, const struct address_facts *b)
{
    assert_true(a->address == b->address && a->usage == b->usage);
    assert_int_equal(a->status, b->status);
    assert_int_equal(a->bytes_left, b->bytes_left);
    assert_ptr_equal(a->buffer, b->buffer);
    assert_int_equal(a->buffer_id, b->buffer_id);
    assert_ptr_equal(a->memory, b->memory);
    assert_int_equal(a->begin, b->begin);
    assert_int_equal(a->is_sparse, b->is_sparse);
}

struct address_facts address_facts(struct resources *resources, VkDeviceAddress address)
{
    struct address_facts facts, again, among_others[2];
    const struct resource_queries queries = {
        .address_count = 2,
        .addresses = {{address + 1, &among_others[1]}, {address, &among_others[0]}},
    };
    unsigned token = resources_begin_reading(resources);
    resources_find_address(resources, address, &facts);
    resources_find_address(resources, address, &again);
    resources_end_reading(resources, token);
    resources_find_all(resources, &queries);
    assert_true(facts.address == address);
    assert_facts_agree(&facts, &again);
    assert_facts_agree(&facts, &among_others[0]);
    return facts;
}

struct memory_span accel_span(const struct accel_facts *facts)
{
    return memory_span_of(facts->memory, facts->begin, facts->size);
}

struct memory_span address_span(const struct address_facts *facts)
{
    return memory_span_of(facts->memory, facts->begin, facts->bytes_left);
}

void assert_span(struct memory_span span, unsigned memory_n, VkDeviceSize begin, VkDeviceSize end)
{
    assert_ptr_equal(span.memory, memory(memory_n));
    assert_int_equal(span.begin, begin);
    assert_int_equal(span.end, end);
}

/* ---- sparse buffers */

void note_piece(void *user, const struct memory_span *piece)
{
    struct pieces *pieces = user;
    assert_true(pieces->count < 64);
    pieces->spans[pieces->count++] = *piece;
}

struct pieces pieces_of(struct resources *resources, unsigned n, VkDeviceSize begin,
                        VkDeviceSize end)
{
    struct pieces pieces = {.count = 0};
    const uint64_t id =
        resources_find_id(resources, RESOURCE_BUFFER, (uint64_t)(uintptr_t)buffer(n));
    const struct sparse_bytes bytes = {buffer(n), id, begin, end};
    resources_find_pieces(resources, &bytes, &all_of_queue_1, note_piece, &pieces);
    return pieces;
}

void expect_pieces(struct pieces pieces, const struct memory_span *spans, unsigned count)
{
    assert_int_equal(pieces.count, count);
    for (unsigned i = 0; i < count; i++) {
        assert_ptr_equal(pieces.spans[i].memory, spans[i].memory);
        assert_int_equal(pieces.spans[i].begin, spans[i].begin);
        assert_int_equal(pieces.spans[i].end, spans[i].end);
    }
}

struct resources *a_structure_in_pages(void)
{
    struct resources *resources = no_resources();
    for (unsigned n = 1; n <= MEMORIES; n++)
        have_memory(resources, n);
    have_sparse_buffer(resources, 1, PAGES * PAGE);
    have_accel(resources, 1, 1, PAGE, 6 * PAGE);
    return resources;
}

enum tristate backed_for(struct resources *resources, const struct execution_clock *clock)
{
    struct accel_facts facts = accel_facts(resources, 1);
    assert_null(facts.memory);
    if (!facts.is_sparse)
        return facts.backed;
    assert_int_equal(facts.backed, UNKNOWN);
    const struct sparse_bytes bytes = {facts.buffer, facts.buffer_id, facts.begin,
                                       facts.begin + facts.size};
    struct sparse_bytes missing;
    enum tristate answer = resources_sparse_backing(resources, &bytes, clock, &missing);
    if (answer == NO)
        assert_true(missing.begin < missing.end && missing.begin >= bytes.begin &&
                    missing.end <= bytes.end);
    return answer;
}

enum tristate backed(struct resources *resources)
{
    return backed_for(resources, &all_of_queue_1);
}

/* ---- command buffers */

struct command_buffers *some_command_buffers(void)
{
    const VkCommandBuffer primaries[] = {handle(1), handle(2)}, secondary = handle(3);
    struct command_buffers *all = NULL;
    assert_int_equal(command_buffers_create(&all), VK_SUCCESS);
    command_buffers_add_pool(all, pool(1), 0, VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT, false);
    command_buffers_add(all, pool(1), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 2, primaries);
    command_buffers_add(all, pool(1), VK_COMMAND_BUFFER_LEVEL_SECONDARY, 1, &secondary);
    return all;
}

void add(struct command_buffers *all, unsigned pool_n, unsigned n)
{
    const VkCommandBuffer added = handle(n);
    command_buffers_add(all, pool(pool_n), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &added);
}

void take_away(struct command_buffers *all, unsigned n)
{
    const VkCommandBuffer removed = handle(n);
    command_buffers_remove(all, 1, &removed);
}

struct command_buffer_facts facts_of(struct command_buffers *all, unsigned n)
{
    struct command_buffer_facts facts;
    command_buffers_facts(all, command_buffers_find(all, handle(n)), handle(n), &facts);
    return facts;
}

void begin_with(struct command_buffers *all, unsigned n, VkCommandBufferUsageFlags flags,
                VkResult result)
{
    command_buffer_begin(command_buffers_find(all, handle(n)),
                         &MAKE(VkCommandBufferBeginInfo, .flags = flags), 0, result);
}

struct command_buffer *begin(struct command_buffers *all, unsigned n)
{
    begin_with(all, n, 0, VK_SUCCESS);
    return command_buffers_find(all, handle(n));
}
