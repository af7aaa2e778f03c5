/* SPDX-License-Identifier: Apache-2.0 */
/* The list, without printf, which may allocate. */
#include "layer/postmortem/postmortem.h"

#include "layer/execution/submitted_builds.h"
#include "src/report/message.h"

enum { NAME_SIZE = 256, RANKS = 7 };

struct list {
    const struct layer_device *device;
    bool waits;
    const struct pending_faults *faults; /* or NULL */
    struct text_buffer *text;
    uint32_t rank, listed, count;
    uint32_t first_rank; /* of the first build */
    bool ranks_differ;
    bool may_run; /* a build may have been running */
};

/* ---- what leads to the culprit */

static bool is_hit(const struct list *list, uint64_t address, uint64_t size)
{
    for (uint32_t i = 0; list->faults && i < list->faults->count; i++)
        if (address < list->faults->ranges[i].end && list->faults->ranges[i].begin < address + size)
            return true;
    return false;
}

static bool is_hit_structure(const struct list *list, const struct submitted_build *build,
                             uint64_t handle)
{
    struct resource_span span;
    for (uint32_t i = 0; handle && i < list->faults->count; i++)
        if (list->faults->ranges[i].structure == handle)
            return true;
    return handle && build->entry->command != COMMAND_NV &&
           resources_find_span(list->device->resources, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                               handle, list->waits, &span) &&
           span.address && is_hit(list, span.address, span.size);
}

/* Whether a faulting address lies in the build's structures or inputs. */
static bool has_fault(const struct list *list, const struct submitted_build *build)
{
    const struct recorded_build *copies = build->copies;
    if (!list->faults || !list->faults->count)
        return false;
    for (uint32_t i = 0; copies && i < copies->snapshot_count; i++)
        if (is_hit(list, copies->snapshots[i].address, copies->snapshots[i].size))
            return true;
    return is_hit_structure(list, build, build->entry->dst) ||
           (journal_is_update(build->entry) && is_hit_structure(list, build, build->entry->src));
}

static bool has_findings(const struct submitted_build *build)
{
    return build->copies && atomic_load(&build->copies->has_findings);
}

/* ---- one build */

static void append_object(const struct list *list, VkObjectType type, uint64_t handle)
{
    char name[NAME_SIZE];
    const struct object_names *names = list->device->names;
    size_t length = list->waits ? object_names_get(names, type, handle, name, sizeof(name))
                                : object_names_try_get(names, type, handle, name, sizeof(name));
    text_append_plain(list->text, object_type_name(type));
    text_append_plain(list->text, " ");
    text_append_hex(list->text, handle);
    if (!length)
        return;
    text_append_plain(list->text, "[");
    text_append_quoted(list->text, name, length);
    text_append_plain(list->text, "]");
}

static void append_labels(const struct list *list, const char *what,
                          const struct label_stack *labels)
{
    for (uint32_t i = 0; labels && i < labels->count; i++) {
        text_append_plain(list->text, i ? " > " : what);
        text_append_quoted(list->text, labels->labels[i].pLabelName, NAME_SIZE - 1);
    }
}

static void append_structure(const struct list *list, const struct journal_entry *entry)
{
    const VkObjectType type = entry->command == COMMAND_NV
                                  ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                  : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    struct resource_span span;
    text_append_plain(list->text, journal_is_update(entry) ? "update of " : "build of ");
    append_object(list, type, entry->dst);
    if (!resources_find_span(list->device->resources, type, entry->dst, list->waits, &span))
        return;
    text_append_plain(list->text, " (");
    text_append_count(list->text, span.size, "byte");
    text_append_plain(list->text, ")");
}

static const char *words_of(const struct submitted_build *build)
{
    switch (build->state) {
    case MARK_IS_UNKNOWN:
        return "";
    case MARK_IS_CLEAR:
        return ": the device had not reached it";
    case MARK_HAS_COPIES:
        return build->lacks_inputs ? ": the device had reached it, and it had not finished"
                                   : ": its inputs had been copied, and it had not finished";
    case MARK_HAS_BUILDS:
        return ": it had finished";
    }
    return "";
}

static void append_build(const struct list *list, const struct submitted_build *build)
{
    const struct journal_entry *entry = build->entry;
    const struct call_site *site = journal_site(build->journal, entry->origin);
    text_append_plain(list->text, "\n");
    text_append_decimal(list->text, list->listed);
    text_append_plain(list->text, ". ");
    append_structure(list, entry);
    text_append_plain(list->text, " from ");
    text_append_count(list->text, entry->built.geometry_count, "geometry");
    text_append_plain(list->text, ", ");
    append_object(list, VK_OBJECT_TYPE_COMMAND_BUFFER,
                  handle_number(build->journal->command_buffer));
    text_append_plain(list->text, ", build ");
    text_append_decimal(list->text, entry->built.position);
    append_labels(list, ", labels ", journal_labels(build->journal, entry->origin));
    if (build->primary != build->journal->command_buffer) {
        text_append_plain(list->text, ", executed by ");
        append_object(list, VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(build->primary));
    }
    text_append_plain(list->text, ", as submitted to ");
    append_object(list, VK_OBJECT_TYPE_QUEUE, handle_number(build->submission->queue));
    if (build->submission->number) {
        text_append_plain(list->text, ", submission ");
        text_append_decimal(list->text, build->submission->number);
    }
    append_labels(list, ", queue labels ", shared_labels_stack(build->submission->labels));
    text_append_plain(list->text, words_of(build));
    if (has_findings(build))
        text_append_plain(list->text, "; there are findings about its inputs");
    if (has_fault(list, build))
        text_append_plain(list->text, "; a faulting address lies in its inputs or structures");
    text_append_plain(list->text, ".");
    if (site)
        message_append_call_site(list->text, site, 1); /* the list is to fit into a message */
}

/* ---- all builds */

/* The likeliest culprit has rank 0. */
static uint32_t rank_of(const struct list *list, const struct submitted_build *build)
{
    if (has_findings(build))
        return build->state == MARK_HAS_BUILDS ? 1 : 0;
    if (has_fault(list, build))
        return 2;
    switch (build->state) {
    case MARK_HAS_COPIES:
        return 3;
    case MARK_IS_UNKNOWN:
        return 4;
    case MARK_IS_CLEAR:
        return 5;
    case MARK_HAS_BUILDS:
        break;
    }
    return 6;
}

static bool count_build(void *user, const struct submitted_build *build)
{
    struct list *list = user;
    const uint32_t rank = rank_of(list, build);
    if (!list->count++)
        list->first_rank = rank;
    list->ranks_differ |= rank != list->first_rank;
    list->may_run |= build->state == MARK_HAS_COPIES || build->state == MARK_IS_UNKNOWN;
    return true;
}

static bool list_build(void *user, const struct submitted_build *build)
{
    struct list *list = user;
    if (rank_of(list, build) != list->rank)
        return true;
    if (list->listed == PENDING_LISTED)
        return false;
    list->listed++;
    append_build(list, build);
    return true;
}

uint32_t pending_list_append(const struct layer_device *device, bool waits,
                             const struct pending_faults *faults, struct text_buffer *text)
{
    struct submitted_builds *submitted = device->submitted_builds;
    struct list list = {.device = device, .waits = waits, .faults = faults, .text = text};
    if (!submitted || !submitted_builds_each(submitted, waits, count_build, &list) || !list.count)
        return 0;
    text_append_count(text, list.count, "build");
    text_append_plain(text, list.count == 1 ? " was" : " were");
    text_append_plain(text, " submitted to ");
    append_object(&list, VK_OBJECT_TYPE_DEVICE, handle_number(device->handle));
    text_append_plain(text, " and may not be complete");
    if (!list.may_run)
        text_append_plain(text,
                          list.count == 1 ? ", but was not running" : ", but none was running");
    text_append_plain(text, list.count == 1     ? ":"
                            : list.ranks_differ ? ", the likeliest culprit first:"
                                                : ", in the order in which they were submitted:");
    for (; list.rank < RANKS; list.rank++)
        submitted_builds_each(submitted, waits, list_build, &list);
    if (list.listed < list.count) {
        text_append_plain(text, "\nand ");
        text_append_decimal(text, list.count - list.listed);
        text_append_plain(text, " more.");
    }
    return list.count;
}
