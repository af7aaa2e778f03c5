/* SPDX-License-Identifier: Apache-2.0 */
/* Validates a build call: first the call, then each build with its geometries, their parameters
 * before their state, then the pairs of all builds. State is validated only if the parameters are
 * well-formed. */
#include "src/check/call/check.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/float_environment.h"
#include "src/base/recording_path.h"
#include "src/check/assemble/views.h"
#include "src/check/call/parts.h"
#include "src/check/content/content.h"
#include "src/check/overlap/pairs.h"
#include "src/check/walk/fast_path.h"
#include "src/check/walk/walk.h"
#include "src/model/geometry.h"

/* Evaluates the rows of a geometry and, if its count is known, of its range. */
static void walk_geometry_and_range(struct walk *walk, const struct range_view *range,
                                    bool has_count, enum level level)
{
    walk_geometry(walk, range->geometry, level);
    if (has_count)
        walk_range(walk, range, level);
}

/* An input may go on in another buffer behind its own. */
static void find_continued_inputs(struct check_context *context, struct range_view *range)
{
    const struct geometry_view *geometry = range->geometry;
    for (enum input_role i = INPUT_VERTEX; i <= INPUT_AABBS; i++) {
        const enum input_role role = i == INPUT_AABBS ? data_role(geometry) : i;
        const struct address_facts *facts = input_facts(geometry, role);
        struct address_facts behind;
        if (facts->status != ADDRESS_IN_BUFFER)
            continue;
        resources_look_up_address(context->resources, facts->address + facts->bytes_left, &behind);
        if (behind.status != ADDRESS_NOWHERE)
            range->continued_inputs |= 1U << role;
    }
}

/* Evaluates the rows of both levels one by one. */
__attribute__((cold)) OFF_RECORDING_PATH static void
walk_all_of_geometry(struct walk *walk, struct range_view *range, bool has_count, bool with_state)
{
    walk->passes = false;
    walk_geometry_and_range(walk, range, has_count, LEVEL_PARAMETERS);
    if (range->geometry->build->call->command == COMMAND_HOST)
        check_host_geometry(walk, range);
    if (!with_state)
        return;
    if (walk->active[RULE_inputs_are_read_within_their_buffers])
        find_continued_inputs(walk->context, range);
    walk_geometry_and_range(walk, range, has_count, LEVEL_STATE);
    check_geometry_addresses(walk, range->geometry);
}

/* Returns whether the build recorder gets a geometry together with its build: only a single
 * geometry without chained inputs, which the next geometry replaces. */
static bool is_recorded_with_build(const struct build_view *build,
                                   const struct geometry_view *geometry)
{
    return build->geometry_count == 1 && !geometry->chained;
}

/* Validates one geometry of a build at every level. NOLINT because clang-tidy doesn't see that the
 * view has a geometry. */
ON_RECORDING_PATH __attribute__((flatten)) static void
check_geometry(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    const struct build_view *build = geometry->build; // NOLINT(clang-analyzer-core.*)
    struct range_view range = {.geometry = geometry,
                               .range = build->ranges ? &build->ranges[geometry->index] : NULL};
    bool has_count = view_primitive_count(build, geometry->index, &range.primitive_count);
    if (build->call->device->extension.adds_to_inputs)
        check_extended_geometry(walk, geometry, with_state);
    if (with_state)
        view_geometry_state(walk->context, geometry);
    if (!geometry_passes(&range, has_count, with_state))
        walk_all_of_geometry(walk, &range, has_count, with_state);
    if (!with_state)
        return;
    if (walk->context->recorder && !is_recorded_with_build(build, geometry))
        walk->context->recorder->record_geometry(walk->context->user, geometry);
    if (walk->context->level >= LEVEL_CONTENT && build->call->command == COMMAND_HOST)
        check_host_inputs(walk, &range);
}

__attribute__((cold)) static void
walk_all_of_build(struct walk *walk, const struct build_view *build, enum level level)
{
    walk_build(walk, build, level);
    if (level == LEVEL_STATE)
        check_scratch_address(walk, build);
}

__attribute__((cold)) static void walk_all_of_call(struct walk *walk, const struct call_view *call)
{
    walk_call(walk, call, LEVEL_PARAMETERS);
    walk_call(walk, call, LEVEL_STATE);
}

static void check_geometries(struct walk *walk, const struct build_view *build,
                             struct geometry_view *first, bool with_state)
{
    if (build->geometry_count)
        check_geometry(walk, first, with_state);
    for (uint32_t i = 1; i < build->geometry_count; i++) {
        struct geometry_view geometry;
        view_geometry(walk->context, build, i, &geometry);
        if (with_state)
            view_geometry_found(walk->context, &geometry);
        check_geometry(walk, &geometry, with_state);
    }
}

/* Evaluates the rules about one build alone. */
static void check_build(struct walk *walk, struct build_view *build, struct geometry_view *first)
{
    struct check_context *context = walk->context;
    bool with_state = context->level >= LEVEL_STATE;
    walk->hides_sizes = false;
    if (build->call->device->extension.adds_to_inputs)
        check_extended_build(walk, build, with_state);
    walk->passes = build_parameters_pass(build);
    if (!walk->passes)
        walk_all_of_build(walk, build, LEVEL_PARAMETERS);
    if (build->call->command == COMMAND_INDIRECT)
        check_indirect(walk, build, with_state);
    if (walk->instances)
        content_forget_instances(walk->instances);
    check_geometries(walk, build, first, with_state);
    if (build->call->device->micromap.any)
        build->micromaps = found_micromaps(walk);
    if (with_state) {
        view_build_state(context, build);
        if (!walk->hides_sizes)
            view_build_sizes(context, build, walk->passes);
        if (!build_state_passes(build))
            walk_all_of_build(walk, build, LEVEL_STATE);
        if (build->call->command == COMMAND_HOST)
            check_host_build(walk, build);
    }
}

/* Adds the ranges that a build uses to those of the call. A call of one build usually needs no
 * sweep. */
static void collect_ranges(const struct walk *walk, struct sweep *sweep,
                           const struct build_view *build)
{
    bool is_alone = build->call->info_count == 1 && !walk->instances;
    if (is_alone && pairs_has_none_within(walk->context, build))
        return;
    if (!sweep->is_initialized)
        sweep_init(sweep);
    pairs_collect(walk->context, sweep, build);
    if (walk->instances)
        pairs_collect_instances(sweep, build, walk->instances);
}

/* Adds a validated build to the pairs of the call and passes it to the build recorder. */
static void finish_build(struct walk *walk, struct sweep *sweep, struct build_view *build,
                         const struct geometry_view *first)
{
    struct check_context *context = walk->context;
    collect_ranges(walk, sweep, build);
    build->inputs = walk->inputs;
    build_inputs_mark_known(walk->inputs);
    if (context->recorder)
        context->recorder->record_build(context->user, build,
                                        is_recorded_with_build(build, first) ? first : NULL);
    if (walk->inputs)
        content_release_inputs(walk);
}

/* Validates `count` builds, VIEWS_MAX at most, beginning with build `begin`. */
static void check_some_builds(struct walk *walk, struct sweep *sweep, const struct call_view *call,
                              uint32_t begin, uint32_t count)
{
    struct check_context *context = walk->context;
    struct build_view builds[VIEWS_MAX];
    struct geometry_view first_geometries[VIEWS_MAX];
    for (uint32_t i = 0; i < count; i++) {
        view_build(context, call, begin + i, &builds[i]);
        if (builds[i].geometry_count)
            view_geometry(context, &builds[i], 0, &first_geometries[i]);
    }
    if (context->level >= LEVEL_STATE)
        view_builds_found(context, builds, first_geometries, count);
    for (uint32_t i = 0; i < count; i++) {
        check_build(walk, &builds[i], &first_geometries[i]);
        finish_build(walk, sweep, &builds[i], &first_geometries[i]);
    }
}

/* Validates all pairs of a call's builds. */
static void check_pairs(struct walk *walk, const struct call_view *call, struct sweep *sweep)
{
    const struct check_context *context = walk->context;
    pairs_walk(walk, call, sweep);
    if (sweep->noted_count && context->recorder)
        context->recorder->record_ranges(context->user, sweep_all_ranges(sweep));
}

void check_call(struct check_context *context, const struct call_view *call)
{
    struct walk walk;
    walk_start(&walk, context);
    walk_all_of_call(&walk, call);
}

__attribute__((always_inline)) static inline void check_all_builds(struct walk *walk,
                                                                   const struct call_view *call)
{
    struct check_context *context = walk->context;
    struct sweep own, *sweep = context->sweep ? context->sweep : &own;
    own.is_initialized = false;
    if (sweep != &own)
        sweep_empty(sweep);
    for (uint32_t i = 0; i < call->info_count; i += VIEWS_MAX)
        check_some_builds(walk, sweep, call, i,
                          call->info_count - i < VIEWS_MAX ? call->info_count - i : VIEWS_MAX);
    if (sweep->is_initialized)
        check_pairs(walk, call, sweep);
    if (own.is_initialized)
        sweep_release(&own);
    free(walk->micromaps.items);
    content_free_instances(walk->instances);
}

ON_RECORDING_PATH void check_builds(struct check_context *context, struct call_view *call)
{
    const bool reads_contents = context->level >= LEVEL_CONTENT && call->command == COMMAND_HOST;
    struct aligned_copies copies = {NULL};
    struct walk walk;
    fenv_t of_application;
    if (reads_contents)
        float_environment_enter(&of_application);
    walk_start(&walk, context);
    context->copies = &copies;
    view_call(context, call);
    if (!call_passes(call))
        walk_all_of_call(&walk, call);
    if (call->infos_readable && (call_is_aligned(call) || align_call(context, call)))
        check_all_builds(&walk, call);
    if (copies.first)
        aligned_copies_release(&copies);
    if (reads_contents)
        float_environment_leave(&of_application);
}

struct sweep *check_make_sweep(void)
{
    struct sweep *sweep = malloc(sizeof(*sweep));
    if (sweep)
        sweep_init(sweep);
    return sweep;
}

void check_free_sweep(struct sweep *sweep)
{
    if (!sweep)
        return;
    sweep_release(sweep);
    free(sweep);
}
