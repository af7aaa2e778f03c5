/* SPDX-License-Identifier: Apache-2.0 */
/* Setting advice: follows what becomes of each structure, judges it when it is destroyed, or the
 * device or the instance is, and lists what it is advised (src/advice/list.h). Silent from when the
 * order of submissions is unknown. */
#include <stdlib.h>

#include "layer/advice/refits.h"
#include "layer/consumers.h"
#include "src/advice/list.h"
#include "src/advice/rules.h"
#include "src/advice/single_calls.h"
#include "src/base/unknown.h"
#include "src/state/commands/object_names.h"

/* With a greater limit of submissions nothing counts as old. */
enum { RING_MAX = 1 << 16 };

struct adviser {
    struct layer_device *device;
    const struct advice_limits *limits;
    struct advice_list *list;
    struct refit_rules *refits;
    atomic_uint submissions; /* executed batches with command buffers */
    atomic_uint outstanding; /* batches that were submitted and did not execute yet */
    /* Builds of top-level structures that have executed, and those of them whose references are
     * known.
     */
    atomic_uint tops, known_tops;
    atomic_uint tiny;       /* structures with few primitives that are alive */
    uint32_t most_tiny;     /* at a time; read when all work has executed */
    uint32_t single_calls;  /* the most in a row; read then, too */
    struct unknown unknown; /* uses of structures may be missing */
    /* The last id of an object after each of the last submissions, by their number: a ring. */
    uint32_t ring_size; /* as many as the limit; 0: none */
    _Atomic uint64_t *created;
};

static void destroy(void *self)
{
    struct adviser *advice = self;
    refit_rules_destroy(advice->refits);
    advice_list_destroy(advice->list);
    free((void *)advice->created);
    free(advice);
}

static VkResult start(struct layer_device *device, void **self)
{
    const struct settings *settings = reporter_settings(device->instance->reporter);
    if (!settings->advice || device->level < LEVEL_EXECUTION)
        return VK_SUCCESS;
    struct adviser *advice = calloc(1, sizeof(*advice));
    if (!advice)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    advice->device = device;
    advice->limits = &settings->advice_limits;
    unknown_follow(&advice->unknown, device->facts.newer_than_registry);
    const uint32_t limit = advice->limits->of[ADVICE_LIMIT_submissions];
    advice->ring_size = limit > RING_MAX ? 0 : limit ? limit : 1;
    advice->created = calloc(advice->ring_size + 1, sizeof(*advice->created));
    advice->list = advice_list_create(advice->limits->of[ADVICE_LIMIT_lines]);
    advice->refits = refit_rules_create(device, advice->limits, advice->list);
    if (!advice->list || !advice->refits || !advice->created) {
        destroy(advice);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    device->notes_figures = true;
    *self = advice;
    return VK_SUCCESS;
}

/* ---- what batches do */

struct noting {
    struct adviser *advice;
    struct structures *structures;
    bool is_tiny; /* the next build has few primitives */
    bool has_memory;
};

/* The functions with a walk are events of a journal; `user` is the struct noting. */

static void note_use(struct noting *noting, uint64_t id, enum structure_use use)
{
    noting->has_memory &= uses_note(noting->structures, id, use);
}

static void note_figures(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct noting *noting = walk->user;
    const uint32_t few = noting->advice->limits->of[ADVICE_LIMIT_few_primitives];
    noting->is_tiny = entry->info && entry->number && entry->number <= few;
}

static bool is_bottom(const struct journal_entry *entry)
{
    return entry->built.type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
}

static bool is_top(const struct journal_entry *entry)
{
    return entry->built.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
}

static void note_top(struct noting *noting, bool may_be_top)
{
    atomic_fetch_add(&noting->advice->tops, may_be_top);
}

static void note_tiny(struct noting *noting, uint64_t id, bool is_tiny)
{
    struct adviser *advice = noting->advice;
    const bool was_tiny = uses_note_tiny(noting->structures, id, is_tiny);
    const uint32_t tiny = atomic_fetch_add(&advice->tiny, is_tiny - was_tiny) + is_tiny - was_tiny;
    advice->most_tiny = tiny > advice->most_tiny ? tiny : advice->most_tiny;
}

static void note_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct noting *noting = walk->user;
    noting->has_memory &=
        uses_note_build(noting->structures, entry->dst_id, noting->advice->submissions,
                        entry->built.flags, built_needed_size(&entry->built));
    note_tiny(noting, entry->dst_id, noting->is_tiny && is_bottom(entry));
    note_top(noting, is_top(entry));
    noting->is_tiny = false;
}

static void note_update(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct noting *noting = walk->user;
    noting->is_tiny = false;
    note_use(noting, entry->dst_id, USE_UPDATED);
    note_use(noting, entry->src_id, USE_UPDATE_SOURCE);
    note_top(noting, is_top(entry));
}

static void note_copy(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct noting *noting = walk->user;
    struct structure_uses of_src;
    note_use(noting, entry->src_id, journal_entry_compacts(entry) ? USE_COMPACTED : USE_COPIED);
    note_use(noting, entry->dst_id, USE_FILLED);
    note_tiny(noting, entry->dst_id,
              uses_find(noting->structures, entry->src_id, &of_src) && of_src.is_tiny);
    uses_copy_box(noting->structures, entry->dst_id, entry->src_id);
    uses_copy_haste(noting->structures, entry->dst_id, entry->src_id, noting->advice->submissions);
}

/* A structure may be a top-level one, whose instances are not read. */
static void note_fill(struct journal_walk *walk, const struct journal_entry *entry)
{
    note_use(walk->user, entry->dst_id, USE_FILLED);
    note_tiny(walk->user, entry->dst_id, false);
    note_top(walk->user, entry->info == FILL_READS_ACCEL);
}

static void note_read(struct journal_walk *walk, const struct journal_entry *entry)
{
    const bool is_size =
        entry->read.query == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    if (entry->read.query == VK_QUERY_TYPE_MAX_ENUM || is_size)
        note_use(walk->user, entry->src_id, is_size ? USE_SIZE_QUERIED : USE_COPIED);
}

/* The replay of the batch has trusted the answer, or has not kept its size. */
static void note_answer(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct noting *noting = walk->user;
    const struct structure *state = structures_find(noting->structures, entry->src_id);
    const struct compacted_size *compacted = state ? state->built.compacted_size : NULL;
    if ((VkQueryType)entry->info != VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR)
        return;
    if (entry->src)
        note_use(noting, entry->src_id, USE_SIZE_QUERIED);
    if (compacted && compacted->size)
        noting->has_memory &=
            uses_note_compacted_size(noting->structures, compacted->serialized_id, compacted->size);
    else
        noting->advice->device->sizes_may_be_unknown = true;
}

/* The journals of some submissions: those whose number is a power of two. */
static void note_single_calls(struct adviser *advice, const struct journal *journal)
{
    const uint32_t number = advice->submissions;
    if (number & (number - 1))
        return;
    const uint32_t calls = journal_find_single_calls(journal);
    advice->single_calls = calls > advice->single_calls ? calls : advice->single_calls;
}

static void note_journal(struct noting *noting, const struct journal *journal);

static void note_secondary(struct journal_walk *walk, const struct journal_entry *entry)
{
    note_journal(walk->user, entry->secondary);
}

static void note_journal(struct noting *noting, const struct journal *journal)
{
    static const struct journal_events notes = {.primitives = note_figures,
                                                .build = note_build,
                                                .update = note_update,
                                                .copy = note_copy,
                                                .fill = note_fill,
                                                .read = note_read,
                                                .answer = note_answer,
                                                .execute = note_secondary};
    if (noting->advice->device->hazard_checks)
        note_single_calls(noting->advice, journal);
    journal_walk(journal, &notes, noting);
}

/* What a failed command of the host has written is unknown. */
static void note_failed_write(struct journal_walk *walk, const struct journal_entry *entry)
{
    note_use(walk->user, entry->dst_id, USE_FILLED);
    note_top(walk->user, true);
}

static const struct journal_events failures = {ON_WRITES(note_failed_write)};

/* ---- batches */

static bool is_of_queue(const struct order_batch *batch)
{
    const struct journal *journal = batch->command_count ? batch->commands[0].captured : NULL;
    return batch->work == WORK_OF_QUEUE && !(journal && journal->binds);
}

static void advice_submit(void *user, struct order_batch *batch)
{
    struct adviser *advice = user;
    (void)batch;
    atomic_fetch_add(&advice->outstanding, 1);
}

static void advice_fail(void *user, struct order_batch *batch)
{
    struct adviser *advice = user;
    (void)batch;
    atomic_fetch_sub(&advice->outstanding, 1);
}

/* Work of the host counts when it has ended. */
static void note_batch(struct adviser *advice, const struct order_batch *batch)
{
    struct noting noting = {
        .advice = advice, .structures = advice->device->structures, .has_memory = true};
    for (uint32_t i = 0; i < batch->command_count; i++) {
        const struct journal *journal = batch->commands[i].captured;
        if (batch->work == WORK_OF_QUEUE || batch->work == WORK_ENDS)
            note_journal(&noting, journal);
        else if (batch->work == WORK_FAILS)
            journal_walk(journal, &failures, &noting);
    }
    if (!noting.has_memory)
        unknown_set(&advice->unknown, UNKNOWN_USES);
}

static void count_submission(struct adviser *advice)
{
    const uint32_t number = advice->submissions + 1;
    if (advice->ring_size)
        advice->created[number % advice->ring_size] = resources_last_id(advice->device->resources);
    advice->submissions = number;
}

static void advice_run(void *user, struct order_batch *batch)
{
    struct adviser *advice = user;
    const bool is_submitted = is_of_queue(batch);
    if (is_submitted && batch->command_count)
        count_submission(advice);
    if (batch->is_replayed && batch->work != WORK_SYNC)
        note_batch(advice, batch);
    else if (batch->work != WORK_SYNC)
        unknown_follow(&advice->unknown, true);
    atomic_fetch_sub(&advice->outstanding, is_submitted);
}

static void order_unknown(void *user, enum order_unknown_reason why)
{
    struct adviser *advice = user;
    (void)why;
    unknown_follow(&advice->unknown, true);
}

static struct batch_consumer batches(void *self)
{
    return (struct batch_consumer){.user = self,
                                   .submit = advice_submit,
                                   .run = advice_run,
                                   .fail = advice_fail,
                                   .order_unknown = order_unknown};
}

/* ---- the list */

static struct advice_report report_about(const struct adviser *advice, enum advice id,
                                         VkObjectType type, uint64_t object)
{
    struct advice_report report = {
        .advice = id, .type = type, .object = object, .names = advice->device->names};
    object_names_get(advice->device->names, type, object, report.name, sizeof(report.name));
    return report;
}

/* Adds an advice about a live object to the list, with its name. Any thread. */
static void add_advice(struct adviser *advice, enum advice id, VkObjectType type, uint64_t object,
                       const struct finding *finding, uint64_t weight)
{
    struct advice_report report = report_about(advice, id, type, object);
    report.finding = *finding;
    advice_list_add(advice->list, &report, weight);
}

/* Sends what is certain by now. */
static void report(void *self, const struct order_batch *batch, uint32_t command)
{
    const struct adviser *advice = self;
    (void)batch;
    (void)command;
    advice_list_send_certain(advice->list, advice->device->instance->reporter,
                             advice->device->handle);
}

/* ---- what is read */

struct advised_build {
    struct advice_reading reading;
    struct adviser *advice;
    const struct build_parameters *given;
    uint64_t id; /* of dst */
    const struct execution_point *point;
};

/* The structure may have been destroyed since, and the handle be that of another one. */
static void add_found(const struct advised_build *build, const struct content_advice *found)
{
    struct adviser *advice = build->advice;
    struct layer_device *device = advice->device;
    const uint64_t dst = handle_number(build->given->info.dstAccelerationStructure);
    if (resources_find_id(device->resources, RESOURCE_ACCEL, dst) != build->id)
        return;
    if (found->refit.now) {
        const struct advice_report report = report_about(
            advice, ADVICE_updates_suit_the_tree, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, dst);
        refit_rules_add(advice->refits, build->id, &found->refit, &report);
    }
    for (enum advice id = 0; id < ADVICE_COUNT; id++)
        if (found->kept[id].weight && uses_note_advised(device->structures, build->id, id))
            add_advice(advice, id, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, dst,
                       &found->kept[id].finding, found->kept[id].weight);
}

static void note_digest(const struct advised_build *build, const struct input_digest *digest)
{
    const struct layer_device *device = build->advice->device;
    if (uses_note_input(device->structures, build->id, digest) &&
        !resources_accel_is_alone(device->resources, build->given->info.dstAccelerationStructure))
        uses_note_shared(device->structures, build->id);
}

static void end_build(struct build_reader *reader)
{
    struct advised_build *build = (struct advised_build *)reader;
    struct advice_reading *reading = &build->reading;
    if (advice_reading_end(reading, build->given))
        uses_note_contents(build->advice->device->structures, build->id,
                           &reading->advice->contents);
    if (reading->advice)
        add_found(build, reading->advice);
    if (reading->has_digest)
        note_digest(build, digest_end(&reading->digesting, build->given, build->point)
                               ? &reading->digesting.digest
                               : NULL);
    advice_reading_free(reading);
    free(build);
}

/* Builds of VK_NV_ray_tracing get no advice. */
static struct build_reader *on_build(void *self, const struct executed_input *executed)
{
    struct adviser *advice = self;
    struct structures *structures = advice->device->structures;
    const uint64_t id = executed->entry ? executed->entry->dst_id : 0;
    if (!id || executed->build->place.command == COMMAND_NV)
        return NULL;
    const struct reading_wanted wanted = uses_begin_read(structures, id);
    const bool wants_digest = wanted.is_compared && executed->is_in_order;
    struct advised_build *build = wants_digest || wanted.is_judged ? malloc(sizeof(*build)) : NULL;
    if (wanted.is_compared && !(build && wants_digest))
        uses_note_input(structures, id, NULL);
    if (!build)
        return NULL;
    build->advice = advice;
    build->given = recorded_build_given(executed->build);
    build->id = id;
    build->point = executed->point;
    advice_reading_begin(&build->reading, build->given, wanted.is_judged ? advice->limits : NULL,
                         wanted.number, wants_digest);
    build->reading.reader.end = end_build;
    return &build->reading.reader;
}

static void on_all_references(void *self, enum build_command command,
                              const struct instance_uses *uses)
{
    struct adviser *advice = self;
    bool is_known = true;
    if (command == COMMAND_NV)
        return;
    for (uint32_t i = 0; uses && i < uses->count; i++)
        is_known &=
            uses_note(advice->device->structures, uses->items[i].referenced.id, USE_REFERRED_TO);
    atomic_fetch_add(&advice->known_tops, is_known);
}

/* ---- judging */

/* Whether the object was there when the first of the last submissions executed. */
static bool is_old(const struct adviser *advice, uint64_t id)
{
    const uint32_t size = advice->ring_size, number = advice->submissions;
    return size && number >= size && id <= advice->created[(number + 1) % size];
}

struct advice_pass {
    struct adviser *advice;
    VkObjectType type;
    uint64_t object;
};

static void add_found_advice(void *user, enum advice id, const struct finding *finding,
                             uint64_t weight)
{
    const struct advice_pass *pass = user;
    add_advice(pass->advice, id, pass->type, pass->object, finding, weight);
}

/* Builds of structures without handles may use those that have one. */
static bool misses_uses(const struct adviser *advice)
{
    bool misses = unknown_is_set(&advice->unknown);
    for (enum place_kind kind = 0; kind < PLACE_KINDS; kind++)
        misses |= places_are_used(advice->device->places, kind);
    return misses;
}

/* Batches that did not execute yet may hold the use that is missing. */
static void judge_structure(struct adviser *advice, const struct accel_facts *accel, bool is_left)
{
    struct structure_uses uses;
    if (misses_uses(advice) || advice->outstanding || accel->alive != YES ||
        !accel->details_known || !uses_find(advice->device->structures, accel->id, &uses))
        return;
    const struct use_view view = {
        .accel = accel,
        .uses = &uses,
        .lived = uses.counts[USE_BUILT] || uses.is_hasty_copy
                     ? advice->submissions - uses.first_build
                     : 0,
        .size_may_be_unknown = advice->device->sizes_may_be_unknown,
        .is_old = is_old(advice, accel->id),
        .is_left = is_left,
        .references_are_known = advice->known_tops && advice->known_tops == advice->tops,
        .limits = advice->limits,
    };
    struct advice_pass pass = {advice, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                               handle_number(accel->handle)};
    advice_judge_use(&view, add_found_advice, &pass);
}

static void judge_all(struct adviser *advice)
{
    const struct crowd_view view = {
        .tiny = advice->most_tiny, .single_calls = advice->single_calls, .limits = advice->limits};
    struct advice_pass pass = {advice, VK_OBJECT_TYPE_DEVICE,
                               handle_number(advice->device->handle)};
    if (!misses_uses(advice))
        advice_judge_crowd(&view, add_found_advice, &pass);
}

/* Each structure gets the advice once. It may be destroyed by now. */
static void on_stale_trace(void *self, uint64_t top, uint64_t changed)
{
    struct adviser *advice = self;
    const struct layer_device *device = advice->device;
    const enum advice id = ADVICE_top_level_is_newer_than_its_bottom_levels;
    const struct traced_view view = {changed};
    const uint64_t of_top = resources_find_id(device->resources, RESOURCE_ACCEL, top);
    struct finding finding;
    uint64_t weight;
    if (!of_top || top_level_is_newer_than_its_bottom_levels(&view, &finding, &weight) ||
        !uses_note_advised(device->structures, of_top, id))
        return;
    add_advice(advice, id, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, top, &finding, weight);
    report(advice, NULL, 0);
}

static void on_destroy(void *self, VkAccelerationStructureKHR accel)
{
    struct adviser *advice = self;
    struct accel_facts facts;
    if (!accel)
        return;
    resources_look_up_accel(advice->device->resources, accel, &facts);
    judge_structure(advice, &facts, false);
    atomic_fetch_sub(&advice->tiny, uses_note_tiny(advice->device->structures, facts.id, false));
}

/* The thread that compares trees ends: after the instance the loader may unload the layer. */
static void conclude(void *self, bool destroys_device)
{
    struct adviser *advice = self;
    uint32_t count = 0;
    struct accel_facts *accels = resources_list_accels(advice->device->resources, &count);
    for (uint32_t i = 0; i < count; i++)
        judge_structure(advice, &accels[i], destroys_device);
    free(accels);
    judge_all(advice);
    refit_rules_end(advice->refits);
    advice_list_send(advice->list, advice->device->instance->reporter, advice->device->handle);
}

static void stop(void *self)
{
    const struct adviser *advice = self;
    refit_rules_end(advice->refits);
}

const struct consumer adviser = {
    .start = start,
    .conclude = conclude,
    .stop = stop,
    .destroy = destroy,
    .batches = batches,
    .on_destroy = on_destroy,
    .on_stale_trace = on_stale_trace,
    .on_build = on_build,
    .on_all_references = on_all_references,
    .report = report,
};
