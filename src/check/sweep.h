/* SPDX-License-Identifier: Apache-2.0 */
/* Collects the structures and memory ranges that a call uses, and finds every pair of them that is
 * equal or shares memory. */
#ifndef ASSAY_CHECK_SWEEP_H
#define ASSAY_CHECK_SWEEP_H

#include <stdbool.h>
#include <stddef.h>

#include "check/view.h"

enum { ROLE_COUNT = 3, SWEEP_INLINE_RANGES = 16 };

/* The ranges of one role, in the order of their builds. Whether they are also in the order of their
 * bytes, with none in another, and of their handles, is noted as they come, so that a call in order
 * is neither sorted nor swept. */
struct range_list {
    struct used_range *items, inline_items[SWEEP_INLINE_RANGES];
    uint32_t count, capacity;
    bool sorted_by_bytes, apart, ascending_handles; /* apart: and sorted */
};

struct sweep {
    struct range_list roles[ROLE_COUNT];
    struct noted_range *noted; /* ranges of sparse buffers, which are not compared */
    uint32_t noted_count, noted_capacity;
    bool out_of_memory; /* ranges were lost: nothing is reported */
    void *space;        /* of a search, kept for the next one */
    size_t space_size;  /* bytes */
};

void sweep_init(struct sweep *sweep);
void sweep_empty(struct sweep *sweep); /* keeps its memory */
void sweep_release(struct sweep *sweep);

/* Room for what a search needs, of whatever content; NULL without memory. */
void *sweep_space(struct sweep *sweep, size_t size);

void sweep_add(struct sweep *sweep, const struct used_range *range);
void sweep_note(struct sweep *sweep, const struct noted_range *noted);
/* All that was added with memory, or noted, to be freed by the caller; NULL without memory. */
struct noted_ranges *sweep_all_ranges(const struct sweep *sweep);

/* Takes a pair. Returns false if no more pairs of these two roles are wanted. */
typedef bool (*pair_visitor)(void *user, const struct used_range *a, const struct used_range *b,
                             const struct memory_span *shared);

/* Visits the pairs of equal handles (`shared` is NULL): two dst, or a src and another build's dst.
 * A structure in pieces counts once. */
void sweep_equal_handles(struct sweep *sweep, pair_visitor visit, void *user);

/* Visits the pairs that share memory, except those of equal handles, of two src, and of two pieces
 * of one structure or scratch. */
void sweep_shared_memory(struct sweep *sweep, pair_visitor visit, void *user);

#endif
