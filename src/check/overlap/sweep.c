/* SPDX-License-Identifier: Apache-2.0 */
/* Radix sort and sweep with active sets of bounded size for shared memory: linear in the ranges. */
#include "src/check/overlap/sweep.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/recording_path.h"
#include "src/check/overlap/sort.h"

void sweep_empty(struct sweep *sweep)
{
    for (int role = 0; role < ROLE_COUNT; role++) {
        struct range_list *list = &sweep->roles[role];
        list->count = 0;
        list->unsorted = list->touching = false;
        list->handles_unsorted = list->has_nowhere = false;
    }
    sweep->noted_count = 0;
    sweep->out_of_memory = false;
}

ON_RECORDING_PATH void sweep_init(struct sweep *sweep)
{
    for (int role = 0; role < ROLE_COUNT; role++) {
        sweep->roles[role].items = sweep->roles[role].inline_items;
        sweep->roles[role].capacity = SWEEP_INLINE_RANGES;
    }
    sweep->noted = NULL;
    sweep->noted_capacity = 0;
    sweep->space = NULL;
    sweep->space_size = 0;
    sweep->has_memory = false;
    sweep->is_begun = true;
    sweep_empty(sweep);
}

void sweep_release(struct sweep *sweep)
{
    if (!sweep->has_memory)
        return;
    for (int role = 0; role < ROLE_COUNT; role++)
        if (sweep->roles[role].items != sweep->roles[role].inline_items)
            free(sweep->roles[role].items);
    free(sweep->noted);
    free(sweep->space);
}

void *sweep_space(struct sweep *sweep, size_t size)
{
    if (size > sweep->space_size) {
        free(sweep->space);
        sweep->space = malloc(size);
        sweep->has_memory = true;
        sweep->space_size = sweep->space ? size : 0;
    }
    return sweep->space;
}

bool sweep_grow(struct sweep *sweep, struct range_list *list)
{
    sweep->has_memory = true;
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

void sweep_add(struct sweep *sweep, const struct used_range *range)
{
    struct used_range *added = sweep_room(sweep, range->role);
    if (!added)
        return;
    *added = *range;
    sweep_keep(sweep, added);
}

/* Shared memory. */

/* The ranges met whose end the sweep has not passed, of one kind; if there are more than it has
 * room for, those that end last. */
struct active_set {
    const struct used_range *items[SWEEP_PARTNERS];
    uint32_t count;
};

struct active_sets {
    struct active_set kinds[KIND_COUNT];
    bool wanted[KIND_COUNT][KIND_COUNT]; /* lower kind first */
    VkDeviceMemory memory;
};

static bool is_wanted(const struct active_sets *sets, enum range_kind a, enum range_kind b)
{
    return a < b ? sets->wanted[a][b] : sets->wanted[b][a];
}

static void stop_wanting(struct active_sets *sets, enum range_kind a, enum range_kind b)
{
    sets->wanted[a < b ? a : b][a < b ? b : a] = false;
}

/* Pairs that no rule is about are not visited: there may be many, of what is only read. */
static void want_all(struct active_sets *sets)
{
    for (int kind = 0; kind < KIND_COUNT; kind++)
        sets->wanted[KIND_DST][kind] = true;
    sets->wanted[KIND_SRC][KIND_SCRATCH] = true;
    sets->wanted[KIND_SCRATCH][KIND_SCRATCH] = true;
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
        stop_wanting(sets, range_kind(a), range_kind(b));
}

/* Drops what ends at or before `range` from the set of a kind, and visits the pairs with what is
 * left. */
static void meet(struct active_sets *sets, enum range_kind kind, const struct used_range *range,
                 pair_visitor visit, void *user)
{
    struct active_set *set = &sets->kinds[kind];
    uint32_t kept = 0;
    for (uint32_t i = 0; i < set->count; i++)
        if (set->items[i]->span.end > range->span.begin)
            set->items[kept++] = set->items[i];
    set->count = kept;
    for (uint32_t i = 0; i < kept && is_wanted(sets, kind, range_kind(range)); i++)
        visit_pair(sets, set->items[i], range, visit, user);
}

/* In a full set a range takes the place of that which ends first, if it ends later: all that are
 * left then share memory with whatever the one that is left out would have met. */
static void activate(struct active_set *set, const struct used_range *range)
{
    if (set->count < SWEEP_PARTNERS) {
        set->items[set->count++] = range;
        return;
    }
    uint32_t first = 0;
    for (uint32_t i = 1; i < SWEEP_PARTNERS; i++)
        if (set->items[i]->span.end < set->items[first]->span.end)
            first = i;
    if (set->items[first]->span.end < range->span.end)
        set->items[first] = range;
}

static void sweep_range(struct active_sets *sets, const struct used_range *range,
                        pair_visitor visit, void *user)
{
    if (range->span.memory != sets->memory) {
        sets->memory = range->span.memory;
        for (int kind = 0; kind < KIND_COUNT; kind++)
            sets->kinds[kind].count = 0;
    }
    if (!range->span.memory || range->span.begin >= range->span.end)
        return;
    bool any_wanted = false;
    for (int kind = 0; kind < KIND_COUNT; kind++) {
        if (!is_wanted(sets, (enum range_kind)kind, range_kind(range)))
            continue;
        any_wanted = true;
        meet(sets, (enum range_kind)kind, range, visit, user);
    }
    if (any_wanted)
        activate(&sets->kinds[range_kind(range)], range);
}

/* The ranges of a role in the order of their bytes, which are those of the list or `order`; before
 * the first is taken `head` is NULL, too. */
struct range_queue {
    const struct used_range *items, *head; /* NULL at the end */
    const uint32_t *order;                 /* or NULL */
    uint32_t next, count;
};

static const struct used_range *item_at(const struct range_queue *queue, uint32_t at)
{
    return &queue->items[queue->order ? queue->order[at] : at];
}

static void advance(struct range_queue *queue)
{
    queue->head = NULL;
    if (queue->next == queue->count)
        return;
    queue->head = item_at(queue, queue->next++);
}

static bool queue_all(struct sweep *sweep, struct range_queue queues[ROLE_COUNT])
{
    uint32_t total = 0, longest = 0;
    for (int role = 0; role < ROLE_COUNT; role++) {
        const struct range_list *list = &sweep->roles[role];
        queues[role] = (struct range_queue){.items = list->items, .count = list->count};
        if (!list->unsorted)
            continue;
        total += list->count;
        longest = list->count > longest ? list->count : longest;
    }
    struct range_key *keys = NULL;
    size_t keys_size = (size_t)longest * 2 * sizeof(*keys);
    if (!total)
        return true;
    if (!(keys = sweep_space(sweep, keys_size + (size_t)total * sizeof(uint32_t))))
        return false;

    uint32_t *order = (uint32_t *)((char *)keys + keys_size);
    for (int role = 0; role < ROLE_COUNT; role++) {
        const struct range_list *list = &sweep->roles[role];
        if (list->unsorted) {
            range_order(list->items, list->count, order, keys);
            queues[role].order = order;
            order += list->count;
        }
    }
    return true;
}

/* The queue whose head comes first, or NULL at the end. */
static struct range_queue *first_of(struct range_queue queues[ROLE_COUNT])
{
    struct range_queue *first = NULL;
    for (int role = 0; role < ROLE_COUNT; role++)
        if (queues[role].head && (!first || range_compare(queues[role].head, first->head) < 0))
            first = &queues[role];
    return first;
}

/* Whether range `a`, which doesn't begin behind `b`, ends before it begins. */
static bool ends_before(const struct used_range *a, const struct used_range *b)
{
    return a->span.memory != b->span.memory || a->span.end <= b->span.begin;
}

static bool role_is_apart(const struct range_list *list, const struct range_queue *queue)
{
    if (!queue->order)
        return !list->touching;
    const struct used_range *before = item_at(queue, 0);
    for (uint32_t i = 1; i < queue->count; i++) {
        const struct used_range *range = item_at(queue, i);
        if (!ends_before(before, range))
            return false;
        before = range;
    }
    return true;
}

/* Whether all up to `last` comes before all from `first` on, of roles that are apart. */
static inline bool is_before(const struct used_range *last, const struct used_range *first)
{
    return last->span.memory == first->span.memory ? last->span.end <= first->span.begin
                                                   : range_compare(last, first) < 0;
}

static bool queue_is_before(const struct range_queue *a, const struct range_queue *b)
{
    return is_before(item_at(a, a->count - 1), item_at(b, 0));
}

static inline bool lists_are_apart(const struct range_list *a, const struct range_list *b)
{
    return !a->count || !b->count || is_before(&a->items[a->count - 1], b->items) ||
           is_before(&b->items[b->count - 1], a->items);
}

/* As all_are_apart, of ranges that came in the order of their bytes. */
static bool all_came_apart(const struct sweep *sweep)
{
    const struct range_list *dst = &sweep->roles[ROLE_DST], *src = &sweep->roles[ROLE_SRC],
                            *scratch = &sweep->roles[ROLE_SCRATCH];
    return !dst->touching && !src->touching && !scratch->touching &&
           lists_are_apart(dst, scratch) && lists_are_apart(dst, src) &&
           lists_are_apart(src, scratch);
}

/* Whether no two ranges share memory because each role has a place of its own, and they are apart
 * there: that is how most calls are, and costs less to see than a sweep. */
static bool all_are_apart(const struct sweep *sweep, const struct range_queue queues[ROLE_COUNT])
{
    for (int a = 0; a < ROLE_COUNT; a++) {
        if (!queues[a].count)
            continue;
        if (!role_is_apart(&sweep->roles[a], &queues[a]))
            return false;
        for (int b = 0; b < a; b++)
            if (queues[b].count && !queue_is_before(&queues[a], &queues[b]) &&
                !queue_is_before(&queues[b], &queues[a]))
                return false;
    }
    return true;
}

/* Inlined, the sets would take stack of each call. */
__attribute__((noinline)) static void sweep_queues(struct range_queue queues[ROLE_COUNT],
                                                   pair_visitor visit, void *user)
{
    struct active_sets sets;
    struct range_queue *queue;
    memset(sets.wanted, false, sizeof(sets.wanted));
    want_all(&sets);
    sets.memory = VK_NULL_HANDLE;
    for (int kind = 0; kind < KIND_COUNT; kind++)
        sets.kinds[kind].count = 0;
    for (int role = 0; role < ROLE_COUNT; role++)
        advance(&queues[role]);
    for (; (queue = first_of(queues)); advance(queue))
        sweep_range(&sets, queue->head, visit, user);
}

__attribute__((noinline)) static void sweep_all(struct sweep *sweep, pair_visitor visit, void *user)
{
    struct range_queue queues[ROLE_COUNT];
    if (queue_all(sweep, queues) && !all_are_apart(sweep, queues))
        sweep_queues(queues, visit, user);
}

__attribute__((noinline)) static bool are_apart_in_order(struct sweep *sweep)
{
    struct range_queue queues[ROLE_COUNT];
    return queue_all(sweep, queues) && all_are_apart(sweep, queues);
}

/* Updates are left to the searches: most share their memory with their sources. */
bool sweep_finds_nothing(struct sweep *sweep)
{
    const struct range_list *dst = &sweep->roles[ROLE_DST], *scratch = &sweep->roles[ROLE_SCRATCH];
    if (sweep->roles[ROLE_SRC].count || (dst->handles_unsorted && dst->has_nowhere))
        return false;
    return all_came_apart(sweep) ||
           ((dst->unsorted || scratch->unsorted) && are_apart_in_order(sweep));
}

void sweep_shared_memory(struct sweep *sweep, pair_visitor visit, void *user)
{
    if (!sweep->out_of_memory && !all_came_apart(sweep))
        sweep_all(sweep, visit, user);
}
