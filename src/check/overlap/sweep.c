/* SPDX-License-Identifier: Apache-2.0 */
/* Finds shared memory by a sort and a sweep with active sets of bounded size, in time linear in the
 * number of ranges. */
#include "src/check/overlap/sweep.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/recording_path.h"

enum { FEW = 16, DIGIT_BITS = 8, DIGITS = 1 << DIGIT_BITS };

static int compare_numbers(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

static uint64_t memory_number(const struct used_range *range)
{
    return handle_number(range->span.memory);
}

int range_compare(const struct used_range *a, const struct used_range *b)
{
    int order = compare_numbers(memory_number(a), memory_number(b));
    return order ? order : compare_numbers(a->span.begin, b->span.begin);
}

/* Few ranges are sorted by insertion, many by radix, one byte of the keys at a time. Bytes that are
 * equal in all keys, as most bytes of handles and offsets are, cost no pass. */
static void insert_all(const struct used_range *ranges, uint32_t count, uint32_t *order)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = i;
        for (; at && range_compare(&ranges[order[at - 1]], &ranges[i]) > 0; at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
}

static uint64_t number_at(const struct range_key *key, size_t member)
{
    uint64_t number;
    memcpy(&number, (const char *)key + member, sizeof(number));
    return number;
}

/* One stable pass: copies `from` to `to`, sorted by one digit. */
static void sort_pass(const struct range_key *from, struct range_key *to, uint32_t count,
                      size_t member, int shift)
{
    uint32_t next[DIGITS] = {0}, sum = 0;
    for (uint32_t i = 0; i < count; i++)
        next[number_at(&from[i], member) >> shift & (DIGITS - 1)]++;
    for (int digit = 0; digit < DIGITS; digit++) {
        uint32_t before = sum;
        sum += next[digit];
        next[digit] = before;
    }
    for (uint32_t i = 0; i < count; i++)
        to[next[number_at(&from[i], member) >> shift & (DIGITS - 1)]++] = from[i];
}

/* Sorts by one member. May swap the two arrays: `*keys` is the sorted one. */
static void sort_by(struct range_key **keys, struct range_key **spare, uint32_t count,
                    size_t member)
{
    uint64_t varies = 0;
    for (uint32_t i = 1; i < count; i++)
        varies |= number_at(&(*keys)[i], member) ^ number_at(&(*keys)[0], member);
    while (varies) {
        int shift = __builtin_ctzll(varies);
        sort_pass(*keys, *spare, count, member, shift);
        struct range_key *sorted = *spare;
        *spare = *keys;
        *keys = sorted;
        varies &= ~((uint64_t)(DIGITS - 1) << shift);
    }
}

void range_order(const struct used_range *ranges, uint32_t count, uint32_t *order,
                 struct range_key *keys)
{
    if (count <= FEW) {
        insert_all(ranges, count, order);
        return;
    }
    struct range_key *spare = keys + count;
    for (uint32_t i = 0; i < count; i++)
        keys[i] = (struct range_key){
            .memory = memory_number(&ranges[i]), .begin = ranges[i].span.begin, .index = i};
    sort_by(&keys, &spare, count, offsetof(struct range_key, begin));
    sort_by(&keys, &spare, count, offsetof(struct range_key, memory));
    for (uint32_t i = 0; i < count; i++)
        order[i] = keys[i].index;
}

/* ---- the sweep */

void sweep_empty(struct sweep *sweep)
{
    for (int role = 0; role < ROLE_COUNT; role++) {
        struct range_list *list = &sweep->roles[role];
        list->count = 0;
        list->unsorted = list->overlapping = false;
        list->handles_unsorted = list->has_empty = false;
    }
    sweep->noted_count = 0;
    sweep->unknown = (struct unknown){0};
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
    sweep->is_initialized = true;
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

/* ---- shared memory */

/* The active ranges of one kind: those that the sweep has reached and whose end it has not passed.
 * If there are more than SWEEP_PARTNERS, the ones that end last. */
struct active_set {
    const struct used_range *items[SWEEP_PARTNERS];
    uint32_t count;
};

struct active_sets {
    struct active_set kinds[KIND_COUNT];
    bool enabled[KIND_COUNT][KIND_COUNT]; /* lower kind first */
    VkDeviceMemory memory;
};

static bool pair_is_enabled(const struct active_sets *sets, enum range_kind a, enum range_kind b)
{
    return a < b ? sets->enabled[a][b] : sets->enabled[b][a];
}

static void disable_pairs(struct active_sets *sets, enum range_kind a, enum range_kind b)
{
    sets->enabled[a < b ? a : b][a < b ? b : a] = false;
}

/* Enables the pairs of kinds that rules cover. Other pairs may be numerous, for example of ranges
 * that builds only read. */
static void enable_pairs(struct active_sets *sets)
{
    for (int kind = 0; kind < KIND_COUNT; kind++)
        sets->enabled[KIND_DST][kind] = true;
    sets->enabled[KIND_SRC][KIND_SCRATCH] = true;
    sets->enabled[KIND_SCRATCH][KIND_SCRATCH] = true;
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
        disable_pairs(sets, range_kind(a), range_kind(b));
}

/* Removes the ranges of a kind that end at or before the first byte of `range`, then visits the
 * pairs of `range` with the remaining ones. */
static void visit_active(struct active_sets *sets, enum range_kind kind,
                         const struct used_range *range, pair_visitor visit, void *user)
{
    struct active_set *set = &sets->kinds[kind];
    uint32_t remaining = 0;
    for (uint32_t i = 0; i < set->count; i++)
        if (set->items[i]->span.end > range->span.begin)
            set->items[remaining++] = set->items[i];
    set->count = remaining;
    for (uint32_t i = 0; i < remaining && pair_is_enabled(sets, kind, range_kind(range)); i++)
        visit_pair(sets, set->items[i], range, visit, user);
}

/* In a full set, a range replaces the range that ends first if it ends later. Every remaining range
 * then shares memory with any range that the dropped one would have shared memory with. */
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
    bool any_enabled = false;
    for (int kind = 0; kind < KIND_COUNT; kind++) {
        if (!pair_is_enabled(sets, (enum range_kind)kind, range_kind(range)))
            continue;
        any_enabled = true;
        visit_active(sets, (enum range_kind)kind, range, visit, user);
    }
    if (any_enabled)
        activate(&sets->kinds[range_kind(range)], range);
}

/* The ranges of a role in the order of their first bytes: the order of the list, or `order`. `head`
 * is NULL before the first advance(). */
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

/* Returns the queue whose head begins first, or NULL if all queues are at the end. */
static struct range_queue *first_of(struct range_queue queues[ROLE_COUNT])
{
    struct range_queue *first = NULL;
    for (int role = 0; role < ROLE_COUNT; role++)
        if (queues[role].head && (!first || range_compare(queues[role].head, first->head) < 0))
            first = &queues[role];
    return first;
}

/* Returns whether `a` ends before `b` begins. `a` begins at or before `b`. */
static bool ends_before(const struct used_range *a, const struct used_range *b)
{
    return a->span.memory != b->span.memory || a->span.end <= b->span.begin;
}

static bool role_is_apart(const struct range_list *list, const struct range_queue *queue)
{
    if (!queue->order)
        return !list->overlapping;
    const struct used_range *before = item_at(queue, 0);
    for (uint32_t i = 1; i < queue->count; i++) {
        const struct used_range *range = item_at(queue, i);
        if (!ends_before(before, range))
            return false;
        before = range;
    }
    return true;
}

/* Returns whether all ranges up to `last` come before all ranges from `first` on, if the ranges of
 * each role are apart. */
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

/* Like all_are_apart(), for ranges that were added in the order of their first bytes. */
static bool all_added_apart(const struct sweep *sweep)
{
    const struct range_list *dst = &sweep->roles[ROLE_DST], *src = &sweep->roles[ROLE_SRC],
                            *scratch = &sweep->roles[ROLE_SCRATCH];
    return !dst->overlapping && !src->overlapping && !scratch->overlapping &&
           lists_are_apart(dst, scratch) && lists_are_apart(dst, src) &&
           lists_are_apart(src, scratch);
}

/* Returns whether no two ranges share memory because each role has a memory region of its own and
 * its ranges are apart. Most calls are so, and this costs less than a sweep. */
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

/* Not inlined, so that the sets take stack space only if needed. */
__attribute__((noinline)) static void sweep_queues(struct range_queue queues[ROLE_COUNT],
                                                   pair_visitor visit, void *user)
{
    struct active_sets sets;
    struct range_queue *queue;
    memset(sets.enabled, false, sizeof(sets.enabled));
    enable_pairs(&sets);
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

/* Returns false for updates: most of them share memory with their sources. */
bool sweep_finds_nothing(struct sweep *sweep)
{
    const struct range_list *dst = &sweep->roles[ROLE_DST], *scratch = &sweep->roles[ROLE_SCRATCH];
    if (sweep->roles[ROLE_SRC].count || (dst->handles_unsorted && dst->has_empty))
        return false;
    return all_added_apart(sweep) ||
           ((dst->unsorted || scratch->unsorted) && are_apart_in_order(sweep));
}

void sweep_shared_memory(struct sweep *sweep, pair_visitor visit, void *user)
{
    if (!unknown_is_set(&sweep->unknown) && !all_added_apart(sweep))
        sweep_all(sweep, visit, user);
}
