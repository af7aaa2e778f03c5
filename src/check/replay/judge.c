/* SPDX-License-Identifier: Apache-2.0 */
/* Locates builds of a replay and reports all of its findings. */
#include "src/check/replay/judge.h"

static bool report(void *user, enum rule rule, const struct location *location,
                   const struct finding *finding)
{
    const struct judge *judge = user;
    struct replay *replay = judge->replay;
    return replay->found(replay->user, judge->journal, judge->first_build, rule, location, finding);
}

static const struct check_hooks hooks = {.found = report};

void judge_begin(struct judge *judge, struct replay *replay, const struct journal *journal,
                 uint32_t position, const struct location *location)
{
    judge->replay = replay;
    judge->journal = journal;
    judge->first_build = position - location->build;
    judge->location = *location;
    judge->context = (struct check_context){.hooks = &hooks,
                                            .user = judge,
                                            .level = LEVEL_EXECUTION,
                                            .active = replay->active[location->command]};
    walk_start(&judge->walk, &judge->context);
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

void judge_report(struct judge *judge, enum rule rule, const struct finding *finding)
{
    enum rule other = finding->reported_with;
    bool is_named = other != RULE_COUNT && judge->context.active[other];
    if (judge->walk.active[rule] && !is_named)
        report(judge, rule, &judge->location, finding);
}
