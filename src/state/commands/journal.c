/* SPDX-License-Identifier: Apache-2.0 */
/* Creates, fills, walks and releases journals. */
#include "src/state/commands/journal.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/base/recording_path.h"
#include "src/state/commands/bound_shaders.h"

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
    struct journal_cursor cursor = journal_start_secondaries(journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (journal_contains(entry->secondary, other))
            return true;
    return false;
}

static void release_entry(struct journal_entry *entry)
{
    if (journal_entry_has_built(entry))
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
    const unsigned char size = place->size;
    *place = *entry;
    place->size = size;
    journal->has_copies |= entry->kind == JOURNAL_COPY || entry->kind == JOURNAL_COMPACT;
    journal_end_entry(journal, place);
}

void journal_add_binding(struct journal *journal, const struct sparse_binding *binding)
{
    struct journal_entry entry = {
        .kind = JOURNAL_BIND,
        .dst = handle_number(binding->buffer),
        .src = handle_number(binding->memory),
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

uint32_t journal_keep_origin(struct journal *journal, const struct label_stack *labels,
                             const struct call_site *site)
{
    const uint32_t changes = labels ? labels->changes : 0, count = journal->origin_count;
    if (count && journal->label_changes == changes && journal->origins[count - 1].site == site)
        return count;
    if (!ARRAY_HAS_ROOM(journal->origins, count, journal->origin_capacity))
        return 0;
    journal->origins[count] = (struct journal_origin){.site = site};
    if (labels)
        journal->origins[count].labels = label_stack_copy(labels);
    journal->label_changes = changes;
    return ++journal->origin_count;
}

uint32_t journal_origin_at(const struct journal *journal, uint32_t position)
{
    if (!journal->origin_count)
        return 0;
    struct journal_cursor cursor = journal_start(journal, JOURNAL_COPIED_BUILDS);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (entry->built.position == position)
            return entry->origin;
    return 0;
}

struct journal_cursor journal_start_at(const struct journal *journal, struct chunk_place place,
                                       uint32_t kinds)
{
    return (struct journal_cursor){
        .list = &journal->entries, .place = place, .end = journal_end(journal), .kinds = kinds};
}

struct journal_cursor journal_start(const struct journal *journal, uint32_t kinds)
{
    return journal_start_at(journal, (struct chunk_place){NULL, NULL}, kinds);
}

struct journal_cursor journal_start_call(const struct journal *journal, uint32_t kinds)
{
    return journal_start_at(journal, journal->call, kinds);
}

struct journal_cursor journal_start_secondaries(const struct journal *journal)
{
    if (!journal->secondary_count)
        return (struct journal_cursor){.list = &journal->entries};
    return journal_start(journal, JOURNAL_BIT(JOURNAL_EXECUTE));
}

struct journal_entry *journal_next(struct journal_cursor *cursor)
{
    struct journal_entry *entry;
    while ((entry = chunk_list_at(cursor->list, &cursor->place, &cursor->end))) {
        cursor->place.next += (size_t)entry->size * JOURNAL_UNIT;
        if (cursor->kinds & JOURNAL_BIT(entry->kind))
            break;
    }
    return entry;
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

void journal_take_back(struct journal *journal, struct chunk_place place)
{
    if (journal->has_references)
        release_entries(journal_start_at(journal, place, JOURNAL_ENTRIES));
    chunk_list_cut(&journal->entries, place);
    journal->call = place;
    forget_recent_inputs(journal);
}

__attribute__((cold, noinline)) static void release_held(struct journal *journal)
{
    if (journal->has_references)
        release_entries(journal_start(journal, JOURNAL_ENTRIES));
    while (journal->origin_count)
        label_stack_clear(&journal->origins[--journal->origin_count].labels);
    if (journal->work)
        journal->release_work(journal->work);
    journal->work = NULL;
    bound_shaders_free(journal->bound);
    journal->bound = NULL;
}

/* Every recording begins with this call, and most recordings have nothing to release. */
ON_RECORDING_PATH void journal_clear(struct journal *journal)
{
    if (journal->has_references || journal->origin_count || journal->work || journal->bound)
        release_held(journal);
    if (!chunk_list_is_empty(&journal->entries))
        forget_recent_inputs(journal);
    chunk_list_clear(&journal->entries);
    journal->has_references = journal->has_sources_to_check = false;
    journal->secondary_count = 0;
    journal->has_events = journal->writes_queries = journal->incomplete = false;
    journal->lacks_hazards = journal->awaits_inputs = journal->has_condition = false;
    journal->reads_host_data = journal->has_copies = false;
    journal->shaders_end = NULL;
    journal_begin_call(journal);
}

void journal_release(struct journal *journal)
{
    if (!journal || atomic_fetch_sub_explicit(&journal->references, 1, memory_order_acq_rel) != 1)
        return;
    journal_clear(journal);
    free(journal->recent_memory);
    free(journal->origins);
    free(journal->host);
    chunk_list_free(&journal->entries);
    free(journal);
}
