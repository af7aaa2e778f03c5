/* SPDX-License-Identifier: Apache-2.0 */
/* Creates, fills, walks and releases journals. */
#include "src/state/commands/journal.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/base/recording_path.h"
#include "src/state/commands/hazard_list.h"

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

bool journal_contains(const struct journal *journal, const struct journal *other)
{
    if (journal == other)
        return true;
    struct journal_cursor cursor = journal_start(journal);
    const struct journal_entry *entry;
    while (journal->executes && (entry = journal_next(&cursor)))
        if (entry->kind == JOURNAL_EXECUTE && journal_contains(entry->secondary, other))
            return true;
    return false;
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
    struct label_stack *grown = array_make_room(journal->labels, journal->label_count,
                                                &journal->label_capacity, sizeof(*grown));
    if (!grown)
        return 0;
    journal->labels = grown;
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
            return journal_label_stack(journal, entry->labels);
    return NULL;
}

static void forget_calls(struct journal *journal)
{
    struct journal_cursor cursor = journal_start(journal);
    for (struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (entry->kind == JOURNAL_CALL)
            entry->call.site = NULL;
}

void journal_note_call(struct journal *journal, uint32_t position, const struct call_site *site)
{
    if (!chunk_list_make_room(&journal->entries, sizeof(struct journal_entry))) {
        forget_calls(journal);
        return;
    }
    struct journal_entry *entry = (void *)journal->entries.next;
    *entry = (struct journal_entry){.kind = JOURNAL_CALL, .call = {position, site}};
    journal->entries.next += sizeof(*entry);
}

/* Positions grow in recorded order. */
const struct call_site *journal_call_site_at(const struct journal *journal, uint32_t position)
{
    const struct call_site *site = NULL;
    struct journal_cursor cursor = journal_start(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));) {
        if (entry->kind != JOURNAL_CALL)
            continue;
        if (entry->call.position > position)
            break;
        site = entry->call.site;
    }
    return site;
}

struct journal_cursor journal_start(const struct journal *journal)
{
    return (struct journal_cursor){.list = &journal->entries};
}

struct journal_cursor journal_start_after(const struct journal *journal,
                                          const struct journal_mark *mark)
{
    return (struct journal_cursor){.list = &journal->entries, .place = mark->entries};
}

struct journal_cursor journal_start_inputs(const struct journal *journal)
{
    return (struct journal_cursor){.list = &journal->inputs};
}

struct journal_entry *journal_next(struct journal_cursor *cursor)
{
    return chunk_list_next(cursor->list, sizeof(struct journal_entry), &cursor->place);
}

const struct journal_input *journal_next_input(struct journal_cursor *cursor)
{
    return chunk_list_next(cursor->list, sizeof(struct journal_input), &cursor->place);
}

struct hazard_list *journal_hazards(struct journal *journal)
{
    if (!journal->hazards)
        journal->hazards = hazard_list_create(journal_release);
    if (journal->hazards)
        journal->has_references = true;
    else
        journal->incomplete = true;
    return journal->hazards;
}

static void release_entries(struct journal_cursor cursor)
{
    for (struct journal_entry *entry; (entry = journal_next(&cursor));)
        release_entry(entry);
}

static void forget_recent_inputs(struct journal *journal)
{
    memset(journal->recent_inputs, 0, sizeof(journal->recent_inputs));
}

void journal_take_back(struct journal *journal, const struct journal_mark *mark)
{
    if (journal->has_references)
        release_entries(journal_start_after(journal, mark));
    chunk_list_cut(&journal->entries, sizeof(struct journal_entry), mark->entries);
    chunk_list_cut(&journal->inputs, sizeof(struct journal_input), mark->inputs);
    forget_recent_inputs(journal);
}

__attribute__((cold, noinline)) static void release_held(struct journal *journal)
{
    if (journal->has_references)
        release_entries(journal_start(journal));
    if (journal->hazards)
        hazard_list_clear(journal->hazards);
    while (journal->label_count)
        label_stack_clear(&journal->labels[--journal->label_count]);
    if (journal->work)
        journal->release_work(journal->work);
    journal->work = NULL;
}

/* Every recording begins with this call, and most recordings have nothing to release. */
ON_RECORDING_PATH void journal_clear(struct journal *journal)
{
    if (journal->has_references || journal->label_count || journal->work)
        release_held(journal);
    chunk_list_clear(&journal->entries, sizeof(struct journal_entry));
    if (!chunk_list_is_empty(&journal->inputs)) {
        chunk_list_clear(&journal->inputs, sizeof(struct journal_input));
        forget_recent_inputs(journal);
    }
    journal->has_references = journal->has_sources_to_check = journal->executes = false;
    journal->has_events = journal->incomplete = false;
}

void journal_release(struct journal *journal)
{
    if (!journal || atomic_fetch_sub_explicit(&journal->references, 1, memory_order_acq_rel) != 1)
        return;
    journal_clear(journal);
    hazard_list_destroy(journal->hazards);
    free(journal->labels);
    free(journal->host);
    chunk_list_free(&journal->entries);
    chunk_list_free(&journal->inputs);
    free(journal);
}
