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

static struct journal_chunk *room(struct journal *journal)
{
    if (journal->last && journal->last->count < JOURNAL_CHUNK)
        return journal->last;
    struct journal_chunk *chunk = journal->spare;
    if (chunk)
        journal->spare = chunk->next;
    else
        chunk = malloc(sizeof(*chunk));
    if (!chunk)
        return NULL;
    chunk->next = NULL;
    chunk->count = 0;
    if (journal->last)
        journal->last->next = chunk;
    else
        journal->first = chunk;
    journal->last = chunk;
    return chunk;
}

static void release_entry(struct journal_entry *entry)
{
    if (entry->kind == JOURNAL_BUILD || entry->kind == JOURNAL_UPDATE)
        built_release(&entry->built);
    if (entry->kind == JOURNAL_EXECUTE)
        journal_release(entry->secondary);
}

void journal_add(struct journal *journal, const struct journal_entry *entry)
{
    struct journal_chunk *chunk = room(journal);
    if (!chunk) {
        struct journal_entry lost = *entry;
        release_entry(&lost);
        journal->incomplete = true;
        return;
    }
    chunk->entries[chunk->count++] = *entry;
}

uint32_t journal_note_labels(struct journal *journal, const struct label_stack *labels)
{
    if (!labels->count)
        return 0;
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

static struct journal_input_chunk *input_room(struct journal *journal)
{
    if (journal->last_input && journal->last_input->count < JOURNAL_CHUNK)
        return journal->last_input;
    struct journal_input_chunk *chunk = journal->spare_input;
    if (chunk)
        journal->spare_input = chunk->next;
    else
        chunk = malloc(sizeof(*chunk));
    if (!chunk)
        return NULL;
    chunk->next = NULL;
    chunk->count = 0;
    if (journal->last_input)
        journal->last_input->next = chunk;
    else
        journal->first_input = chunk;
    journal->last_input = chunk;
    return chunk;
}

/* A lost input is one mistake that goes unseen, nothing more. */
void journal_add_input(struct journal *journal, const struct journal_input *input)
{
    uint64_t *recent = &journal->recent_inputs[input->buffer_id % JOURNAL_RECENT_INPUTS];
    if (*recent == input->buffer_id)
        return;
    struct journal_input_chunk *chunk = input_room(journal);
    if (!chunk)
        return;
    *recent = input->buffer_id;
    chunk->inputs[chunk->count++] = *input;
}

struct journal_mark journal_mark(const struct journal *journal)
{
    return (struct journal_mark){
        .chunk = journal->last,
        .count = journal->last ? journal->last->count : 0,
        .input_chunk = journal->last_input,
        .input_count = journal->last_input ? journal->last_input->count : 0,
    };
}

/* Empties chunks and lays them by. */
static void spare_chunks(struct journal *journal, struct journal_chunk *chunk)
{
    while (chunk) {
        struct journal_chunk *next = chunk->next;
        for (uint32_t i = 0; i < chunk->count; i++)
            release_entry(&chunk->entries[i]);
        chunk->next = journal->spare;
        journal->spare = chunk;
        chunk = next;
    }
}

static void spare_input_chunks(struct journal *journal, struct journal_input_chunk *chunk)
{
    while (chunk) {
        struct journal_input_chunk *next = chunk->next;
        chunk->next = journal->spare_input;
        journal->spare_input = chunk;
        chunk = next;
    }
}

void journal_take_back(struct journal *journal, const struct journal_mark *mark)
{
    if (!mark->chunk) {
        spare_chunks(journal, journal->first);
        journal->first = NULL;
    } else {
        for (uint32_t i = mark->count; i < mark->chunk->count; i++)
            release_entry(&mark->chunk->entries[i]);
        mark->chunk->count = mark->count;
        spare_chunks(journal, mark->chunk->next);
        mark->chunk->next = NULL;
    }
    journal->last = mark->chunk;

    spare_input_chunks(journal, mark->input_chunk ? mark->input_chunk->next : journal->first_input);
    if (mark->input_chunk) {
        mark->input_chunk->count = mark->input_count;
        mark->input_chunk->next = NULL;
    } else {
        journal->first_input = NULL;
    }
    journal->last_input = mark->input_chunk;
    memset(journal->recent_inputs, 0, sizeof(journal->recent_inputs));
}

struct journal_cursor journal_start(const struct journal *journal)
{
    return (struct journal_cursor){.chunk = journal->first};
}

struct journal_cursor journal_start_after(const struct journal *journal,
                                          const struct journal_mark *mark)
{
    if (!mark->chunk)
        return journal_start(journal);
    return (struct journal_cursor){.chunk = mark->chunk, .next = mark->count};
}

struct journal_entry *journal_next(struct journal_cursor *cursor)
{
    while (cursor->chunk && cursor->next == cursor->chunk->count) {
        cursor->chunk = cursor->chunk->next;
        cursor->next = 0;
    }
    return cursor->chunk ? &cursor->chunk->entries[cursor->next++] : NULL;
}

void journal_clear(struct journal *journal)
{
    struct journal_mark start = {0};
    journal_take_back(journal, &start);
    while (journal->label_count)
        label_stack_clear(&journal->labels[--journal->label_count]);
    journal->incomplete = false;
}

void journal_release(struct journal *journal)
{
    if (!journal || atomic_fetch_sub_explicit(&journal->references, 1, memory_order_acq_rel) != 1)
        return;
    journal_clear(journal);
    free(journal->labels);
    for (struct journal_chunk *next, *chunk = journal->spare; chunk; chunk = next) {
        next = chunk->next;
        free(chunk);
    }
    for (struct journal_input_chunk *next, *chunk = journal->spare_input; chunk; chunk = next) {
        next = chunk->next;
        free(chunk);
    }
    free(journal);
}
