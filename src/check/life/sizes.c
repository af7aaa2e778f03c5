/* SPDX-License-Identifier: Apache-2.0 */
/* Validates queries of the sizes of a build, and the build that they are about. */
#include <stdlib.h>

#include "arguments.h"
#include "src/check/assemble/views.h"
#include "src/check/call/parts.h"
#include "src/check/life/life.h"

static void check_geometry(struct walk *walk, const struct build_view *build, uint32_t index,
                           bool with_state)
{
    struct geometry_view geometry = {.index = index}; /* addresses are not looked up */
    view_geometry(walk->context, build, index, &geometry);
    if (build->call->device->extension.adds_to_inputs)
        check_extended_geometry(walk, &geometry, with_state);
    walk_geometry(walk, &geometry, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view_geometry_state(walk->context, &geometry);
    walk_geometry(walk, &geometry, LEVEL_STATE);
}

/* Only rules that this command has ids of are active: it ignores the mode, the structures and
 * nearly all addresses of a build. */
static void check_build(struct walk *walk, struct build_view *build)
{
    const bool with_state = walk->context->level >= LEVEL_STATE;
    if (build->call->device->extension.adds_to_inputs)
        check_extended_build(walk, build, with_state);
    walk_build(walk, build, LEVEL_PARAMETERS);
    for (uint32_t i = 0; i < build->geometry_count; i++)
        check_geometry(walk, build, i, with_state);
    if (with_state)
        walk_build(walk, build, LEVEL_STATE);
    free(walk->micromaps.items);
}

/* The build is viewed like one of a call that builds it. */
static void view_query(struct check_context *context, const struct size_query_view *query,
                       struct call_view *call, struct build_view *build)
{
    *call = *query->call;
    call->infos = query->info;
    call->info_count = 1;
    call->max_primitive_counts = &query->counts;
    call->infos_readable = call->max_primitive_counts_readable = true;
    view_sized_build(context, call, build);
}

void check_size_query(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetAccelerationStructureBuildSizesKHR *arguments = call->arguments;
    struct check_context *context = walk->context;
    const struct location location = check_argument(call, NULL);
    struct call_view call_of_build;
    struct build_view build = {.index = 0}; /* structures are not looked up */
    struct size_query_view query = {
        .call = call,
        .build_type = arguments->buildType,
        .counts_argument = arguments->pMaxPrimitiveCounts,
        .info = check_read(context, arguments->pBuildInfo, sizeof(*arguments->pBuildInfo))};
    if (!query.info)
        return;
    if (query.info->geometryCount)
        query.counts =
            check_read(context, arguments->pMaxPrimitiveCounts,
                       (size_t)query.info->geometryCount * sizeof(*arguments->pMaxPrimitiveCounts));
    view_query(context, &query, &call_of_build, &build);
    query.geometries = build.geometries;
    query.geometry_pointers = build.geometry_pointers;
    walk_size_query(walk, &query, &location);
    check_build(walk, &build);
}
