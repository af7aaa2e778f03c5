/* SPDX-License-Identifier: Apache-2.0 */
/* Validates builds that have executed: makes views from the recorded builds and evaluates the rules
 * about their input data. */
#include "src/check/content/executed.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/check/assemble/views.h"
#include "src/check/content/clusters.h"
#include "src/check/content/micromap.h"
#include "src/check/content/unbuilt.h"
#include "src/check/life/life.h"
#include "src/check/overlap/pairs.h"
#include "src/check/walk/rows.h"
#include "src/view/micromap_view.h"

/* A build whose dst an instance of another build may refer to. */
struct retained_build {
    const struct recorded_build *build;
    uint64_t dst_id;
};

/* Serialized data that were read. */
struct retained_data {
    const struct deserialization *deserialization;
    void *bytes; /* owned */
    uint64_t size;
};

struct executed_call {
    struct walk walk;
    struct call_view view;
    struct sweep *sweep; /* of referenced structures; NULL: none, or no memory */
    struct retained_build *builds;
    uint32_t count, capacity;
    struct unbuilt_uses unbuilt;
    struct retained_data data; /* of a deserialization */
};

struct executed_call *executed_call_begin(struct check_context *context,
                                          const struct device_facts *device,
                                          enum build_command command)
{
    struct executed_call *call = calloc(1, sizeof(*call));
    if (!call)
        return NULL;
    walk_start(&call->walk, context);
    call->view = (struct call_view){.command = command, .device = device};
    return call;
}

/* ---- one build */

static struct build_view view_of(const struct executed_call *call,
                                 const struct recorded_build *recorded,
                                 const VkAccelerationStructureBuildRangeInfoKHR *ranges)
{
    const struct build_parameters *given = recorded_build_given(recorded);
    return (struct build_view){.call = &call->view,
                               .index = recorded->place.info,
                               .info = &given->info,
                               .geometries = given->geometries,
                               .geometry_count = given->info.geometryCount,
                               .ranges = ranges};
}

/* Returns NULL if unknown. */
static const struct built *find_used(const struct executed_build *executed, uint32_t geometry)
{
    for (uint32_t i = 0; i < executed->used_count; i++)
        if (executed->used[i].geometry == geometry)
            return &executed->used[i].built;
    return NULL;
}

/* `range` is the build range that the build read. */
static void read_geometry(struct executed_call *call, const struct executed_build *executed,
                          const struct geometry_view *geometry,
                          const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    static const struct chained_input none;
    const uint32_t index = geometry->index;
    const struct chained_input *given = recorded_build_given(executed->build)->chained;
    const struct chained_input *micromaps = executed->build->parameters.chained;
    const struct range_view ranged = {
        .geometry = geometry, .range = range, .primitive_count = range->primitiveCount};
    content_check_geometry(&call->walk, &ranged, &executed->memory, given ? &given[index] : &none);
    if (micromaps)
        content_check_micromaps(&call->walk, &ranged, &executed->memory, &micromaps[index],
                                find_used(executed, index));
}

static void read_direct(struct executed_call *call, const struct executed_build *executed)
{
    const struct build_parameters *given = recorded_build_given(executed->build);
    const struct build_view build = view_of(call, executed->build, given->ranges);
    for (uint32_t i = 0; i < build.geometry_count; i++) {
        const struct geometry_view geometry = {
            .build = &build, .index = i, .geometry = &build.geometries[i]};
        read_geometry(call, executed, &geometry, &given->ranges[i]);
    }
}

/* ---- indirect builds */

static WALK_ALL(indirect_range)

    /* Evaluates the rule about a micromap that is used without indices: it needs the primitive
     * count. */
    static void check_unindexed_opacity(struct walk *walk, const struct range_view *range,
                                        const struct chained_input *chained,
                                        const struct built *used)
{
    const VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity = &chained->opacity;
    const struct journal_micromap use = {.first = opacity->baseTriangle,
                                         .triangle_count = range->range->primitiveCount,
                                         .is_unindexed = true};
    const struct used_micromap_view view = {.command = COMMAND_INDIRECT,
                                            .handle = (uint64_t)opacity->micromap,
                                            .use = &use,
                                            .built = used};
    const struct location location = walk_location(range->geometry, SUBJECT_GEOMETRY);
    struct finding finding;
    if (!used ||
        opacity->sType != VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR ||
        opacity->indexType != VK_INDEX_TYPE_NONE_KHR)
        return;
    EVALUATE(opacity_triangles_are_within_micromap, EXECUTION, &view, location);
}

/* Evaluates the rules about the build range, and reads the data up to the maximum count. */
static void read_indirect_geometry(struct executed_call *call,
                                   const struct executed_build *executed, struct build_view *build,
                                   uint32_t index)
{
    const uint32_t max_count = build->ranges[index].primitiveCount;
    const struct chained_input *chained = executed->build->parameters.chained;
    const struct geometry_view geometry = {
        .build = build, .index = index, .geometry = &build->geometries[index]};
    VkAccelerationStructureBuildRangeInfoKHR range;
    if (!recorded_build_read_range(executed->build, &executed->memory, index, &range))
        return;
    const struct range_view ranged = {
        .geometry = &geometry, .range = &range, .primitive_count = range.primitiveCount};
    const struct indirect_range_view indirect = {
        .geometry = &geometry, .range = &range, .max_primitive_count = max_count};
    walk_range(&call->walk, &ranged, LEVEL_PARAMETERS);
    const struct location location = walk_location(indirect.geometry, SUBJECT_RANGE);
    walk_indirect_range(&call->walk, &indirect, &location);
    if (type_is_triangles(geometry.geometry->geometryType))
        build->triangle_count += range.primitiveCount;
    if (type_is_aabbs(geometry.geometry->geometryType))
        build->aabb_count += range.primitiveCount;
    if (range.primitiveCount > max_count)
        range.primitiveCount = max_count;
    if (chained)
        check_unindexed_opacity(&call->walk, &ranged, &chained[index], find_used(executed, index));
    read_geometry(call, executed, &geometry, &range);
}

/* Evaluates the rules about builds that need the sums of counts. */
static void check_sums(struct walk *walk, const struct build_view *build)
{
    const struct location location = {
        .command = build->call->command, .subject = SUBJECT_BUILD, .build = build->index};
    struct finding finding;
    EVALUATE(blas_triangle_count_is_within_limit, STATE, build, location);
    EVALUATE(blas_aabb_count_is_within_limit, STATE, build, location);
}

static void read_indirect(struct executed_call *call, const struct executed_build *executed)
{
    const struct build_parameters *given = recorded_build_given(executed->build);
    struct build_view build = view_of(call, executed->build, given->ranges);
    for (uint32_t i = 0; i < build.geometry_count; i++)
        read_indirect_geometry(call, executed, &build, i);
    check_sums(&call->walk, &build);
}

/* ---- instances of other builds */

static void retain_build(struct executed_call *call, const struct executed_build *executed)
{
    if (ARRAY_HAS_ROOM(call->builds, call->count, call->capacity))
        call->builds[call->count++] = (struct retained_build){executed->build, executed->dst_id};
}

static void report_references(const struct executed_call *call,
                              const struct recorded_build *recorded,
                              const struct instance_uses *uses)
{
    const struct check_context *context = call->walk.context;
    for (uint32_t i = 0; context->hooks->on_reference && i < uses->count; i++)
        context->hooks->on_reference(context->user, recorded->place.position,
                                     &uses->items[i].referenced);
    if (context->hooks->on_instances)
        context->hooks->on_instances(context->user, recorded->place.position, uses);
}

static void collect_instances(struct executed_call *call, const struct recorded_build *recorded)
{
    const struct check_context *context = call->walk.context;
    struct instance_uses *uses = call->walk.instances;
    struct build_view build = view_of(call, recorded, NULL);
    if (context->hooks->on_all_references && call->walk.references_are_known)
        context->hooks->on_all_references(context->user, uses);
    if (!uses || !uses->count)
        return;
    report_references(call, recorded, uses);
    unbuilt_uses_add(&call->unbuilt, &call->walk, &build, uses);
    if (!call->sweep)
        call->sweep = check_make_sweep();
    if (call->sweep)
        pairs_collect_instances(call->sweep, &build, uses);
    content_forget_instances(uses);
}

/* Skips the structure if it has been destroyed since. */
static void collect_dst(struct executed_call *call, const struct retained_build *retained)
{
    struct check_context *context = call->walk.context;
    const struct build_parameters *given = recorded_build_given(retained->build);
    struct build_view build = view_of(call, retained->build, given->ranges);
    resources_look_up_accel(context->resources, given->info.dstAccelerationStructure, &build.dst);
    if (build.dst.alive != YES || build.dst.id != retained->dst_id)
        return;
    view_build_state(context, &build);
    if (!given->had_chains)
        view_build_sizes(context, &build, false);
    pairs_collect_dst(call->sweep, &build);
}

static void walk_pairs(struct executed_call *call)
{
    struct walk *walk = &call->walk;
    for (uint32_t i = 0; i < call->count; i++)
        collect_dst(call, &call->builds[i]);
    /* The other rules were evaluated when the call was recorded. */
    for (int rule = 0; rule < RULE_COUNT; rule++)
        if (rule_infos[rule].level != LEVEL_CONTENT)
            walk_stop_rule(walk, (enum rule)rule);
    pairs_walk(walk, &call->view, call->sweep);
}

/* ---- the call */

/* A build by VK_EXT_opacity_micromap. */
static void read_micromap(struct executed_call *call, const struct executed_build *executed)
{
    const struct micromap_parameters *micromap = &executed->build->parameters.chained[0].micromap;
    const uint64_t size = micromap_parameters_extent(micromap);
    struct micromap_triangles_view view = {.call = &call->view,
                                           .type = micromap->type,
                                           .count = micromap_parameters_count(micromap),
                                           .stride = micromap->stride};
    const struct location location =
        check_element(&call->view, "pInfos", executed->build->place.info);
    const void *triangles;
    if (!size || executed->memory.find(executed->memory.context, micromap->triangles.deviceAddress,
                                       size, &triangles) != size)
        return;
    view.first = triangles;
    walk_micromap_triangles(&call->walk, &view, &location);
}

/* Whether the version is compatible is queried at the end, without locks. */
static void retain_data(struct executed_call *call, const struct executed_build *executed)
{
    const struct recorded_build *build = executed->build;
    const void *bytes;
    if (!build->snapshot_count)
        return;
    const uint64_t size =
        executed->memory.find(executed->memory.context, build->deserialization->address,
                              build->snapshots[0].size, &bytes);
    void *copy = malloc(size ? size : 1);
    if (copy && size)
        memcpy(copy, bytes, size);
    call->data = (struct retained_data){build->deserialization, copy, copy ? size : 0};
}

void executed_call_read(struct executed_call *call, const struct executed_build *build)
{
    if (build->build->deserialization) {
        retain_data(call, build);
        return;
    }
    if (build->build->addressed) {
        content_check_addressed(&call->walk, &call->view,
                                &(struct addressed_read){build->build->addressed, &build->memory,
                                                         build->place, build->number});
        return;
    }
    if (call->view.command == COMMAND_CmdBuildMicromapsEXT) {
        read_micromap(call, build);
        return;
    }
    call->walk.inputs = build->inputs;
    call->walk.source_inputs = build->source_inputs;
    call->walk.point = build->point;
    call->walk.references_are_known = false;
    call->walk.readers = build->readers;
    if (build->build->is_indirect)
        read_indirect(call, build);
    else
        read_direct(call, build);
    call->walk.readers = NULL;
    build_inputs_mark_known(build->inputs);
    call->walk.inputs = NULL;
    call->walk.source_inputs = NULL;
    collect_instances(call, build->build);
    call->walk.point = NULL;
    retain_build(call, build);
}

static bool has_instances(const struct executed_call *call)
{
    return call->sweep && call->count > 1;
}

bool executed_call_ends_unlocked(const struct executed_call *call)
{
    return has_instances(call) || call->data.size;
}

static bool is_built(void *context, uint64_t id)
{
    const struct executed_call *call = context;
    for (uint32_t i = 0; i < call->count; i++)
        if (call->builds[i].dst_id == id)
            return true;
    return false;
}

void executed_call_end(struct executed_call *call)
{
    unbuilt_uses_check(&call->unbuilt, &call->walk, &call->view, is_built, call);
    if (has_instances(call))
        walk_pairs(call);
    if (call->data.size)
        check_read_serialized(&call->walk, &call->view, call->data.deserialization,
                              call->data.bytes, call->data.size);
    free(call->data.bytes);
    check_free_sweep(call->sweep);
    content_free_instances(call->walk.instances);
    free(call->builds);
    free(call);
}
