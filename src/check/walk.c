/* SPDX-License-Identifier: Apache-2.0 */
/* The rows, subject by subject, as code: rules.def is included once a subject. */
#include "check/walk.h"

#include "check/predicates.h"

static void hand_on(struct walk *walk, enum rule rule, const struct location *location,
                    const struct finding *finding)
{
    struct check_context *context = walk->context;
    walk->findings++;
    if (!context->found(context->user, rule, location, finding))
        walk->wants[rule] = false;
}

/* Asks one predicate, if its row is of the level and wanted. */
#define ASK(name, row_level, view)                                                                 \
    if (LEVEL_##row_level == level && walk->wants[RULE_##name] && !name(view, &finding))           \
        hand_on(walk, RULE_##name, &location, &finding);

#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

#define ASK_call(name, level) ASK(name, level, call)
#define ASK_build(name, level)
#define ASK_geometry(name, level)
#define ASK_range(name, level)
#define ASK_pair(name, level)
#define ASK_update(name, level)
#define ASK_updated_geometry(name, level)

void walk_call(struct walk *walk, const struct call_view *call, enum level level)
{
    const struct location location = {.command = call->command, .subject = SUBJECT_CALL};
    struct finding finding;
#include "rules.def"
}

#undef ASK_call
#define ASK_call(name, level)
#undef ASK_build
#define ASK_build(name, level) ASK(name, level, build)
#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

void walk_build(struct walk *walk, const struct build_view *build, enum level level)
{
    const struct location location = {
        .command = build->call->command, .subject = SUBJECT_BUILD, .build = build->index};
    struct finding finding;
#include "rules.def"
}

static struct location location_of(const struct geometry_view *geometry, enum subject subject)
{
    return (struct location){.command = geometry->build->call->command,
                             .subject = subject,
                             .build = geometry->build->index,
                             .geometry = geometry->index,
                             .geometry_by_pointer = geometry->build->geometry_pointers != NULL};
}

#undef ASK_build
#define ASK_build(name, level)
#undef ASK_geometry
#define ASK_geometry(name, level) ASK(name, level, geometry)
#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

void walk_geometry(struct walk *walk, const struct geometry_view *geometry, enum level level)
{
    const struct location location = location_of(geometry, SUBJECT_GEOMETRY);
    struct finding finding;
#include "rules.def"
}

#undef ASK_geometry
#define ASK_geometry(name, level)
#undef ASK_range
#define ASK_range(name, level) ASK(name, level, range)
#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

void walk_range(struct walk *walk, const struct range_view *range, enum level level)
{
    const struct location location = location_of(range->geometry, SUBJECT_RANGE);
    struct finding finding;
#include "rules.def"
}

/* Pairs are met once, whatever their rows' levels. */
#undef ASK_range
#define ASK_range(name, level)
#undef ASK_pair
#define ASK_pair(name, row_level)                                                                  \
    if (walk->wants[RULE_##name] && !name(pair, &finding))                                         \
        hand_on(walk, RULE_##name, &location, &finding);
#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

void walk_pair(struct walk *walk, const struct pair_view *pair)
{
    const struct location location = {
        .command = pair->call->command, .subject = SUBJECT_BUILD, .build = pair->a.build};
    struct finding finding;
#include "rules.def"
}

/* Updates are judged once, where their source is known. */
#define ASK_HERE(name, view)                                                                       \
    if (walk->wants[RULE_##name] && !name(view, &finding))                                         \
        hand_on(walk, RULE_##name, location, &finding);

#undef ASK_pair
#define ASK_pair(name, level)
#undef ASK_update
#define ASK_update(name, level) ASK_HERE(name, update)
#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

void walk_update(struct walk *walk, const struct update_view *update,
                 const struct location *location)
{
    struct finding finding;
#include "rules.def"
}

#undef ASK_update
#define ASK_update(name, level)
#undef ASK_updated_geometry
#define ASK_updated_geometry(name, level) ASK_HERE(name, updated_geometry)
#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

void walk_updated_geometry(struct walk *walk, const struct updated_geometry_view *updated_geometry,
                           const struct location *location)
{
    struct finding finding;
#include "rules.def"
}
