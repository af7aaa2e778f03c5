/* SPDX-License-Identifier: Apache-2.0 */
/* Collects the structures and memory ranges that a call uses, and finds every pair that is the same
 * structure or shares memory. Not locked: one thread uses a sweep at a time. */
#ifndef ASSAY_CHECK_OVERLAP_SWEEP_H
#define ASSAY_CHECK_OVERLAP_SWEEP_H

#include <stdbool.h>
#include <stddef.h>

#include "src/base/unknown.h"
#include "src/view/view.h"

/* ---- ranges, sorted by their first byte */

/* The first byte of a range, and the index of the range. */
struct range_key {
    uint64_t memory, begin;
    uint32_t index;
};

/* Returns a value below, equal to or above 0 if `a` begins before, with or after `b`. Ranges of
 * different memory are ordered by the memory's handle. */
int range_compare(const struct used_range *a, const struct used_range *b);

/* Writes the indices of the ranges to `order`, sorted by first byte; the sort is stable. `keys` has
 * room for 2 * count keys. */
void range_order(const struct used_range *ranges, uint32_t count, uint32_t *order,
                 struct range_key *keys);

/* ---- the sweep */

enum { ROLE_COUNT = 3, SWEEP_INLINE_RANGES = 16 };

/* The maximum number of ranges of another kind that a range is paired with. It keeps a search
 * linear in the ranges even if all of them conflict. */
enum { SWEEP_PARTNERS = 128 };

/* The rules about two ranges depend on the kinds of both. */
enum range_kind { KIND_DST, KIND_SRC, KIND_MICROMAP, KIND_INSTANCE, KIND_SCRATCH, KIND_COUNT };

static inline enum range_kind range_kind(const struct used_range *range)
{
    if (range->role == ROLE_SRC)
        return range->is_micromap ? KIND_MICROMAP : range->is_instance ? KIND_INSTANCE : KIND_SRC;
    return range->role == ROLE_DST ? KIND_DST : KIND_SCRATCH;
}

/* The ranges of one role, in the order of their builds. Flags are updated as ranges are added, so
 * that a call whose ranges are in order needs no sort and no sweep. */
struct range_list {
    uint32_t count, capacity;
    bool unsorted, overlapping, handles_unsorted; /* overlapping: true if unsorted, too */
    bool has_empty;                               /* a range is empty or its bytes are unknown */
    struct used_range *items, inline_items[SWEEP_INLINE_RANGES];
};

struct sweep {
    struct range_list roles[ROLE_COUNT];
    struct noted_range *noted; /* ranges of sparse buffers, which are compared when the call
                                * executes */
    uint32_t noted_count, noted_capacity;
    struct unknown unknown; /* ranges are missing: no pair is visited */
    bool has_memory;        /* sweep_release() must free memory */
    bool is_initialized; /* false: sweep_init() has not been called, other members are undefined */
    void *space;         /* working memory of searches, reused */
    size_t space_size;   /* in bytes */
};

/* Makes an empty sweep. */
void sweep_init(struct sweep *sweep);
void sweep_empty(struct sweep *sweep); /* removes all ranges, keeps the memory */
void sweep_release(struct sweep *sweep);

/* Returns `size` bytes of uninitialized working memory, which stay valid until the next call.
 * Returns NULL if there is no memory. */
void *sweep_space(struct sweep *sweep, size_t size);

/* Enlarges a list. Returns false if there is no memory. */
__attribute__((cold)) bool sweep_grow(struct sweep *sweep, struct range_list *list);

/* Updates the flags of a list for a range that is added after its last one. */
static inline void sweep_note_order(struct range_list *list, const struct used_range *last,
                                    const struct used_range *range)
{
    bool same_memory = last->span.memory == range->span.memory;
    if (!(same_memory ? last->span.begin <= range->span.begin : range_compare(last, range) < 0))
        list->unsorted = list->overlapping = true;
    if (same_memory && last->span.end > range->span.begin)
        list->overlapping = true;
    if (handle_number(last->handle) >= handle_number(range->handle))
        list->handles_unsorted = true;
}

/* Returns room for a range of a role, which the caller fills and passes to sweep_keep(). Ranges are
 * filled in place because each build has two or three. Returns NULL if there is no memory. */
static inline struct used_range *sweep_room(struct sweep *sweep, enum range_role role)
{
    struct range_list *list = &sweep->roles[role];
    if (list->count == list->capacity && !sweep_grow(sweep, list)) {
        unknown_set(&sweep->unknown, UNKNOWN_RANGES);
        return NULL;
    }
    return &list->items[list->count];
}

/* Adds the range that sweep_room() returned last for its role. */
static inline void sweep_keep(struct sweep *sweep, const struct used_range *range)
{
    struct range_list *list = &sweep->roles[range->role];
    list->has_empty |= range->span.begin >= range->span.end;
    if (list->count++)
        sweep_note_order(list, range - 1, range);
}

/* Adds a copy of a range. */
void sweep_add(struct sweep *sweep, const struct used_range *range);
/* Adds a copy of a range that is compared when the call executes. */
__attribute__((cold)) void sweep_note(struct sweep *sweep, const struct noted_range *noted);
/* Returns all ranges that have known memory or were noted; the caller frees them. Returns NULL if
 * there is no memory. */
struct noted_ranges *sweep_all_ranges(const struct sweep *sweep);

/* Returns true if no pair will be visited, as in most calls: if no two ranges share memory, no two
 * are of the same structure. */
bool sweep_finds_nothing(struct sweep *sweep);

/* Receives a pair. Returns false if it needs no more pairs of these two kinds. */
typedef bool (*pair_visitor)(void *user, const struct used_range *a, const struct used_range *b,
                             const struct memory_span *shared);

/* Visits the pairs of equal handles with `shared` NULL: two dst, or a src and the dst of another
 * build. A structure in several pieces counts once. */
void sweep_equal_handles(struct sweep *sweep, pair_visitor visit, void *user);

/* Visits the pairs that share memory, except for pairs of equal handles, of two src, of a scratch
 * with a micromap or instance, and of two pieces of one structure or scratch. */
void sweep_shared_memory(struct sweep *sweep, pair_visitor visit, void *user);

#endif
