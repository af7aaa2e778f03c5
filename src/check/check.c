/* SPDX-License-Identifier: Apache-2.0 */
/* The order in which a build call is checked: the call, then each build with its geometries, first
 * by its parameters and, where those are sound, by the state, then all builds against each other.
 */
#include "check/check.h"

#include <stdlib.h>
#include <string.h>

#include "check/extensions.h"
#include "check/indirect.h"
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

static void see_inputs(struct check_context *context, const struct geometry_view *geometry)
{
    const struct build_view *build = geometry->build;
    VkGeometryTypeKHR type = geometry->geometry->geometryType;
    enum input_role data_role = type == VK_GEOMETRY_TYPE_AABBS_KHR ? INPUT_AABBS : INPUT_INSTANCES;
    context->see_input(context->user, build, geometry->index, INPUT_VERTEX, &geometry->vertex);
    context->see_input(context->user, build, geometry->index, INPUT_INDEX, &geometry->index_data);
    context->see_input(context->user, build, geometry->index, INPUT_TRANSFORM,
                       &geometry->transform);
    context->see_input(context->user, build, geometry->index, data_role, &geometry->data);
    for (uint32_t i = 0; geometry->chained && i < geometry->chained->count; i++)
        context->see_input(context->user, build, geometry->index, geometry->chained->items[i].role,
                           &geometry->chained->items[i].facts);
}

/* One geometry of a build, at each level. */
static void check_geometry(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    const struct build_view *build = geometry->build;
    struct range_view range = {.geometry = geometry,
                               .range = build->ranges ? &build->ranges[geometry->index] : NULL};
    bool has_count = view_primitive_count(build, geometry->index, &range.primitive_count);
    struct chained_inputs chained;
    if (build->call->device->extension.adds_to_inputs)
        check_extended_geometry(walk, geometry, &chained, with_state);
    walk_geometry(walk, geometry, LEVEL_PARAMETERS);
    if (has_count)
        walk_range(walk, &range, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view_geometry_state(walk->context, geometry);
    walk_geometry(walk, geometry, LEVEL_STATE);
    if (has_count)
        walk_range(walk, &range, LEVEL_STATE);
    if (walk->context->see_input)
        see_inputs(walk->context, geometry);
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

static VkDeviceSize smaller_of(VkDeviceSize a, VkDeviceSize b)
{
    return a < b ? a : b;
}

/* The ranges of a call, and what takes them apart. */
struct collection {
    struct check_context *context;
    struct sweep *sweep;
    struct used_range range; /* the one being added */
};

static void add_piece(void *user, const struct memory_span *piece)
{
    struct collection *collection = user;
    collection->range.span = *piece;
    sweep_add(collection->sweep, &collection->range);
}

/* Adds `size` bytes at the beginning of `span`; of a sparse buffer, the pieces that they lie in. */
static inline void add_range(struct collection *collection, const struct memory_span *span,
                             VkDeviceSize size, bool in_pieces, VkBuffer buffer,
                             VkDeviceSize offset)
{
    if (in_pieces) {
        resources_find_pieces(collection->context->resources, buffer, offset, offset + size,
                              add_piece, collection);
        return;
    }
    struct memory_span accessed = *span;
    accessed.end = smaller_of(accessed.end, accessed.begin + size);
    add_piece(collection, &accessed);
}

/* A build accesses no more of a structure than its size needs, whatever the structure was created
 * with; where that isn't known nothing is said of its bytes. Every structure is added, for its
 * handle, also where its memory isn't known. */
static void add_structure(struct collection *collection, const struct build_view *build,
                          const struct accel_facts *accel)
{
    VkDeviceSize size = 0;
    if (build->sizes.known)
        size = smaller_of(accel->size, build->sizes.acceleration_structure);
    collection->range.handle = accel->handle;
    if (accel->in_pieces) {
        struct memory_span nowhere = {0};
        add_piece(collection, &nowhere);
    }
    add_range(collection, &accel->span, size, accel->in_pieces, accel->buffer, accel->offset);
}

/* A build accesses no more of a micromap than that needs, and all of that begins where the micromap
 * does; how much it is isn't known. */
static void collect_micromaps(struct collection *collection, const struct micromap_uses *micromaps)
{
    collection->range.role = ROLE_SRC;
    collection->range.is_micromap = true;
    for (uint32_t i = 0; i < micromaps->count; i++) {
        const struct micromap_use *use = &micromaps->items[i];
        if (use->is_ext || !use->handle || (i && use->handle == use[-1].handle))
            continue;
        collection->range.handle = (VkAccelerationStructureKHR)(uintptr_t)use->handle;
        if (use->accel.in_pieces)
            add_piece(collection, &(struct memory_span){0});
        add_range(collection, &use->accel.span, 1, use->accel.in_pieces, use->accel.buffer,
                  use->accel.offset);
    }
}

static void collect_ranges(struct check_context *context, struct sweep *sweep,
                           const struct build_view *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    bool is_update = info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    struct collection collection = {.context = context,
                                    .sweep = sweep,
                                    .range = {.build = build->index, .is_update = is_update}};
    struct accel_facts named = {.handle = info->dstAccelerationStructure};
    collection.range.role = ROLE_DST;
    add_structure(&collection, build, context->level >= LEVEL_STATE ? &build->dst : &named);

    /* A build that is no update reads nothing of its source. */
    named.handle = info->srcAccelerationStructure;
    collection.range.role = ROLE_SRC;
    if (named.handle)
        add_structure(&collection, build,
                      is_update && context->level >= LEVEL_STATE ? &build->src : &named);

    if (build->micromaps)
        collect_micromaps(&collection, build->micromaps);

    const struct address_facts *scratch = &build->scratch;
    collection.range.role = ROLE_SCRATCH;
    collection.range.is_micromap = false;
    collection.range.handle = VK_NULL_HANDLE;
    if (build->sizes.known && scratch->status == ADDRESS_IN_BUFFER)
        add_range(&collection, &scratch->span,
                  is_update ? build->sizes.update_scratch : build->sizes.build_scratch,
                  scratch->in_pieces, scratch->buffer, scratch->buffer_offset);
}

static void check_build(struct walk *walk, struct sweep *sweep, struct build_view *build,
                        struct geometry_view *first)
{
    struct check_context *context = walk->context;
    bool with_state = context->level >= LEVEL_STATE;
    uint32_t findings_before = walk->findings;
    if (build->call->device->extension.adds_to_inputs)
        check_extended_build(walk, build, with_state);
    walk_build(walk, build, LEVEL_PARAMETERS);
    if (build->call->command == COMMAND_INDIRECT)
        check_indirect(walk, build, with_state);
    check_geometries(walk, build, first, with_state);
    if (build->call->device->micromap.any)
        build->micromaps = found_micromaps(walk);
    if (with_state) {
        /* The driver is asked for sizes of sound parameters only. */
        view_build_state(context, build, walk->findings == findings_before);
        walk_build(walk, build, LEVEL_STATE);
    }
    collect_ranges(context, sweep, build);
    if (context->see_build)
        context->see_build(context->user, build);
}

/* Checks `count` builds, VIEWS_MAX at most, from `begin` on. */
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
    for (uint32_t i = 0; i < count; i++)
        check_build(walk, sweep, &builds[i], &first_geometries[i]);
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
               wants[RULE_dst_and_update_src_are_apart] ||
               wants[RULE_no_dst_is_a_micromap_of_another_build] ||
               wants[RULE_dst_and_micromaps_of_other_builds_are_apart];
    if (a == ROLE_DST)
        return wants[RULE_dst_and_scratch_are_apart];
    if (a == ROLE_SRC)
        return b == ROLE_SCRATCH && wants[RULE_scratch_and_update_src_are_apart];
    return wants[RULE_scratch_and_scratch_are_apart];
}

struct pair_walk {
    struct walk *walk;
    const struct call_view *call;
};

static bool visit_pair(void *user, const struct used_range *a, const struct used_range *b,
                       const struct memory_span *shared)
{
    struct pair_walk *pairs = user;
    struct pair_view pair = {
        .call = pairs->call, .a = *a, .b = *b, .shares_memory = shared != NULL};
    if (shared)
        pair.shared = *shared;
    walk_pair(pairs->walk, &pair);
    return wants_pairs_of(pairs->walk, a->role, b->role);
}

void check_builds(struct check_context *context, struct call_view *call)
{
    struct walk walk;
    walk_start(&walk, context);
    view_call(context, call);
    walk_call(&walk, call, LEVEL_PARAMETERS);
    walk_call(&walk, call, LEVEL_STATE);
    if (!call->infos_readable)
        return;

    struct pair_walk pairs = {.walk = &walk, .call = call};
    struct sweep own, *sweep = context->sweep ? context->sweep : &own;
    if (sweep == &own)
        sweep_init(&own);
    else
        sweep_empty(sweep);
    for (uint32_t i = 0; i < call->info_count; i += VIEWS_MAX)
        check_some_builds(&walk, sweep, call, i,
                          call->info_count - i < VIEWS_MAX ? call->info_count - i : VIEWS_MAX);
    sweep_equal_handles(sweep, visit_pair, &pairs);
    if (context->level >= LEVEL_STATE)
        sweep_shared_memory(sweep, visit_pair, &pairs);
    if (sweep == &own)
        sweep_release(&own);
    free(walk.micromaps.items);
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
