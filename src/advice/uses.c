/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/uses.h"

/* Returns what became of a structure, with the lock held; NULL if there is no memory or no record.
 */
static struct structure_uses *lock_uses(struct structures *structures, uint64_t id, bool *is_known)
{
    return structures_lock_notes(structures, id, sizeof(struct structure_uses), is_known);
}

bool uses_note(struct structures *structures, uint64_t id, enum structure_use use)
{
    bool is_known;
    struct structure_uses *uses = lock_uses(structures, id, &is_known);
    if (uses)
        uses->counts[use]++;
    structures_unlock_notes(structures);
    return is_known;
}

bool uses_note_build(struct structures *structures, uint64_t id, uint32_t submission,
                     VkBuildAccelerationStructureFlagsKHR flags, VkDeviceSize needed)
{
    bool is_known;
    struct structure_uses *uses = lock_uses(structures, id, &is_known);
    if (uses && !uses->counts[USE_BUILT]++) {
        uses->first_build = submission;
        uses->flags = flags;
    }
    if (uses) {
        uses->flags &= flags;
        uses->needed_size = needed;
    }
    structures_unlock_notes(structures);
    return is_known;
}

bool uses_note_compacted_size(struct structures *structures, uint64_t id, VkDeviceSize size)
{
    bool is_known;
    struct structure_uses *uses = lock_uses(structures, id, &is_known);
    if (uses)
        uses->compacted_size = size;
    structures_unlock_notes(structures);
    return is_known;
}

/* Returns what became of a structure, with the lock held. NULL if it was destroyed, or if nothing
 * is known. */
static struct structure_uses *lock_known_uses(const struct structures *structures, uint64_t id)
{
    bool is_known;
    return structures_lock_notes(structures, id, 0, &is_known);
}

bool uses_note_tiny(const struct structures *structures, uint64_t id, bool is_tiny)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    const bool was_tiny = uses && uses->is_tiny;
    if (uses)
        uses->is_tiny = is_tiny;
    structures_unlock_notes(structures);
    return was_tiny;
}

static bool is_power_of_two(uint32_t number)
{
    return !(number & (number - 1));
}

static bool is_power_of_eight(uint32_t number)
{
    return is_power_of_two(number) && number & 0x49249249;
}

/* Which builds are compared with the next one, and with those compared before. Input that takes
 * turns with others would hide at powers of two alone. */
enum { COMPARED_EACH = 127 };

static bool begins_comparison(uint32_t number)
{
    return is_power_of_two(number) || number % COMPARED_EACH == 0;
}

struct reading_wanted uses_begin_read(const struct structures *structures, uint64_t id)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    struct reading_wanted wanted = {0};
    if (uses) {
        const uint32_t before = uses->read_builds++, number = uses->read_builds;
        wanted.number = number;
        wanted.is_judged = is_power_of_eight(number) || uses->hollow_builds == before;
        wanted.is_compared = begins_comparison(number) || begins_comparison(before);
    }
    structures_unlock_notes(structures);
    return wanted;
}

static bool is_equal(const struct input_digest *one, const struct input_digest *other)
{
    return one->words[0] == other->words[0] && one->words[1] == other->words[1] &&
           one->is_top == other->is_top;
}

/* A top-level structure has the bounds of other structures. These have not changed if no other
 * structure was written in between. */
static bool is_repeated(const struct input_repeats *known, uint32_t number,
                        const struct input_digest *digest)
{
    return known->is_known && is_equal(&known->last, digest) &&
           (!digest->is_top ||
            digest->serial - known->last.serial == (uint64_t)number - known->number);
}

/* Returns whether the input is that of the build just before. */
static bool note_digest(struct input_repeats *known, uint32_t number,
                        const struct input_digest *digest)
{
    const bool is_same = digest && is_repeated(known, number, digest),
               is_next = is_same && number == known->number + 1;
    known->since = is_same ? known->since : number;
    known->equal_ones = is_same ? known->equal_ones + is_next : 0;
    known->number = number;
    known->is_known = digest;
    if (digest)
        known->last = *digest;
    return is_next;
}

bool uses_note_input(const struct structures *structures, uint64_t id,
                     const struct input_digest *digest)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    const bool asks = uses && note_digest(&uses->repeats, uses->read_builds, digest) &&
                      is_power_of_two(uses->repeats.equal_ones);
    structures_unlock_notes(structures);
    return asks;
}

void uses_note_shared(const struct structures *structures, uint64_t id)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    if (uses)
        uses->repeats.is_shared = true;
    structures_unlock_notes(structures);
}

void uses_note_contents(const struct structures *structures, uint64_t id,
                        const struct structure_contents *contents)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    if (uses && structure_is_hollow(contents)) {
        uses->hollow_builds++;
        uses->contents = *contents;
    }
    if (uses) {
        uses->has_box = contents->has_box;
        uses->box = contents->box;
    }
    structures_unlock_notes(structures);
}

/* ---- boxes. The one write is the one that the box is of. */

static bool was_written_once(const struct structure_uses *uses)
{
    return uses->counts[USE_BUILT] + uses->counts[USE_UPDATED] + uses->counts[USE_FILLED] == 1;
}

bool uses_find_box(const struct structures *structures, uint64_t id, struct figure_box *box)
{
    const struct structure_uses *uses = lock_known_uses(structures, id);
    const bool is_known = uses && uses->has_box && was_written_once(uses);
    if (is_known)
        *box = uses->box;
    structures_unlock_notes(structures);
    return is_known;
}

void uses_copy_box(const struct structures *structures, uint64_t dst_id, uint64_t src_id)
{
    struct figure_box box;
    const bool is_known = uses_find_box(structures, src_id, &box);
    struct structure_uses *uses = lock_known_uses(structures, dst_id);
    if (uses && is_known) {
        uses->has_box = true;
        uses->box = box;
    }
    structures_unlock_notes(structures);
}

void uses_copy_haste(const struct structures *structures, uint64_t dst_id, uint64_t src_id,
                     uint32_t submission)
{
    const struct structure_uses *src = lock_known_uses(structures, src_id);
    const bool is_hasty =
        src && was_written_once(src) &&
        ((src->counts[USE_BUILT] &&
          src->flags & VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR) ||
         src->is_hasty_copy);
    structures_unlock_notes(structures);
    struct structure_uses *dst = is_hasty ? lock_known_uses(structures, dst_id) : NULL;
    if (dst && was_written_once(dst)) {
        dst->is_hasty_copy = true;
        dst->first_build = submission;
    }
    if (is_hasty)
        structures_unlock_notes(structures);
}

bool uses_note_advised(const struct structures *structures, uint64_t id, unsigned advice)
{
    const uint64_t bit = UINT64_C(1) << advice;
    struct structure_uses *uses = lock_known_uses(structures, id);
    const bool is_first = uses && !(uses->advised & bit);
    if (is_first)
        uses->advised |= bit;
    structures_unlock_notes(structures);
    return is_first;
}

bool uses_find(const struct structures *structures, uint64_t id, struct structure_uses *uses)
{
    bool is_known;
    const struct structure_uses *known = structures_lock_notes(structures, id, 0, &is_known);
    *uses = known ? *known : (struct structure_uses){0};
    structures_unlock_notes(structures);
    return id && is_known;
}
