/* SPDX-License-Identifier: Apache-2.0 */
/* Sort and sweep with an active set: n log n in the ranges, linear where they come in order, plus
 * the pairs found. */
#include "check/sweep.h"

#include <stdlib.h>
#include <string.h>

void sweep_empty(struct sweep *sweep)
{
    for (int role = 0; role < ROLE_COUNT; role++) {
        struct range_list *list = &sweep->roles[role];
        list->count = 0;
        list->sorted_by_bytes = true;
        list->ascending_handles = true;
    }
    sweep->out_of_memory = false;
}

void sweep_init(struct sweep *sweep)
{
    for (int role = 0; role < ROLE_COUNT; role++) {
        sweep->roles[role].items = sweep->roles[role].inline_items;
        sweep->roles[role].capacity = SWEEP_INLINE_RANGES;
    }
    sweep_empty(sweep);
}

void sweep_release(struct sweep *sweep)
{
    for (int role = 0; role < ROLE_COUNT; role++)
        if (sweep->roles[role].items != sweep->roles[role].inline_items)
            free(sweep->roles[role].items);
}

static bool grow(struct range_list *list)
{
    uint32_t capacity = list->capacity * 4;
    bool is_inline = list->items == list->inline_items;
    struct used_range *items =
        realloc(is_inline ? NULL : list->items, (size_t)capacity * sizeof(*items));
    if (!items)
        return false;
    if (is_inline)
        memcpy(items, list->inline_items, sizeof(list->inline_items));
    list->items = items;
    list->capacity = capacity;
    return true;
}

static int compare_numbers(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

static int compare_bytes(const struct used_range *a, const struct used_range *b)
{
    int order =
        compare_numbers((uint64_t)(uintptr_t)a->span.memory, (uint64_t)(uintptr_t)b->span.memory);
    return order ? order : compare_numbers(a->span.begin, b->span.begin);
}

void sweep_add(struct sweep *sweep, const struct used_range *range)
{
    struct range_list *list = &sweep->roles[range->role];
    if (list->count == list->capacity && !grow(list)) {
        sweep->out_of_memory = true;
        return;
    }
    if (list->count) {
        const struct used_range *last = &list->items[list->count - 1];
        if (compare_bytes(last, range) > 0)
            list->sorted_by_bytes = false;
        if ((uint64_t)(uintptr_t)last->handle >= (uint64_t)(uintptr_t)range->handle)
            list->ascending_handles = false;
    }
    list->items[list->count++] = *range;
}

/* Equal handles. */

static int order_by_handle(const void *a, const void *b)
{
    const struct used_range *x = *(const struct used_range *const *)a;
    const struct used_range *y = *(const struct used_range *const *)b;
    int order = compare_numbers((uint64_t)(uintptr_t)x->handle, (uint64_t)(uintptr_t)y->handle);
    return order ? order : compare_numbers(x->build, y->build);
}

/* Pointers to the structures of a list by handle, of those in pieces to one piece; NULL without
 * memory. */
static const struct used_range **by_handle(const struct range_list *list, uint32_t *count)
{
    const struct used_range **sorted = malloc((list->count + 1) * sizeof(*sorted));
    if (!sorted)
        return NULL;
    for (uint32_t i = 0; i < list->count; i++)
        sorted[i] = &list->items[i];
    if (!list->ascending_handles)
        qsort(sorted, list->count, sizeof(*sorted), order_by_handle);
    *count = 0;
    for (uint32_t i = 0; i < list->count; i++)
        if (sorted[i]->handle && (!*count || order_by_handle(&sorted[*count - 1], &sorted[i]) != 0))
            sorted[(*count)++] = sorted[i];
    return sorted;
}

static void visit_equal_dsts(const struct used_range **dsts, uint32_t count, pair_visitor visit,
                             void *user)
{
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = i + 1; j < count && dsts[j]->handle == dsts[i]->handle; j++)
            if (!visit(user, dsts[i], dsts[j], NULL))
                return;
}

static void visit_equal_srcs(const struct used_range **dsts, uint32_t dst_count,
                             const struct used_range **srcs, uint32_t src_count, pair_visitor visit,
                             void *user)
{
    uint32_t first = 0;
    for (uint32_t s = 0; s < src_count; s++) {
        uint64_t handle = (uint64_t)(uintptr_t)srcs[s]->handle;
        while (first < dst_count && (uint64_t)(uintptr_t)dsts[first]->handle < handle)
            first++;
        for (uint32_t d = first; d < dst_count && dsts[d]->handle == srcs[s]->handle; d++)
            if (dsts[d]->build != srcs[s]->build && !visit(user, dsts[d], srcs[s], NULL))
                return;
    }
}

void sweep_equal_handles(struct sweep *sweep, pair_visitor visit, void *user)
{
    const struct range_list *dst = &sweep->roles[ROLE_DST], *src = &sweep->roles[ROLE_SRC];
    if (sweep->out_of_memory || (dst->ascending_handles && !src->count))
        return;
    uint32_t dst_count, src_count;
    const struct used_range **dsts = by_handle(dst, &dst_count);
    const struct used_range **srcs = by_handle(src, &src_count);
    if (dsts && srcs) {
        if (!dst->ascending_handles)
            visit_equal_dsts(dsts, dst_count, visit, user);
        visit_equal_srcs(dsts, dst_count, srcs, src_count, visit, user);
    }
    free(dsts);
    free(srcs);
}

/* Shared memory. */

static int order_by_bytes(const void *a, const void *b)
{
    const struct used_range *x = a, *y = b;
    int order = compare_bytes(x, y);
    return order ? order : compare_numbers(x->build, y->build);
}

/* The ranges met whose end the sweep has not passed, by role. */
struct active_set {
    const struct used_range **items;
    uint32_t count, capacity;
};

struct active_sets {
    struct active_set roles[ROLE_COUNT];
    bool wanted[ROLE_COUNT][ROLE_COUNT]; /* lower role first */
    VkDeviceMemory memory;
};

static bool is_wanted(const struct active_sets *sets, enum range_role a, enum range_role b)
{
    return a < b ? sets->wanted[a][b] : sets->wanted[b][a];
}

static void stop_wanting(struct active_sets *sets, enum range_role a, enum range_role b)
{
    sets->wanted[a < b ? a : b][a < b ? b : a] = false;
}

static void visit_pair(struct active_sets *sets, const struct used_range *a,
                       const struct used_range *b, pair_visitor visit, void *user)
{
    bool is_one = a->role == b->role && a->build == b->build;
    if (is_one || (a->handle && a->handle == b->handle))
        return;
    struct memory_span shared = {.memory = a->span.memory,
                                 .begin =
                                     a->span.begin > b->span.begin ? a->span.begin : b->span.begin,
                                 .end = a->span.end < b->span.end ? a->span.end : b->span.end};
    bool in_order = a->role < b->role || (a->role == b->role && a->build < b->build);
    if (!visit(user, in_order ? a : b, in_order ? b : a, &shared))
        stop_wanting(sets, a->role, b->role);
}

/* Drops what ends at or before `range` from a set, and visits the pairs with what is left. */
static void meet(struct active_sets *sets, struct active_set *set, const struct used_range *range,
                 pair_visitor visit, void *user)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < set->count; i++)
        if (set->items[i]->span.end > range->span.begin)
            set->items[kept++] = set->items[i];
    set->count = kept;
    for (uint32_t i = 0; i < kept; i++) {
        if (!is_wanted(sets, set->items[i]->role, range->role))
            return;
        visit_pair(sets, set->items[i], range, visit, user);
    }
}

static bool activate(struct active_set *set, const struct used_range *range)
{
    if (set->count == set->capacity) {
        uint32_t capacity = set->capacity ? set->capacity * 2 : SWEEP_INLINE_RANGES;
        const struct used_range **items = realloc(set->items, capacity * sizeof(*items));
        if (!items)
            return false;
        set->items = items;
        set->capacity = capacity;
    }
    set->items[set->count++] = range;
    return true;
}

static bool sweep_range(struct active_sets *sets, const struct used_range *range,
                        pair_visitor visit, void *user)
{
    if (range->span.memory != sets->memory) {
        sets->memory = range->span.memory;
        for (int role = 0; role < ROLE_COUNT; role++)
            sets->roles[role].count = 0;
    }
    if (!range->span.memory || range->span.begin >= range->span.end)
        return true;
    bool any_wanted = false;
    for (int role = 0; role < ROLE_COUNT; role++) {
        if (!is_wanted(sets, (enum range_role)role, range->role))
            continue;
        any_wanted = true;
        meet(sets, &sets->roles[role], range, visit, user);
    }
    return !any_wanted || activate(&sets->roles[range->role], range);
}

/* The role whose next range comes first, or ROLE_COUNT at the end. */
static int next_role(const struct sweep *sweep, const uint32_t next[ROLE_COUNT])
{
    int first = ROLE_COUNT;
    for (int role = 0; role < ROLE_COUNT; role++) {
        const struct range_list *list = &sweep->roles[role];
        if (next[role] < list->count &&
            (first == ROLE_COUNT ||
             compare_bytes(&list->items[next[role]], &sweep->roles[first].items[next[first]]) < 0))
            first = role;
    }
    return first;
}

void sweep_shared_memory(struct sweep *sweep, pair_visitor visit, void *user)
{
    if (sweep->out_of_memory)
        return;
    for (int role = 0; role < ROLE_COUNT; role++) {
        struct range_list *list = &sweep->roles[role];
        if (list->sorted_by_bytes)
            continue;
        qsort(list->items, list->count, sizeof(*list->items), order_by_bytes);
        list->sorted_by_bytes = true;
        list->ascending_handles = false;
    }

    struct active_sets sets = {0};
    memset(sets.wanted, true, sizeof(sets.wanted));
    stop_wanting(&sets, ROLE_SRC, ROLE_SRC); /* both are only read, and may be many of one */
    uint32_t next[ROLE_COUNT] = {0};
    for (int role; (role = next_role(sweep, next)) != ROLE_COUNT;)
        if (!sweep_range(&sets, &sweep->roles[role].items[next[role]++], visit, user))
            break;
    for (int role = 0; role < ROLE_COUNT; role++)
        free(sets.roles[role].items);
}
