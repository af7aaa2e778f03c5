/* SPDX-License-Identifier: Apache-2.0 */
/* Locates builds of a replay and reports all of its findings. */
#include "src/check/replay/judge.h"

static bool report(void *user, enum rule rule, const struct location *location,
                   const struct finding *finding)
{
    const struct judge *judge = user;
    struct replay *replay = judge->replay;
    uint32_t origin = location->subject == SUBJECT_ARGUMENT
                          ? judge->origin
                          : journal_origin_at(judge->journal, judge->first_build + location->build);
    return replay->found(replay->user, judge->journal, judge->first_build, origin, rule, location,
                         finding);
}

static const struct check_hooks hooks = {.found = report};

void judge_begin(struct judge *judge, struct replay *replay, const struct journal *journal,
                 uint32_t position, const struct location *location)
{
    judge->replay = replay;
    judge->journal = journal;
    judge->first_build = position - location->build;
    judge->origin = 0;
    judge->location = *location;
    judge->context = (struct check_context){.hooks = &hooks,
                                            .user = judge,
                                            .level = LEVEL_EXECUTION,
                                            .active = replay->active[location->command]};
    walk_start(&judge->walk, &judge->context);
}

static struct location location_of_read(const struct journal_entry *entry)
{
    struct location location = {
        .command = (enum build_command)entry->command,
        .subject = SUBJECT_ARGUMENT,
        .argument = entry->command == COMMAND_CmdCopyAccelerationStructureNV ? NULL : "pInfo",
    };
    if (entry->kind == JOURNAL_READ && entry->read.query != VK_QUERY_TYPE_MAX_ENUM) {
        location.argument =
            journal_entry_reads_micromap(entry) ? "pMicromaps" : "pAccelerationStructures";
        location.is_element = true;
        location.build = entry->info;
    }
    return location;
}

static struct location location_of(const struct journal_entry *entry)
{
    struct location location = {.command = (enum build_command)entry->command,
                                .subject = SUBJECT_BUILD,
                                .build = entry->info,
                                .geometry_by_pointer = entry->geometry_by_pointer};
    if (entry->kind == JOURNAL_USE_MICROMAP) {
        location.subject = SUBJECT_GEOMETRY;
        location.geometry = entry->micromap.geometry;
    } else if (entry->command == COMMAND_NV) {
        location.subject = SUBJECT_PARAMETER;
    }
    return location;
}

void judge_begin_entry(struct judge *judge, struct replay *replay, const struct journal *journal,
                       const struct journal_entry *entry)
{
    uint32_t position =
        entry->kind == JOURNAL_USE_MICROMAP ? entry->micromap.position : entry->built.position;
    const struct location location = location_of(entry);
    judge_begin(judge, replay, journal, position, &location);
}

void judge_begin_read(struct judge *judge, struct replay *replay, const struct journal *journal,
                      const struct journal_entry *entry)
{
    const struct location location = location_of_read(entry);
    judge_begin(judge, replay, journal, location.build, &location);
    judge->origin = entry->origin;
}

void judge_begin_query(struct judge *judge, struct replay *replay, const struct journal *journal,
                       const struct journal_entry *entry)
{
    const struct location location = {.command = (enum build_command)entry->command,
                                      .subject = SUBJECT_ARGUMENT};
    judge_begin(judge, replay, journal, 0, &location);
    judge->origin = entry->origin;
}

void judge_report(struct judge *judge, enum rule rule, const struct finding *finding)
{
    enum rule other = finding->reported_with;
    bool is_named = other != RULE_COUNT && judge->context.active[other];
    if (judge->walk.active[rule] && !is_named)
        report(judge, rule, &judge->location, finding);
}
