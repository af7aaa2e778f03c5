/* SPDX-License-Identifier: Apache-2.0 */
/* The order in which a build call is checked: the call, then each build with its geometries, first
 * by its parameters and, where those are sound, by the state, then all builds against each other. */
#include "check/check.h"

#include "check/sweep.h"
#include "check/views.h"
#include "check/walk.h"

void check_select(enum build_command command, enum level level, const bool muted[VUID_COUNT],
                  bool active[RULE_COUNT])
{
    for (int rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *info = &rule_infos[rule];
        enum vuid vuid = info->vuid[command];
        active[rule] = info->subject && info->level <= level && vuid != VUID_NONE && !muted[vuid];
    }
}

/* The geometries of a build at one level. */
static void check_geometry(struct walk *walk, const struct build_view *build, uint32_t index,
                           bool with_state)
{
    struct geometry_view geometry;
    view_geometry(walk->context, build, index, &geometry);
    struct range_view range = {.geometry = &geometry,
                               .range = build->ranges ? &build->ranges[index] : NULL};
    bool has_count = view_primitive_count(build, index, &range.primitive_count);
    walk_geometry(walk, &geometry, LEVEL_PARAMETERS);
    if (has_count)
        walk_range(walk, &range, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view_geometry_state(walk->context, &geometry);
    walk_geometry(walk, &geometry, LEVEL_STATE);
    if (has_count)
        walk_range(walk, &range, LEVEL_STATE);
}

static VkDeviceSize smaller_of(VkDeviceSize a, VkDeviceSize b)
{
    return a < b ? a : b;
}

/* A build accesses no more of a structure than its size needs, whatever the structure was created
 * with; the whole of it where that isn't known. */
static struct memory_span accessed(const struct build_view *build, const struct accel_facts *accel)
{
    struct memory_span span = accel->span;
    if (build->sizes.known)
        span.end = smaller_of(span.end, span.begin + build->sizes.acceleration_structure);
    return span;
}

static struct memory_span accessed_scratch(const struct build_view *build, bool is_update)
{
    VkDeviceSize needed = is_update ? build->sizes.update_scratch : build->sizes.build_scratch;
    struct memory_span span = build->scratch.span;
    if (!build->sizes.known || build->scratch.status != ADDRESS_IN_BUFFER)
        return (struct memory_span){0};
    span.end = smaller_of(span.end, span.begin + needed);
    return span;
}

static void collect_ranges(struct sweep *sweep, const struct build_view *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    bool is_update = info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    struct used_range range = {.build = build->index, .is_update = is_update};

    range.role = ROLE_DST;
    range.handle = info->dstAccelerationStructure;
    range.span = accessed(build, &build->dst);
    sweep_add(sweep, &range);

    if (info->srcAccelerationStructure) {
        range.role = ROLE_SRC;
        range.handle = info->srcAccelerationStructure;
        range.span = is_update ? accessed(build, &build->src) : (struct memory_span){0};
        sweep_add(sweep, &range);
    }

    range.role = ROLE_SCRATCH;
    range.handle = VK_NULL_HANDLE;
    range.span = accessed_scratch(build, is_update);
    if (range.span.memory)
        sweep_add(sweep, &range);
}

static void check_build(struct walk *walk, struct sweep *sweep, uint32_t index, bool with_state)
{
    struct build_view build;
    uint32_t findings_before = walk->findings;
    view_build(walk->context, walk->call, index, &build);
    walk_build(walk, &build, LEVEL_PARAMETERS);
    for (uint32_t i = 0; i < build.geometry_count; i++)
        check_geometry(walk, &build, i, with_state);
    if (with_state) {
        /* The driver is asked for sizes of sound parameters only. */
        view_build_state(walk->context, &build, walk->findings == findings_before);
        walk_build(walk, &build, LEVEL_STATE);
    }
    collect_ranges(sweep, &build);
}

/* Whether any rule about two ranges of these roles still wants findings. */
static bool wants_pairs_of(const struct walk *walk, enum range_role a, enum range_role b)
{
    const bool *wants = walk->wants;
    if (a == ROLE_DST && b == ROLE_DST)
        return wants[RULE_no_dst_is_built_twice] || wants[RULE_dst_and_dst_are_apart];
    if (a == ROLE_DST && b == ROLE_SRC)
        return wants[RULE_no_src_is_the_dst_of_another_build] ||
               wants[RULE_update_src_and_dst_do_not_alias] ||
               wants[RULE_dst_and_update_src_are_apart];
    if (a == ROLE_DST)
        return wants[RULE_dst_and_scratch_are_apart];
    if (a == ROLE_SRC)
        return b == ROLE_SCRATCH && wants[RULE_scratch_and_update_src_are_apart];
    return wants[RULE_scratch_and_scratch_are_apart];
}

static bool visit_pair(void *user, const struct used_range *a, const struct used_range *b,
                       const struct memory_span *shared)
{
    struct walk *walk = user;
    struct pair_view pair = {.call = walk->call, .a = *a, .b = *b, .shares_memory = shared != NULL};
    if (shared)
        pair.shared = *shared;
    walk_pair(walk, &pair);
    return wants_pairs_of(walk, a->role, b->role);
}

static void start_walk(struct walk *walk, struct check_context *context,
                       const struct call_view *call)
{
    walk->context = context;
    walk->call = call;
    walk->findings = 0;
    for (int rule = 0; rule < RULE_COUNT; rule++)
        walk->wants[rule] = context->active[rule];
}

void check_call(struct check_context *context, const struct call_view *call)
{
    struct walk walk;
    start_walk(&walk, context, call);
    walk_call(&walk, call, LEVEL_PARAMETERS);
    walk_call(&walk, call, LEVEL_STATE);
}

void check_builds(struct check_context *context, struct call_view *call)
{
    struct walk walk;
    struct sweep sweep;
    start_walk(&walk, context, call);
    view_call(context, call);
    walk_call(&walk, call, LEVEL_PARAMETERS);
    walk_call(&walk, call, LEVEL_STATE);
    if (!call->infos_readable)
        return;

    bool with_state = context->level >= LEVEL_STATE;
    sweep_init(&sweep);
    for (uint32_t i = 0; i < call->info_count; i++)
        check_build(&walk, &sweep, i, with_state);
    sweep_equal_handles(&sweep, visit_pair, &walk);
    if (with_state)
        sweep_shared_memory(&sweep, visit_pair, &walk);
    sweep_release(&sweep);
}
