/* SPDX-License-Identifier: Apache-2.0 */
/* Journals: lists of chunks, so that growing moves nothing. */
#include "state/journal.h"

#include <stdlib.h>
#include <string.h>

struct journal *journal_create(VkCommandBuffer command_buffer)
{
    struct journal *journal = calloc(1, sizeof(*journal));
    if (!journal)
        return NULL;
    atomic_init(&journal->references, 1);
    journal->command_buffer = command_buffer;
    return journal;
}

struct journal *journal_share(struct journal *journal)
{
    atomic_fetch_add_explicit(&journal->references, 1, memory_order_relaxed);
    return journal;
}

bool journal_is_shared(const struct journal *journal)
{
    return atomic_load_explicit(&journal->references, memory_order_acquire) > 1;
}

struct journal_chunk *journal_add_chunk(struct journal_chunks *chunks, size_t size)
{
    struct journal_chunk *chunk = chunks->spare;
    if (chunk)
        chunks->spare = chunk->next;
    else
        chunk = malloc(size);
    if (!chunk)
        return NULL;
    chunk->next = NULL;
    chunk->count = 0;
    if (chunks->last)
        chunks->last->next = chunk;
    else
        chunks->first = chunk;
    chunks->last = chunk;
    return chunk;
}

static bool is_empty(const struct journal_chunks *chunks)
{
    return !chunks->first || !chunks->first->count;
}

/* Takes back what comes behind the first `count` items of chunk `last`, or all where that is NULL.
 * The first chunk stays in its place, others are laid by. */
static void cut(struct journal_chunks *chunks, struct journal_chunk *last, uint32_t count)
{
    struct journal_chunk *kept = last ? last : chunks->first;
    if (!kept)
        return;
    if (kept->next) {
        chunks->last->next = chunks->spare;
        chunks->spare = kept->next;
        kept->next = NULL;
    }
    kept->count = count;
    chunks->last = kept;
}

static void free_list(struct journal_chunk *chunk)
{
    while (chunk) {
        struct journal_chunk *next = chunk->next;
        free(chunk);
        chunk = next;
    }
}

static void free_chunks(struct journal_chunks *chunks)
{
    free_list(chunks->first);
    free_list(chunks->spare);
}

static void release_entry(struct journal_entry *entry)
{
    if (entry->kind == JOURNAL_BUILD || entry->kind == JOURNAL_UPDATE)
        built_release(&entry->built);
    if (entry->kind == JOURNAL_EXECUTE)
        journal_release(entry->secondary);
    if (entry->kind == JOURNAL_RANGES)
        free(entry->ranges);
}

void journal_add(struct journal *journal, const struct journal_entry *entry)
{
    struct journal_entry *place = journal_begin_entry(journal);
    if (!place) {
        struct journal_entry lost = *entry;
        release_entry(&lost);
        return;
    }
    *place = *entry;
    journal_end_entry(journal, place);
}

void journal_add_binding(struct journal *journal, const struct sparse_binding *binding)
{
    struct journal_entry entry = {
        .kind = JOURNAL_BIND,
        .dst = (uint64_t)(uintptr_t)binding->buffer,
        .src = (uint64_t)(uintptr_t)binding->memory,
        .dst_id = binding->buffer_id,
        .src_id = binding->memory_id,
        .binding = {binding->offset, binding->size, binding->memory_offset},
    };
    journal->binds = true;
    journal_add(journal, &entry);
}

struct sparse_binding journal_binding(const struct journal_entry *entry)
{
    return (struct sparse_binding){
        .buffer = (VkBuffer)(uintptr_t)entry->dst,
        .memory = (VkDeviceMemory)(uintptr_t)entry->src,
        .buffer_id = entry->dst_id,
        .memory_id = entry->src_id,
        .offset = entry->binding.offset,
        .size = entry->binding.size,
        .memory_offset = entry->binding.memory_offset,
    };
}

uint32_t journal_keep_labels(struct journal *journal, const struct label_stack *labels)
{
    if (journal->label_count && journal->label_changes == labels->changes)
        return journal->label_count;
    if (journal->label_count == journal->label_capacity) {
        uint32_t capacity = journal->label_capacity ? journal->label_capacity * 2 : 4;
        struct label_stack *grown = realloc(journal->labels, capacity * sizeof(*grown));
        if (!grown)
            return 0;
        journal->labels = grown;
        journal->label_capacity = capacity;
    }
    journal->labels[journal->label_count++] = label_stack_copy(labels);
    journal->label_changes = labels->changes;
    return journal->label_count;
}

const struct label_stack *journal_labels_at(const struct journal *journal, uint32_t position)
{
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if ((entry->kind == JOURNAL_BUILD || entry->kind == JOURNAL_UPDATE) &&
            entry->built.position == position)
            return entry->labels ? &journal->labels[entry->labels - 1] : NULL;
    return NULL;
}

struct journal_mark journal_mark(const struct journal *journal)
{
    const struct journal_chunk *entries = journal->entries.last, *inputs = journal->inputs.last;
    return (struct journal_mark){
        .entries = journal->entries.last,
        .entry_count = entries ? entries->count : 0,
        .inputs = journal->inputs.last,
        .input_count = inputs ? inputs->count : 0,
    };
}

void journal_take_back(struct journal *journal, const struct journal_mark *mark)
{
    if (is_empty(&journal->entries) && is_empty(&journal->inputs))
        return;
    struct journal_cursor cursor = journal_start_after(journal, mark);
    for (struct journal_entry *entry; journal->holds && (entry = journal_next(&cursor));)
        release_entry(entry);
    cut(&journal->entries, mark->entries, mark->entry_count);
    cut(&journal->inputs, mark->inputs, mark->input_count);
    memset(journal->recent_inputs, 0, sizeof(journal->recent_inputs));
}

struct journal_cursor journal_start(const struct journal *journal)
{
    return (struct journal_cursor){.chunk = journal->entries.first};
}

struct journal_cursor journal_start_after(const struct journal *journal,
                                          const struct journal_mark *mark)
{
    if (!mark->entries)
        return journal_start(journal);
    return (struct journal_cursor){.chunk = mark->entries, .next = mark->entry_count};
}

struct journal_entry *journal_next(struct journal_cursor *cursor)
{
    while (cursor->chunk && cursor->next == cursor->chunk->count) {
        cursor->chunk = cursor->chunk->next;
        cursor->next = 0;
    }
    struct journal_entry_chunk *chunk = (struct journal_entry_chunk *)cursor->chunk;
    return chunk ? &chunk->items[cursor->next++] : NULL;
}

void journal_clear(struct journal *journal)
{
    struct journal_mark start = {0};
    journal_take_back(journal, &start);
    journal->holds = journal->asks = false;
    while (journal->label_count)
        label_stack_clear(&journal->labels[--journal->label_count]);
    if (journal->work)
        journal->release_work(journal->work);
    journal->work = NULL;
    journal->has_events = journal->incomplete = false;
}

void journal_release(struct journal *journal)
{
    if (!journal || atomic_fetch_sub_explicit(&journal->references, 1, memory_order_acq_rel) != 1)
        return;
    journal_clear(journal);
    free(journal->labels);
    free(journal->host);
    free_chunks(&journal->entries);
    free_chunks(&journal->inputs);
    free(journal);
}
