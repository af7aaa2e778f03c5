/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/execution/query_writes.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/base/unknown.h"
#include "src/state/commands/journal.h"

/* Of more batches than these, the oldest are forgotten. Ranges beyond these are joined. */
enum { BATCHES_KEPT = 256, RANGES_KEPT = 64 };

/* Queries of a pool, or an event. More may be in between than the batch has written: then the batch
 * counts for these, too, which only makes more work count as complete. */
struct query_range {
    VkQueryPool pool;
    uint64_t first, end;
};

/* An event counts as one query, which no pool has. */
#define EVENT_QUERY (UINT64_C(1) << 40)
static VkQueryPool pool_of_event(uint64_t event)
{
    return (VkQueryPool)(uintptr_t)event;
}

struct batch_queries {
    struct batch_queries *older;
    const struct order_batch *batch; /* NULL: `clock` is known */
    bool is_unknown;                 /* what it follows is not known */
    struct unknown unknown;          /* memory ran out for ranges, or for entries of a journal */
    struct execution_clock clock;    /* the batch, and what it follows */
    struct query_range *ranges;
    uint32_t count, capacity;
};

struct query_writes {
    pthread_mutex_t lock;
    struct batch_queries *newest;
    uint32_t count;
    struct unknown unknown; /* memory ran out: queries may have been written by other batches */
};

struct query_writes *query_writes_create(void)
{
    struct query_writes *writes = calloc(1, sizeof(*writes));
    if (writes)
        pthread_mutex_init(&writes->lock, NULL);
    return writes;
}

static void free_queries(struct batch_queries *queries)
{
    free(queries->ranges);
    free(queries);
}

void query_writes_destroy(struct query_writes *writes)
{
    if (!writes)
        return;
    while (writes->newest) {
        struct batch_queries *queries = writes->newest;
        writes->newest = queries->older;
        free_queries(queries);
    }
    pthread_mutex_destroy(&writes->lock);
    free(writes);
}

/* ---- what a batch writes */

/* Returns the last range of the pool if the query is next to it, or if there are many ranges. */
static struct query_range *find_range(struct batch_queries *queries, VkQueryPool pool,
                                      uint64_t query)
{
    for (uint32_t i = queries->count; i-- > 0;) {
        struct query_range *range = &queries->ranges[i];
        if (range->pool == pool &&
            ((query + 1 >= range->first && query <= range->end) || queries->count >= RANGES_KEPT))
            return range;
    }
    return NULL;
}

/* Returns false if memory runs out. */
static bool add_query(struct batch_queries *queries, VkQueryPool pool, uint64_t first, uint64_t end)
{
    struct query_range *range = find_range(queries, pool, first);
    if (range) {
        range->first = first < range->first ? first : range->first;
        range->end = end > range->end ? end : range->end;
        return true;
    }
    if (!ARRAY_HAS_ROOM(queries->ranges, queries->count, queries->capacity))
        return false;
    queries->ranges[queries->count++] = (struct query_range){pool, first, end};
    return true;
}

static bool is_observable(const struct journal *journal)
{
    return journal->writes_queries || journal->has_events;
}

/* Events of a journal; `user` is the struct batch_queries. */

static void add_range(struct journal_walk *walk, VkQueryPool pool, uint64_t first, uint64_t count)
{
    struct batch_queries *queries = walk->user;
    if (!add_query(queries, pool, first, first + count))
        unknown_set(&queries->unknown, UNKNOWN_QUERY_WRITES);
}

static void add_event(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (entry->info == EVENT_SET)
        add_range(walk, pool_of_event(entry->dst), EVENT_QUERY, 1);
}

static void add_writes(struct journal_walk *walk, const struct journal_entry *entry)
{
    add_range(walk, (VkQueryPool)(uintptr_t)entry->dst, entry->number, entry->info);
}

static void add_read(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (journal_entry_is_query(entry))
        add_range(walk, (VkQueryPool)(uintptr_t)entry->dst, entry->read.number, 1);
}

/* A journal is incomplete if that of a secondary command buffer is. */
static void add_journal(struct batch_queries *queries, const struct journal *journal)
{
    static const struct journal_events events = {.use_event = add_event,
                                                 .write_queries = add_writes,
                                                 .read = add_read,
                                                 .execute = journal_walk_secondary};
    unknown_follow(&queries->unknown, !journal_is_complete(journal));
    if (journal && is_observable(journal))
        journal_walk(journal, &events, queries);
}

static bool has_queries(const struct order_batch *batch)
{
    bool has_any = false;
    for (uint32_t i = 0; batch->origin.queue && i < batch->command_count; i++) {
        const struct journal *journal = batch->commands[i].captured;
        has_any |= !journal_is_complete(journal) || is_observable(journal);
    }
    return has_any;
}

static void forget_oldest(struct query_writes *writes)
{
    struct batch_queries **link = &writes->newest;
    while ((*link)->older)
        link = &(*link)->older;
    free_queries(*link);
    *link = NULL;
    writes->count--;
}

void query_writes_submit(struct query_writes *writes, struct order_batch *batch)
{
    if (!writes || !has_queries(batch))
        return;
    struct batch_queries *queries = calloc(1, sizeof(*queries));
    for (uint32_t i = 0; queries && !unknown_is_set(&queries->unknown) && i < batch->command_count;
         i++)
        add_journal(queries, batch->commands[i].captured);
    pthread_mutex_lock(&writes->lock);
    if (!queries)
        unknown_set(&writes->unknown, UNKNOWN_QUERY_WRITES);
    else
        unknown_follow(&writes->unknown, unknown_is_set(&queries->unknown));
    if (queries) {
        queries->batch = batch;
        queries->older = writes->newest;
        writes->newest = queries;
        if (++writes->count > BATCHES_KEPT)
            forget_oldest(writes);
    }
    pthread_mutex_unlock(&writes->lock);
}

void query_writes_run(struct query_writes *writes, const struct order_batch *batch)
{
    if (!writes)
        return;
    pthread_mutex_lock(&writes->lock);
    for (struct batch_queries *at = writes->newest; at; at = at->older)
        if (at->batch == batch) {
            at->batch = NULL;
            at->is_unknown = !batch->predecessors_known;
            execution_clock_copy(&at->clock, &batch->behind);
        }
    pthread_mutex_unlock(&writes->lock);
}

void query_writes_fail(struct query_writes *writes, const struct order_batch *batch)
{
    if (!writes)
        return;
    pthread_mutex_lock(&writes->lock);
    for (struct batch_queries **link = &writes->newest; *link;) {
        struct batch_queries *at = *link;
        if (at->batch != batch) {
            link = &at->older;
            continue;
        }
        *link = at->older;
        free_queries(at);
        writes->count--;
    }
    pthread_mutex_unlock(&writes->lock);
}

/* ---- what the application has read */

static bool has_query(const struct batch_queries *queries, VkQueryPool pool, uint64_t first,
                      uint64_t end, uint64_t *behind)
{
    for (uint32_t i = 0; i < queries->count; i++) {
        const struct query_range *range = &queries->ranges[i];
        if (range->pool == pool && range->first < end && first < range->end) {
            *behind = range->first <= first ? range->end : first;
            return true;
        }
    }
    return false;
}

/* Whether some batch has written each of the queries. */
static bool are_all_written(const struct query_writes *writes, VkQueryPool pool, uint64_t first,
                            uint64_t end)
{
    while (first < end) {
        uint64_t behind = first;
        for (const struct batch_queries *at = writes->newest; at && behind == first; at = at->older)
            has_query(at, pool, first, first + 1, &behind);
        if (behind == first)
            return false;
        first = behind;
    }
    return true;
}

/* Older batches that wrote a query precede the newest one: they do no harm. */
static bool find_writes(struct query_writes *writes, VkQueryPool pool, uint64_t first, uint64_t end,
                        struct execution_clock *clock)
{
    uint64_t behind;
    clock->queues = 0;
    if (!writes)
        return false;
    pthread_mutex_lock(&writes->lock);
    bool is_known = !unknown_is_set(&writes->unknown) && are_all_written(writes, pool, first, end);
    for (const struct batch_queries *at = writes->newest; at && is_known; at = at->older)
        if (has_query(at, pool, first, end, &behind)) {
            is_known = !at->batch && !at->is_unknown;
            execution_clock_join(clock, &at->clock);
        }
    pthread_mutex_unlock(&writes->lock);
    return is_known;
}

bool query_writes_find(struct query_writes *writes, VkQueryPool pool, uint32_t first,
                       uint32_t count, struct execution_clock *clock)
{
    return find_writes(writes, pool, first, (uint64_t)first + count, clock);
}

bool query_writes_find_event(struct query_writes *writes, VkEvent event,
                             struct execution_clock *clock)
{
    return find_writes(writes, pool_of_event(handle_number(event)), EVENT_QUERY, EVENT_QUERY + 1,
                       clock);
}

void query_writes_forget(struct query_writes *writes, VkQueryPool pool)
{
    if (!writes)
        return;
    pthread_mutex_lock(&writes->lock);
    for (struct batch_queries *at = writes->newest; at; at = at->older)
        for (uint32_t i = 0; i < at->count; i++)
            if (at->ranges[i].pool == pool)
                at->ranges[i].pool = VK_NULL_HANDLE;
    pthread_mutex_unlock(&writes->lock);
}

void query_writes_forget_event(struct query_writes *writes, VkEvent event)
{
    query_writes_forget(writes, pool_of_event(handle_number(event)));
}
