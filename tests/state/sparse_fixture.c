/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/state/sparse_fixture.h"

void note_piece(void *user, const struct memory_span *piece)
{
    struct pieces *pieces = user;
    assert_true(pieces->count < 64);
    pieces->spans[pieces->count++] = *piece;
}

static struct sparse_bytes bytes_of(struct resources *resources, unsigned n, VkDeviceSize begin,
                                    VkDeviceSize end)
{
    return (struct sparse_bytes){
        buffer(n), resources_find_id(resources, RESOURCE_BUFFER, (uint64_t)(uintptr_t)buffer(n)),
        begin, end};
}

struct pieces pieces_of(struct resources *resources, unsigned n, VkDeviceSize begin,
                        VkDeviceSize end)
{
    struct pieces pieces = {.count = 0};
    const struct sparse_bytes bytes = bytes_of(resources, n, begin, end);
    resources_find_pieces(resources, &bytes, &all_of_queue_1, note_piece, &pieces);
    return pieces;
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
