/* SPDX-License-Identifier: Apache-2.0 */
/* Creates, fills, walks and releases journals. */
#include "src/state/commands/journal.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/base/recording_path.h"
#include "src/state/commands/bound_shaders.h"

VkObjectType journal_object_type(enum build_command command)
{
    static const VkObjectType types[COMMAND_COUNT] = {
        [COMMAND_DEVICE] = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
        [COMMAND_INDIRECT] = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
        [COMMAND_HOST] = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
        [COMMAND_NV] = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
#define COMMAND(name)
#define JOURNALED(name, type, uses) [COMMAND_##name] = VK_OBJECT_TYPE_##type,
#include "vuid-tables/commands.def"
    };
    return types[command];
}

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
    struct journal_walk walk = journal_start_secondaries(journal);
    for (const struct journal *secondary; (secondary = journal_next_secondary(&walk));)
        if (journal_contains(secondary, other))
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
        struct journal_entry refused = *entry;
        release_entry(&refused);
        return;
    }
    const unsigned char size = place->size;
    *place = *entry;
    place->size = size;
    journal->has_copies |= journal_is_copy(entry);
    journal->has_events |= journal_is_use_event(entry);
    journal_end_entry(journal, place);
}

struct journal_entry *journal_add_inputs(struct journal *journal, enum build_command command,
                                         uint32_t info, uint32_t position)
{
    struct journal_entry *entry = journal_begin_build(journal, false, true);
    if (entry)
        *entry = (struct journal_entry){.kind = JOURNAL_INPUTS,
                                        .size = entry->size,
                                        .command = (unsigned char)command,
                                        .info = info,
                                        .built.position = position};
    return entry;
}

void journal_add_secondary(struct journal *journal, struct journal *secondary)
{
    journal_add(journal, &(struct journal_entry){.kind = JOURNAL_EXECUTE,
                                                 .secondary = journal_share(secondary)});
    journal->secondary_count++;
    journal->has_events |= secondary->has_events;
    journal->writes_queries |= secondary->writes_queries;
    journal->awaits_inputs |= secondary->awaits_inputs;
    journal->has_copies |= secondary->has_copies;
    journal->reads_host_data |= secondary->reads_host_data;
}

void journal_add_place(struct journal *journal, const struct placed *placed)
{
    journal_add(journal, &(struct journal_entry){.kind = JOURNAL_PLACE, .placed = *placed});
    journal->place_count++;
    journal->has_references = true;
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

/* For walks by journal_next(), which calls no function. */
static void pass(struct journal_walk *walk, const struct journal_entry *entry)
{
    (void)walk;
    (void)entry;
}
static const struct journal_events builds = {ON_BUILDS(pass), .inputs = pass};
static const struct journal_events copies = {.copy = pass};
static const struct journal_events secondaries = {.execute = pass};

uint32_t journal_origin_at(const struct journal *journal, uint32_t position)
{
    struct journal_walk walk = journal_start(journal, &builds, NULL);
    const struct journal_entry *entry = NULL;
    while (journal->origin_count && (entry = journal_next(&walk)))
        if (entry->built.position == position)
            return entry->origin;
    return 0;
}

/* ---- walks */

struct journal_walk journal_start(const struct journal *journal,
                                  const struct journal_events *events, void *user)
{
    return (struct journal_walk){
        .events = events, .user = user, .journal = journal, .end = journal_end(journal)};
}

struct journal_walk journal_start_call(const struct journal *journal,
                                       const struct journal_events *events, void *user)
{
    struct journal_walk walk = journal_start(journal, events, user);
    walk.place = journal->call;
    return walk;
}

/* Returns the next entry of any kind. */
static struct journal_entry *step(struct journal_walk *walk)
{
    struct journal_entry *entry = chunk_list_at(&walk->journal->entries, &walk->place, &walk->end);
    if (entry)
        walk->place.next += (size_t)entry->size * JOURNAL_UNIT;
    return entry;
}

struct journal_entry *journal_next(struct journal_walk *walk)
{
    struct journal_entry *entry = step(walk);
    while (entry && !walk->events->of_kind[entry->kind])
        entry = step(walk);
    return entry;
}

bool journal_go_on(struct journal_walk *walk)
{
    const struct journal_entry *entry;
    while (!walk->is_over && (entry = journal_next(walk)))
        journal_hand(walk, walk->events, entry);
    return !walk->is_over;
}

bool journal_walk(const struct journal *journal, const struct journal_events *events, void *user)
{
    struct journal_walk walk = journal_start(journal, events, user);
    return journal_go_on(&walk);
}

void journal_walk_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    walk->is_over = !journal_walk(entry->secondary, walk->events, walk->user);
}

struct journal_walk journal_start_secondaries(const struct journal *journal)
{
    struct journal_walk walk = journal_start(journal, &secondaries, NULL);
    if (!journal->secondary_count)
        walk.end = walk.place;
    return walk;
}

struct journal *journal_next_secondary(struct journal_walk *walk)
{
    const struct journal_entry *entry = journal_next(walk);
    return entry ? entry->secondary : NULL;
}

struct journal_walk journal_start_builds_of_call(const struct journal *journal)
{
    return journal_start_call(journal, &builds, NULL);
}

struct journal_entry *journal_find_copy_of_call(const struct journal *journal)
{
    struct journal_walk walk = journal_start_call(journal, &copies, NULL);
    return journal_next(&walk);
}

void journal_set_judged(const struct journal_entry *entry)
{
    ((struct journal_entry *)(uintptr_t)entry)->judged = true;
}

static void release_entries(struct journal_walk walk)
{
    for (struct journal_entry *entry; (entry = step(&walk));)
        release_entry(entry);
}

static void forget_recent_inputs(struct journal *journal)
{
    memset(journal->recent_inputs, 0, sizeof(journal->recent_inputs));
}

void journal_take_back(struct journal *journal, struct chunk_place place)
{
    struct journal_walk walk = journal_start(journal, NULL, NULL);
    walk.place = place;
    if (journal->has_references)
        release_entries(walk);
    chunk_list_cut(&journal->entries, place);
    journal->call = place;
    forget_recent_inputs(journal);
}

__attribute__((cold, noinline)) static void release_held(struct journal *journal)
{
    if (journal->has_references)
        release_entries(journal_start(journal, NULL, NULL));
    journal->place_count = 0;
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
    journal->has_events = journal->writes_queries = false;
    journal->unknown = journal->accesses_unknown = (struct unknown){0};
    journal->awaits_inputs = journal->has_condition = false;
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
