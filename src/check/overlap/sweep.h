/* SPDX-License-Identifier: Apache-2.0 */
/* Collects the structures and memory ranges that a call uses, and finds every pair of them that is
 * equal or shares memory. */
#ifndef ASSAY_CHECK_OVERLAP_SWEEP_H
#define ASSAY_CHECK_OVERLAP_SWEEP_H

#include <stdbool.h>
#include <stddef.h>

#include "src/check/overlap/sort.h"
#include "src/view/view.h"

enum { ROLE_COUNT = 3, SWEEP_INLINE_RANGES = 16 };

/* A range is paired with so many ranges of another kind at most, so that a search stays linear in
 * the ranges if all of them conflict. */
enum { SWEEP_PARTNERS = 128 };

/* Ranges by the rules about them: those about two ranges depend on the kinds of both. */
enum range_kind { KIND_DST, KIND_SRC, KIND_MICROMAP, KIND_INSTANCE, KIND_SCRATCH, KIND_COUNT };

static inline enum range_kind range_kind(const struct used_range *range)
{
    if (range->role == ROLE_SRC)
        return range->is_micromap ? KIND_MICROMAP : range->is_instance ? KIND_INSTANCE : KIND_SRC;
    return range->role == ROLE_DST ? KIND_DST : KIND_SCRATCH;
}

/* The ranges of one role, in the order of their builds. Whether they are also in the order of their
 * bytes, with none in another, and of their handles, is noted as they come, so that a call in order
 * is neither sorted nor swept. */
struct range_list {
    uint32_t count, capacity;
    bool unsorted, touching, handles_unsorted; /* touching: or unsorted */
    bool has_nowhere;                          /* one is of no bytes, or none that are known */
    struct used_range *items, inline_items[SWEEP_INLINE_RANGES];
};

struct sweep {
    struct range_list roles[ROLE_COUNT];
    struct noted_range *noted; /* ranges of sparse buffers, which are not compared */
    uint32_t noted_count, noted_capacity;
    bool out_of_memory; /* ranges were lost: nothing is reported */
    bool has_memory;    /* of its own, to be released */
    bool is_begun;      /* false: all else is not set */
    void *space;        /* of a search, kept for the next one */
    size_t space_size;  /* bytes */
};

void sweep_init(struct sweep *sweep);
void sweep_empty(struct sweep *sweep); /* keeps its memory */
void sweep_release(struct sweep *sweep);

/* Room for what a search needs, of whatever content; NULL without memory. */
void *sweep_space(struct sweep *sweep, size_t size);

/* Makes room in a list; false without memory. */
__attribute__((cold)) bool sweep_grow(struct sweep *sweep, struct range_list *list);

/* What becomes of a list with a range behind its last one. */
static inline void sweep_note_order(struct range_list *list, const struct used_range *last,
                                    const struct used_range *range)
{
    bool same_memory = last->span.memory == range->span.memory;
    if (!(same_memory ? last->span.begin <= range->span.begin : range_compare(last, range) < 0))
        list->unsorted = list->touching = true;
    if (same_memory && last->span.end > range->span.begin)
        list->touching = true;
    if ((uint64_t)(uintptr_t)last->handle >= (uint64_t)(uintptr_t)range->handle)
        list->handles_unsorted = true;
}

/* Room for a range of a role, to be filled and then kept; NULL without memory. Of each build there
 * are two or three: they are made where they are to lie. */
static inline struct used_range *sweep_room(struct sweep *sweep, enum range_role role)
{
    struct range_list *list = &sweep->roles[role];
    if (list->count == list->capacity && !sweep_grow(sweep, list)) {
        sweep->out_of_memory = true;
        return NULL;
    }
    return &list->items[list->count];
}

static inline void sweep_keep(struct sweep *sweep, const struct used_range *range)
{
    struct range_list *list = &sweep->roles[range->role];
    list->has_nowhere |= range->span.begin >= range->span.end;
    if (list->count++)
        sweep_note_order(list, range - 1, range);
}

void sweep_add(struct sweep *sweep, const struct used_range *range);
__attribute__((cold)) void sweep_note(struct sweep *sweep, const struct noted_range *noted);
/* All that was added with memory, or noted, to be freed by the caller; NULL without memory. */
struct noted_ranges *sweep_all_ranges(const struct sweep *sweep);

/* Whether it is plain that no pair will be visited, as it is of most calls: where no two ranges
 * share memory no two are of one structure. */
bool sweep_finds_nothing(struct sweep *sweep);

/* Takes a pair. Returns false if no more pairs of these two kinds are wanted. */
typedef bool (*pair_visitor)(void *user, const struct used_range *a, const struct used_range *b,
                             const struct memory_span *shared);

/* Visits the pairs of equal handles (`shared` is NULL): two dst, or a src and another build's dst.
 * A structure in pieces counts once. */
void sweep_equal_handles(struct sweep *sweep, pair_visitor visit, void *user);

/* Visits the pairs that share memory, except those of equal handles, of two src, of a scratch with
 * a micromap or instance, and of two pieces of one structure or scratch. */
void sweep_shared_memory(struct sweep *sweep, pair_visitor visit, void *user);

#endif
