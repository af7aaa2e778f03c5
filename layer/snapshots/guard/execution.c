/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the orders of guarded builds, sets their limits in execution order, and reports what was
 * replaced. */
#include "layer/snapshots/guard/execution.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "layer/snapshots/guard/references.h"
#include "src/base/array.h"
#include "src/base/text_buffer.h"
#include "src/report/words.h"
#include "src/state/builds/places.h"
#include "src/state/commands/journal.h"

/* Memory that is not known to be unreadable is read, as the build would read it. */
static uint32_t readable_bytes(struct resources *resources, uint64_t address, uint64_t size,
                               const struct execution_clock *seen)
{
    struct address_facts facts;
    uint64_t readable = resources_find_readable(resources, address, size, seen);
    if (readable)
        return readable < GUARD_UNLIMITED ? (uint32_t)readable : GUARD_UNLIMITED;
    resources_look_up_address(resources, address, &facts);
    bool is_certain = facts.status == ADDRESS_NULL || facts.status == ADDRESS_NOWHERE ||
                      facts.status == ADDRESS_UNBOUND;
    return is_certain ? 0 : GUARD_UNLIMITED;
}

static void write_ranges(struct resources *resources, const struct recording *recording,
                         const struct build_guard *guard, struct guard_order *order)
{
    const struct snapshot *list = &guard->ranges;
    bool is_whole = gather_write_ranges(resources, snapshot_bytes(recording, list), list->size) &&
                    !resources_has_unknown_ranges(resources);
    order->range_count = is_whole ? (uint32_t)(list->size / sizeof(uint64_t[2])) : GUARD_UNLIMITED;
}

/* Whether the list is still that of all readable memory. */
static bool ranges_are_current(struct resources *resources, const struct recording *recording,
                               const struct snapshot *list)
{
    unsigned char *now = malloc(list->size);
    const bool are_current = now && gather_write_ranges(resources, now, list->size) &&
                             memcmp(now, snapshot_bytes(recording, list), list->size) == 0;
    free(now);
    return are_current;
}

/* ---- structures without a handle */

enum { SPARE_PLACES = 16 };

uint64_t guard_places_size(const struct layer_device *device)
{
    uint32_t count;
    free(places_list(device->places, PLACE_BOTTOM_LEVEL, &count));
    return !device->places || count == PLACES_ANYWHERE
               ? 0
               : (2ull * count + SPARE_PLACES) * sizeof(struct place_range);
}

/* Without a limit, builds that are recorded later may execute before this one. */
static uint32_t write_places(const struct layer_device *device, const struct recording *recording,
                             const struct build_guard *guard, uint32_t limit)
{
    const struct snapshot *list = &guard->places;
    uint32_t count;
    if (!device->places || guard->is_nv)
        return 0;
    if (limit == GUARD_UNLIMITED && device->facts.extension.cluster_acceleration_structure_nv)
        return GUARD_UNLIMITED;
    struct place_range *ranges = places_list(device->places, PLACE_BOTTOM_LEVEL, &count);
    if (count > list->size / sizeof(*ranges))
        count = GUARD_UNLIMITED;
    else if (count)
        memcpy(snapshot_bytes(recording, list), ranges, count * sizeof(*ranges));
    free(ranges);
    return count;
}

/* The addresses were written when the build was recorded. An array of a partitioned structure may
 * lie in memory that is allocated while an earlier execution is pending, and all invocations must
 * agree on what of it is readable: so that is unknown if the command buffer executes several times
 * at once. */
static void write_order(const struct layer_device *device, const struct recording *recording,
                        const struct execution_clock *seen, const struct recorded_build *build,
                        uint32_t limit, struct guard_order *order)
{
    const struct build_guard *guard = build->guard;
    struct resources *resources = device->resources;
    order->readable = guard->is_nv
                          ? GUARD_UNLIMITED
                          : readable_bytes(resources, guard->source, guard->source_size, seen);
    order->can_read_range =
        !guard->indirect || readable_bytes(resources, guard->indirect, guard->indirect_size,
                                           seen) >= guard->indirect_size;
    order->range_count = build->addressed ? GUARD_UNLIMITED : 0;
    if (guard->ranges.size && !(build->addressed && recording->executes_at_once))
        write_ranges(resources, recording, guard, order);
    order->place_count = write_places(device, recording, guard, limit);
    order->limit = limit;
    order->replaced = order->unreadable = order->is_done = 0;
    order->first_replaced = UINT32_MAX;
}

void guard_renew(const struct layer_device *device, const struct recording *recording,
                 const struct execution_clock *seen, bool is_pending, bool has_limits)
{
    if (!recording->has_guards)
        return;
    for (const struct recorded_build *build = recording->builds; build; build = build->next) {
        const struct build_guard *guard = build->guard;
        if (!guard)
            continue;
        struct guard_order *order = guard_order_of(recording, guard);
        uint32_t limit = has_limits ? atomic_load(&guard->limit) : GUARD_UNLIMITED;
        if (!is_pending)
            write_order(device, recording, seen, build, limit, order);
        else if (limit > order->limit)
            __atomic_store_n(&order->limit, limit, __ATOMIC_RELAXED);
        if (is_pending && device->facts.extension.cluster_acceleration_structure_nv)
            __atomic_store_n(&order->place_count, GUARD_UNLIMITED, __ATOMIC_RELAXED);
        if (is_pending && guard->ranges.size &&
            !ranges_are_current(device->resources, recording, &guard->ranges))
            __atomic_store_n(&order->range_count, GUARD_UNLIMITED, __ATOMIC_RELAXED);
    }
}

/* ---- walks in execution order: builds are counted, and limits of guarded builds set */

static struct guard *guard_of(const struct layer_device *device)
{
    return device->snapshots ? device->snapshots->guard : NULL;
}

/* ---- the submission of a thread */

/* The check of a batch and the call down are on one thread, with nothing of another submission
 * between them. */
static _Thread_local struct {
    uint32_t checked, limited; /* batches */
} submission_of_thread;

void guard_begin_submission(void)
{
    submission_of_thread.checked = submission_of_thread.limited = 0;
}

uint32_t guard_limited_batches(void)
{
    return submission_of_thread.limited;
}

/* A batch behind one without limits has none either: it may execute the same command buffer, whose
 * orders have been written for the earlier batch by then. */
static bool count_batch(bool has_place)
{
    bool is_limited = has_place && submission_of_thread.limited == submission_of_thread.checked;
    submission_of_thread.checked++;
    submission_of_thread.limited += is_limited;
    return is_limited;
}

/* ---- batches */

struct guard_walk {
    struct guard *guard;
    bool sets_limits; /* the batch is about to be submitted, at a known place in execution order */
    bool may_precede; /* earlier submissions with guarded builds may execute after this batch */
    bool has_guards;
};

static void set_limit(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct guard_walk *batch = walk->user;
    const struct recording *recording = walk->journal->work;
    struct recorded_build *build =
        batch->sets_limits && recording && recording->has_guards ? journal_copies(entry) : NULL;
    uint32_t limit = guard_next_count(batch->guard) - 1;
    if (!build || !build->guard)
        return;
    atomic_store(&build->guard->limit, limit < GUARD_UNLIMITED - 1 ? limit : GUARD_UNLIMITED);
    batch->has_guards = true;
}

/* Instances may refer to the structure. */
static void note_written(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct guard_walk *batch = walk->user;
    guard_note_built(batch->guard, entry->dst, entry->dst_id,
                     batch->may_precede ? 0 : guard_next_count(batch->guard));
}

static void note_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    set_limit(walk, entry);
    if (entry->built.type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR)
        note_written(walk, entry);
}

static const struct journal_events notes = {ON_BUILDS(note_build), .inputs = set_limit,
                                            .copy = note_written, .fill = note_written,
                                            .execute = journal_walk_secondary};

static void walk_batch(struct guard_walk *walk, const struct order_batch *batch)
{
    for (uint32_t i = 0; i < batch->command_count; i++)
        if (batch->commands[i].captured)
            journal_walk(batch->commands[i].captured, &notes, walk);
}

static void guard_check(void *user, struct order_batch *batch)
{
    struct guard_walk walk = {.guard = guard_of(user)};
    if (batch->work != WORK_OF_QUEUE)
        return;
    walk.sets_limits = count_batch(batch->predecessors_known && batch->is_replayed);
    if (!batch->is_replayed)
        return;
    struct execution_clock *guarded = guard_clock(walk.guard);
    walk.may_precede = !execution_clock_covers(&batch->clock, guarded);
    guard_update(walk.guard);
    walk_batch(&walk, batch);
    if (walk.has_guards)
        execution_clock_add(guarded, batch->timestamp);
}

/* Work of the host counts when it begins, because a submission may overlap it. */
static void guard_run(void *user, struct order_batch *batch)
{
    struct guard_walk walk = {.guard = guard_of(user), .may_precede = true};
    bool is_counted = batch->work == WORK_OF_QUEUE ? batch->is_checked : batch->work != WORK_BEGINS;
    if (!is_counted)
        walk_batch(&walk, batch);
}

struct batch_consumer guard_consumer(struct layer_device *device)
{
    return (struct batch_consumer){.user = device, .check = guard_check, .run = guard_run};
}

/* ---- reports what the guard replaced */

void guard_results_add(struct guard_results *results, const struct journal *journal,
                       const struct recorded_build *build, unsigned char *const *bases)
{
    struct guard_order order;
    if (!build->guard)
        return;
    memcpy(&order, bases[build->guard->order.chunk] + build->guard->order.offset, sizeof(order));
    if (!order.is_done || !(order.replaced || order.unreadable))
        return;
    if (!ARRAY_HAS_ROOM(results->items, results->count, results->capacity))
        return;
    results->items[results->count++] =
        (struct guard_result){journal,        build->place.position, build->addressed,
                              order.replaced, order.first_replaced,  order.unreadable,
                              false};
}

static bool is_about_references(enum rule rule)
{
    return rule == RULE_instance_references_are_zero_or_a_blas ||
           rule == RULE_instances_are_backed_by_memory ||
           rule == RULE_instances_refer_to_built_structures ||
           rule == RULE_nv_instance_references_are_blas_handles ||
           rule == RULE_nv_instance_references_are_of_live_structures;
}

uint32_t guard_results_explain(struct guard_results *results, const struct journal *journal,
                               uint32_t position, enum rule rule)
{
    for (uint32_t i = 0; i < results->count && is_about_references(rule); i++) {
        struct guard_result *result = &results->items[i];
        if (result->journal != journal || result->position != position || !result->replaced)
            continue;
        result->is_reported = true;
        return result->replaced;
    }
    return 0;
}

static void warn_of_replaced(const struct guard_result *result, const struct layer_device *device)
{
    char line[512];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, "assay_validation.guard = references: in ");
    if (result->is_partitioned)
        text_append(&text, "a build of a partitioned structure");
    else
        text_say(&text, "build {}", number(result->position));
    text_say(&text, " of VkCommandBuffer {} the layer ",
             hex(handle_number(result->journal->command_buffer)));
    if (result->replaced)
        text_say(
            &text,
            "replaced {} by 0 to what is not a live, built bottom-level acceleration structure. "
            "The first is that of instance {}",
            count_of(result->replaced, "reference"), number(result->first_replaced));
    if (result->replaced && result->unreadable)
        text_append(&text, "; also ");
    if (result->unreadable && result->is_partitioned)
        text_say(&text, "left out {} in memory that cannot be read",
                 count_of(result->unreadable, "instance"));
    else if (result->unreadable)
        text_say(&text, "{}{} in memory that cannot be read by inactive ones",
                 phrase(result->replaced ? "" : "replaced "),
                 count_of(result->unreadable, "instance"));
    text_append(&text, ".");
    reporter_warn(device->instance->reporter, line);
}

void guard_results_end(struct guard_results *results, const struct layer_device *device)
{
    for (uint32_t i = 0; i < results->count; i++)
        if (!results->items[i].is_reported)
            warn_of_replaced(&results->items[i], device);
    free(results->items);
    *results = (struct guard_results){0};
}
