/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of how good guesses at places are; that they are no more than guesses is tested with the
 * map (address_map_test.c). */
#include "random.h"
#include "src/state/resources/address_map.h"
#include "tests/state/unit_test.h"

enum { PLACES = 12000 };

typedef struct address_facts (*layout)(uint32_t i);

/* How many places of a hundred are guessed, though no look-up has been for them: of their first
 * addresses, or of any. */
static unsigned guessed(layout lie, uint32_t count, bool any)
{
    struct random random = random_of("address_guesses");
    struct address_map map = {0};
    unsigned right = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct address_facts place = lie(i);
        assert_true(address_map_add(&map, &place));
    }
    const struct address_guesses guesses = address_map_guesses(&map);
    for (uint32_t i = 0; i < count; i++) {
        const struct address_facts place = lie(i);
        uint64_t address = place.address + (any ? random_next(&random) % place.bytes_left : 0);
        right += buffer_range_contains(address_guesses_find(&guesses, address), address);
    }
    address_map_release(&map);
    return right * 100 / count;
}

static struct address_facts one_heap(uint32_t i)
{
    return (struct address_facts){.address = 0x100000000u + i * 0x3000ull, .bytes_left = 0x2100};
}

/* In turn, of buffers of three sizes. */
static struct address_facts three_heaps(uint32_t i)
{
    const uint64_t heaps[] = {0x7f0012340000u, 0x7f0123400000u, 0x7f0155550100u};
    const uint64_t sizes[] = {0x1000, 0x100, 0x500};
    return (struct address_facts){.address = heaps[i % 3] + i / 3 * sizes[i % 3],
                                  .bytes_left = sizes[i % 3]};
}

static struct address_facts few_large(uint32_t i)
{
    return (struct address_facts){.address = 0x100000000u * (1ull + i), .bytes_left = 0x100000000u};
}

TEST(test_places_are_guessed_as_they_come)
{
    assert_in_range(guessed(one_heap, PLACES, false), 95, 100);
    assert_in_range(guessed(three_heaps, PLACES, false), 85, 100);
}

TEST(test_any_address_of_a_large_place_is_guessed)
{
    assert_int_equal(guessed(few_large, 7, true), 100);
}

/* Large ones first, so that their grains are too coarse for what comes later. */
static struct address_facts large_then_small(uint32_t i)
{
    const uint64_t small = 0x100000000000u + i * 0x100ull;
    return i < 7 ? few_large(i) : (struct address_facts){.address = small, .bytes_left = 0x80};
}

TEST(test_grains_are_chosen_anew)
{
    assert_in_range(guessed(large_then_small, 60, false), 90, 100);
    assert_in_range(guessed(large_then_small, PLACES, false), 90, 100);
}
