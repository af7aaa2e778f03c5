/* SPDX-License-Identifier: Apache-2.0 */
/* Words the list. A signal handler does so, too: nothing here allocates or waits. */
#include "layer/postmortem/postmortem.h"

#include "layer/execution/submitted_builds.h"
#include "src/report/message.h"
#include "src/report/words.h"

enum { RANKS = 7 };

struct list {
    const struct layer_device *device;
    bool waits;
    const struct pending_faults *faults; /* or NULL */
    struct words words;
    uint32_t rank, listed, count;
    uint32_t first_rank; /* of the first build */
    bool ranks_differ;
    bool may_run; /* a build may have been running */
};

/* ---- what leads to the culprit */

static bool is_hit(const struct list *list, uint64_t address, uint64_t size)
{
    for (uint32_t i = 0; i < FAULTS_MAX; i++)
        if (address < list->faults->ranges[i].end && list->faults->ranges[i].begin < address + size)
            return true;
    return false;
}

static bool is_hit_structure(const struct list *list, const struct submitted_build *build,
                             uint64_t handle)
{
    struct resource_span span;
    for (uint32_t i = 0; handle && i < FAULTS_MAX; i++)
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
    if (!list->faults)
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

static void append_structure(const struct list *list, const struct journal_entry *entry)
{
    const VkObjectType type = entry->command == COMMAND_NV
                                  ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                  : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    struct resource_span span;
    words_say(&list->words, "{} of {}", phrase(journal_is_update(entry) ? "update" : "build"),
              object(type, entry->dst));
    if (resources_find_span(list->device->resources, type, entry->dst, list->waits, &span))
        words_say(&list->words, " ({})", count_of(span.size, "byte"));
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
    struct call_origin origin =
        layer_origin_of(list->device, build->submission, build->journal, 0, entry->origin);
    const struct words *words = &list->words;
    if (build->primary != build->journal->command_buffer)
        origin.executed_by = build->primary;
    words_say(words, "\n{}. ", number(list->listed));
    append_structure(list, entry);
    words_say(words, " from {}, {}", count_of(entry->built.geometry_count, "geometry"),
              object(VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(build->journal->command_buffer)));
    message_append_place(words, &origin, entry->built.position, false);
    text_append(words->text, words_of(build));
    if (has_findings(build))
        text_append(words->text, "; there are findings about its inputs");
    if (has_fault(list, build))
        text_append(words->text, "; a faulting address lies in its inputs or structures");
    text_append(words->text, ".");
    if (origin.call_site)
        message_append_call_site(words->text, origin.call_site,
                                 1); /* the list is to fit into a message */
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
    struct list list = {.device = device, .waits = waits, .faults = faults};
    list.words = (struct words){.text = text, .names = device->names, .is_in_handler = !waits};
    if (!submitted || !submitted_builds_each(submitted, waits, count_build, &list) || !list.count)
        return 0;
    words_say(&list.words, "{} {} submitted to {} and may not be complete",
              count_of(list.count, "build"), phrase(list.count == 1 ? "was" : "were"),
              object(VK_OBJECT_TYPE_DEVICE, handle_number(device->handle)));
    if (!list.may_run)
        text_append(text, list.count == 1 ? ", but was not running" : ", but none was running");
    text_append(text, list.count == 1     ? ":"
                      : list.ranks_differ ? ", the likeliest culprit first:"
                                          : ", in the order in which they were submitted:");
    for (; list.rank < RANKS; list.rank++)
        submitted_builds_each(submitted, waits, list_build, &list);
    if (list.listed < list.count)
        words_say(&list.words, "\nand {} more.", number(list.count - list.listed));
    return list.count;
}
