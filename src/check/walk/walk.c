/* SPDX-License-Identifier: Apache-2.0 */
/* The rows, subject by subject, as code: rules.def is included once a subject. */
#include "src/check/walk/walk.h"

#include <string.h>

#include "rows_by_subject.h"
#include "src/rules/predicates.h"

void check_select(enum build_command command, enum level level, const bool muted[MESSAGE_ID_COUNT],
                  bool active[RULE_COUNT])
{
    for (int rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *info = &rule_infos[rule];
        enum vuid vuid = info->vuid[command];
        active[rule] = info->subject && info->level <= level && vuid != VUID_NONE && !muted[vuid];
    }
}

void walk_start(struct walk *walk, struct check_context *context)
{
    walk->context = context;
    walk->findings = 0;
    walk->hides_sizes = false;
    walk->micromaps = (struct micromap_uses){0};
    walk->instances = NULL;
    walk->inputs = NULL;
    walk->point = context->point;
    walk->wants = context->active;
}

void walk_stop_rule(struct walk *walk, enum rule rule)
{
    if (walk->wants != walk->fewer)
        memcpy(walk->fewer, walk->wants, sizeof(walk->fewer));
    walk->wants = walk->fewer;
    walk->fewer[rule] = false;
}

void walk_report(struct walk *walk, enum rule rule, const struct location *location,
                 const struct finding *finding)
{
    struct check_context *context = walk->context;
    walk->findings++;
    walk->hides_sizes |= rule_infos[rule].is_of_sizes;
    if (!context->hooks->found(context->user, rule, location, finding))
        walk_stop_rule(walk, rule);
}

__attribute__((cold)) static void report(struct walk *walk, enum rule rule,
                                         struct location location, const struct finding *finding)
{
    walk_report(walk, rule, &location, finding);
}

/* Asks one predicate, if its row is of the level and wanted. `location` is made of a finding only.
 */
#define ASK(name, row_level, view, location)                                                       \
    if (LEVEL_##row_level == level && walk->wants[RULE_##name] && !name(view, &finding))           \
        report(walk, RULE_##name, location, &finding);

/* Defines a walk of the rows of a subject, which are those that ASK_subject asks, once for each of
 * the two levels: the compiler leaves out the rows of the other. */
#define WALK(subject)                                                                              \
    void walk_##subject(struct walk *walk, const struct subject##_view *subject, enum level level) \
    {                                                                                              \
        if (level == LEVEL_PARAMETERS)                                                             \
            ask_##subject(walk, subject, LEVEL_PARAMETERS);                                        \
        else                                                                                       \
            ask_##subject(walk, subject, LEVEL_STATE);                                             \
    }
#define ASK_ROWS static inline __attribute__((always_inline)) void

static struct location location_of_call(const struct call_view *call)
{
    return (struct location){.command = call->command, .subject = SUBJECT_CALL};
}

#define ASK_CALL(name, level) ASK(name, level, call, location_of_call(call))

ASK_ROWS ask_call(struct walk *walk, const struct call_view *call, enum level level)
{
    struct finding finding;
    ROWS_OF_call(ASK_CALL);
}
WALK(call)

static struct location location_of_build(const struct build_view *build)
{
    return (struct location){
        .command = build->call->command, .subject = SUBJECT_BUILD, .build = build->index};
}

#define ASK_BUILD(name, level) ASK(name, level, build, location_of_build(build))

ASK_ROWS ask_build(struct walk *walk, const struct build_view *build, enum level level)
{
    struct finding finding;
    ROWS_OF_build(ASK_BUILD);
}
WALK(build)

struct location walk_location(const struct geometry_view *geometry, enum subject subject)
{
    return (struct location){.command = geometry->build->call->command,
                             .subject = subject,
                             .build = geometry->build->index,
                             .geometry = geometry->index,
                             .geometry_by_pointer = geometry->build->geometry_pointers != NULL};
}

#define ASK_GEOMETRY(name, level)                                                                  \
    ASK(name, level, geometry, walk_location(geometry, SUBJECT_GEOMETRY))

ASK_ROWS ask_geometry(struct walk *walk, const struct geometry_view *geometry, enum level level)
{
    struct finding finding;
    ROWS_OF_geometry(ASK_GEOMETRY);
}
WALK(geometry)

#define ASK_RANGE(name, level)                                                                     \
    ASK(name, level, range, walk_location(range->geometry, SUBJECT_RANGE))

ASK_ROWS ask_range(struct walk *walk, const struct range_view *range, enum level level)
{
    struct finding finding;
    ROWS_OF_range(ASK_RANGE);
}
WALK(range)

static struct location location_of_element(const struct build_view *build)
{
    return (struct location){
        .command = COMMAND_INDIRECT, .subject = SUBJECT_ELEMENT, .build = build->index};
}

static struct location location_of_address(const struct address_view *address)
{
    if (address->geometry)
        return walk_location(address->geometry, SUBJECT_GEOMETRY);
    return address->role == INPUT_INDIRECT ? location_of_element(address->build)
                                           : location_of_build(address->build);
}

#define ASK_ADDRESS(name, level) ASK(name, level, address, location_of_address(address))

ASK_ROWS ask_address(struct walk *walk, const struct address_view *address, enum level level)
{
    struct finding finding;
    ROWS_OF_address(ASK_ADDRESS);
}
WALK(address)

#define ASK_INDIRECT(name, level) ASK(name, level, indirect, location_of_element(indirect->build))

ASK_ROWS ask_indirect(struct walk *walk, const struct indirect_view *indirect, enum level level)
{
    struct finding finding;
    ROWS_OF_indirect(ASK_INDIRECT);
}
WALK(indirect)

/* Pairs are met once, whatever their rows' levels. */
#define ASK_PAIR(name, row_level)                                                                  \
    if (walk->wants[RULE_##name] && !name(pair, &finding))                                         \
        walk_report(walk, RULE_##name, &location, &finding);

void walk_pair(struct walk *walk, const struct pair_view *pair)
{
    const struct location location = {
        .command = pair->call->command, .subject = SUBJECT_BUILD, .build = pair->a.build};
    struct finding finding;
    ROWS_OF_pair(ASK_PAIR);
}

/* What extensions add to builds and geometries. */

#define ASK_MOTION_BUILD(name, level)                                                              \
    ASK(name, level, motion_build, location_of_build(motion_build->build))

ASK_ROWS ask_motion_build(struct walk *walk, const struct motion_build_view *motion_build,
                          enum level level)
{
    struct finding finding;
    ROWS_OF_motion_build(ASK_MOTION_BUILD);
}
WALK(motion_build)

#define ASK_MOTION_TRIANGLES(name, level)                                                          \
    ASK(name, level, motion_triangles, walk_location(motion_triangles->geometry, SUBJECT_GEOMETRY))

ASK_ROWS ask_motion_triangles(struct walk *walk,
                              const struct motion_triangles_view *motion_triangles,
                              enum level level)
{
    struct finding finding;
    ROWS_OF_motion_triangles(ASK_MOTION_TRIANGLES);
}
WALK(motion_triangles)

#define ASK_SPHERES(name, level)                                                                   \
    ASK(name, level, spheres, walk_location(spheres->data.geometry, SUBJECT_GEOMETRY))

ASK_ROWS ask_spheres(struct walk *walk, const struct spheres_view *spheres, enum level level)
{
    struct finding finding;
    ROWS_OF_spheres(ASK_SPHERES);
}
WALK(spheres)

#define ASK_SWEPT_SPHERES(name, level)                                                             \
    ASK(name, level, swept_spheres, walk_location(swept_spheres->data.geometry, SUBJECT_GEOMETRY))

ASK_ROWS ask_swept_spheres(struct walk *walk, const struct swept_spheres_view *swept_spheres,
                           enum level level)
{
    struct finding finding;
    ROWS_OF_swept_spheres(ASK_SWEPT_SPHERES);
}
WALK(swept_spheres)

#define ASK_DENSE_BUILD(name, level)                                                               \
    ASK(name, level, dense_build, location_of_build(dense_build->build))

ASK_ROWS ask_dense_build(struct walk *walk, const struct dense_build_view *dense_build,
                         enum level level)
{
    struct finding finding;
    ROWS_OF_dense_build(ASK_DENSE_BUILD);
}
WALK(dense_build)

#define ASK_DENSE(name, level)                                                                     \
    ASK(name, level, dense, walk_location(dense->geometry, SUBJECT_GEOMETRY))

ASK_ROWS ask_dense(struct walk *walk, const struct dense_view *dense, enum level level)
{
    struct finding finding;
    ROWS_OF_dense(ASK_DENSE);
}
WALK(dense)

/* Updates are judged once, where their source is known. */
#define ASK_HERE(name, view)                                                                       \
    if (walk->wants[RULE_##name] && !name(view, &finding))                                         \
        walk_report(walk, RULE_##name, location, &finding);

#define ASK_UPDATE(name, level) ASK_HERE(name, update)

void walk_update(struct walk *walk, const struct update_view *update,
                 const struct location *location)
{
    struct finding finding;
    ROWS_OF_update(ASK_UPDATE);
}

#define ASK_UPDATED_GEOMETRY(name, level) ASK_HERE(name, updated_geometry)

void walk_updated_geometry(struct walk *walk, const struct updated_geometry_view *updated_geometry,
                           const struct location *location)
{
    struct finding finding;
    ROWS_OF_updated_geometry(ASK_UPDATED_GEOMETRY);
}

#define ASK_UPDATED_DENSE(name, level) ASK_HERE(name, updated_dense)

void walk_updated_dense(struct walk *walk, const struct updated_dense_view *updated_dense,
                        const struct location *location)
{
    struct finding finding;
    ROWS_OF_updated_dense(ASK_UPDATED_DENSE);
}
