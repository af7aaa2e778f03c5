/* SPDX-License-Identifier: Apache-2.0 */
/* Finds equal handles with a hash table and by sorting. A range has a bounded number of
 * partners. */
#include <stdlib.h>
#include <string.h>

#include "src/check/overlap/sweep.h"

/* A hash set of structures. A slot holds 1 + an index into `structures`, or 0 if empty. */
struct structure_set {
    const struct used_range *structures;
    uint32_t *slots;
    unsigned bits; /* log2 of the number of slots */
};

/* Makes a set with room for twice the ranges of the list. Returns false if there is no memory. */
static bool make_set(struct sweep *sweep, const struct range_list *list, struct structure_set *set)
{
    *set = (struct structure_set){.structures = list->items, .bits = 5};
    while ((size_t)1 << set->bits < (size_t)list->count * 2)
        set->bits++;
    size_t size = sizeof(*set->slots) << set->bits;
    set->slots = sweep_space(sweep, size);
    if (set->slots)
        memset(set->slots, 0, size);
    return set->slots != NULL;
}

/* Returns the slot that a structure has or would have. Handles are hashed as in
 * src/base/handle_table.c. */
static uint32_t *slot_of(const struct structure_set *set, VkAccelerationStructureKHR handle)
{
    uint64_t hash = handle_number(handle) * 0x9e3779b97f4a7c15u;
    size_t slot = (size_t)(hash >> (64 - set->bits)), mask = ((size_t)1 << set->bits) - 1;
    while (set->slots[slot] && set->structures[set->slots[slot] - 1].handle != handle)
        slot = (slot + 1) & mask;
    return &set->slots[slot];
}

/* Adds all dst. Returns whether two builds have the same dst. */
static bool add_dsts(struct structure_set *set, const struct range_list *dst)
{
    for (uint32_t i = 0; i < dst->count; i++) {
        if (!dst->items[i].handle)
            continue;
        uint32_t *slot = slot_of(set, dst->items[i].handle);
        if (!*slot)
            *slot = i + 1;
        else if (dst->items[*slot - 1].build != dst->items[i].build)
            return true;
    }
    return false;
}

/* Returns whether a src is the dst of another build. No two builds have the same dst. */
static bool has_dst_of_other_build(const struct structure_set *set, const struct range_list *src)
{
    for (uint32_t i = 0; i < src->count; i++) {
        const struct used_range *range = &src->items[i];
        uint32_t slot = range->handle ? *slot_of(set, range->handle) : 0;
        if (slot && set->structures[slot - 1].build != range->build)
            return true;
    }
    return false;
}

/* Returns false if there is no memory, too. */
static bool has_equal_handles(struct sweep *sweep)
{
    const struct range_list *dst = &sweep->roles[ROLE_DST], *src = &sweep->roles[ROLE_SRC];
    struct structure_set set;
    if (!dst->handles_unsorted && !src->count)
        return false;
    return make_set(sweep, dst, &set) && (add_dsts(&set, dst) || has_dst_of_other_build(&set, src));
}

static int compare_numbers(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

static int order_by_handle(const void *a, const void *b)
{
    const struct used_range *x = *(const struct used_range *const *)a;
    const struct used_range *y = *(const struct used_range *const *)b;
    int order = compare_numbers(handle_number(x->handle), handle_number(y->handle));
    return order ? order : compare_numbers(x->build, y->build);
}

/* Returns pointers to the structures of a list, sorted by handle, with one piece for each sparse
 * structure. The caller frees them. Returns NULL if there is no memory. */
static const struct used_range **sort_by_handle(const struct range_list *list, uint32_t *count)
{
    const struct used_range **sorted = malloc((list->count + 1) * sizeof(*sorted));
    if (!sorted)
        return NULL;
    for (uint32_t i = 0; i < list->count; i++)
        sorted[i] = &list->items[i];
    if (list->handles_unsorted)
        qsort(sorted, list->count, sizeof(*sorted), order_by_handle);
    *count = 0;
    for (uint32_t i = 0; i < list->count; i++)
        if (sorted[i]->handle && (!*count || order_by_handle(&sorted[*count - 1], &sorted[i]) != 0))
            sorted[(*count)++] = sorted[i];
    return sorted;
}

/* Returns the index after the last partner of a range whose partners begin at `first`. */
static uint32_t end_of_partners(uint32_t first, uint32_t count)
{
    return count - first < SWEEP_PARTNERS ? count : first + SWEEP_PARTNERS;
}

static void visit_equal_dsts(const struct used_range **dsts, uint32_t count, pair_visitor visit,
                             void *user)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t end = end_of_partners(i + 1, count);
        for (uint32_t j = i + 1; j < end && dsts[j]->handle == dsts[i]->handle; j++)
            if (!visit(user, dsts[i], dsts[j], NULL))
                return;
    }
}

static void visit_equal_srcs(const struct used_range **dsts, uint32_t dst_count,
                             const struct used_range **srcs, uint32_t src_count, pair_visitor visit,
                             void *user)
{
    bool done_kinds[KIND_COUNT] = {false};
    uint32_t first = 0;
    for (uint32_t s = 0; s < src_count; s++) {
        uint64_t handle = handle_number(srcs[s]->handle);
        while (first < dst_count && handle_number(dsts[first]->handle) < handle)
            first++;
        bool *done = &done_kinds[range_kind(srcs[s])];
        uint32_t end = end_of_partners(first, dst_count);
        for (uint32_t d = first; d < end && dsts[d]->handle == srcs[s]->handle && !*done; d++)
            if (dsts[d]->build != srcs[s]->build)
                *done = !visit(user, dsts[d], srcs[s], NULL);
    }
}

void sweep_equal_handles(struct sweep *sweep, pair_visitor visit, void *user)
{
    if (unknown_is_set(&sweep->unknown) || !has_equal_handles(sweep))
        return;
    uint32_t dst_count, src_count;
    const struct used_range **dsts = sort_by_handle(&sweep->roles[ROLE_DST], &dst_count);
    const struct used_range **srcs = sort_by_handle(&sweep->roles[ROLE_SRC], &src_count);
    if (dsts && srcs) {
        visit_equal_dsts(dsts, dst_count, visit, user);
        visit_equal_srcs(dsts, dst_count, srcs, src_count, visit, user);
    }
    free(dsts);
    free(srcs);
}
