/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of builds of micromaps of VK_EXT_opacity_micromap, and of queries of their sizes.
 */
#include <string.h>

#include "arguments.h"
#include "src/base/readable.h"
#include "src/bvh/micromap.h"
#include "src/check/assemble/views.h"
#include "src/check/life/life.h"
#include "src/check/overlap/pairs.h"
#include "src/rules/micromap/shared.h"

static struct micromap_info_view view_micromap_info(struct check_context *context,
                                                    const struct call_view *call,
                                                    const VkMicromapBuildInfoEXT *info)
{
    struct micromap_info_view view = {
        .call = call,
        .info = info,
        .usages = {.array_field = "pUsageCounts", .pointers_field = "ppUsageCounts"}};
    chain_view_usages(context->readable, info->usageCountsCount, info->pUsageCounts,
                      (const void *const *)info->ppUsageCounts, &view.usages);
    return view;
}

/* ---- queries of sizes */

void check_micromap_size_query(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetMicromapBuildSizesEXT *arguments = call->arguments;
    const struct location location = check_argument(call, "pBuildInfo");
    const VkMicromapBuildInfoEXT *info =
        check_read(walk->context, arguments->pBuildInfo, sizeof(*info));
    if (!info)
        return;
    const struct micromap_info_view view = view_micromap_info(walk->context, call, info);
    walk_micromap_info(walk, &view, &location);
}

/* ---- the triangles of builds on the host */

/* Returns the triangles of a build on the host; `first` is NULL unless all of them are readable. */
static struct micromap_triangles_view view_host_triangles(struct check_context *context,
                                                          const struct built_micromap_view *built)
{
    const VkMicromapBuildInfoEXT *info = built->info;
    struct micromap_triangles_view view = {.call = built->call,
                                           .type = info->type,
                                           .count = built->triangle_count,
                                           .stride = info->triangleArrayStride};
    const struct host_bytes *bytes = &built->host_triangles;
    if (bytes->address && bytes->size && !bytes->unreadable &&
        readable(context->readable, bytes->address, bytes->size))
        view.first = bytes->address;
    return view;
}

/* Returns the data of the first triangle whose data is not there, and sets its index. If there is
 * none, nothing is unreadable. */
static struct host_bytes find_missing_data(struct check_context *context,
                                           const struct micromap_triangles_view *triangles,
                                           const void *data, uint64_t *index)
{
    struct host_bytes bytes = {.address = data};
    for (uint64_t i = 0; triangles->first && data && i < triangles->count; i++) {
        VkMicromapTriangleEXT triangle;
        memcpy(&triangle, triangles->first + i * triangles->stride, sizeof(triangle));
        const uint64_t size =
            micromap_triangle_bytes(triangles->type, triangle.format, triangle.subdivisionLevel);
        bytes = host_memory_bytes(context, data, triangle.dataOffset, size ? 1 : 0, 0, size);
        *index = i;
        if (bytes.unreadable)
            return bytes;
    }
    return bytes;
}

static void view_host_memory(struct check_context *context, struct built_micromap_view *built)
{
    const VkMicromapBuildInfoEXT *info = built->info;
    const struct host_bytes scratch = {.address = info->scratchData.hostAddress,
                                       .begin = info->scratchData.deviceAddress,
                                       .size = built->sizes.build_scratch};
    built->host_scratch = scratch;
    built->host_scratch.unreadable = !host_memory_is_there(context, scratch.address, scratch.size);
    built->host_triangles = host_memory_bytes(
        context, info->triangleArray.hostAddress, 0, built->count_known ? built->triangle_count : 0,
        info->triangleArrayStride, sizeof(VkMicromapTriangleEXT));
    const struct micromap_triangles_view triangles = view_host_triangles(context, built);
    built->host_data =
        find_missing_data(context, &triangles, info->data.hostAddress, &built->triangle);
}

/* ---- builds */

/* The caller has found the parameters valid: the query takes the same structure. */
static void find_micromap_sizes(struct check_context *context,
                                const struct micromap_info_view *view,
                                struct built_micromap_view *built)
{
    const VkMicromapBuildInfoEXT *info = view->info;
    if (built->dst.alive == YES && built->count_known && !info->pNext &&
        info->sType == VK_STRUCTURE_TYPE_MICROMAP_BUILD_INFO_EXT)
        context->hooks->find_micromap_sizes(context->user, info,
                                            command_is_recorded(view->call->command)
                                                ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR
                                                : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR,
                                            &built->sizes);
}

static void view_built_micromap(struct check_context *context,
                                const struct micromap_info_view *view, bool is_valid,
                                struct built_micromap_view *built)
{
    const VkMicromapBuildInfoEXT *info = view->info;
    built->dst =
        check_find_object(context, VK_OBJECT_TYPE_MICROMAP_EXT, handle_number(info->dstMicromap));
    if (is_valid)
        find_micromap_sizes(context, view, built);
    if (!command_is_recorded(view->call->command)) {
        view_host_memory(context, built);
        return;
    }
    resources_look_up_address(context->resources, info->data.deviceAddress, &built->data);
    resources_look_up_address(context->resources, info->triangleArray.deviceAddress,
                              &built->triangles);
    resources_look_up_address(context->resources, info->scratchData.deviceAddress, &built->scratch);
}

/* ---- memory that builds share */

/* The range has no handle, so that a micromap that is built twice shares its memory with itself.
 * The sweep leaves out ranges that are empty or unknown. */
static void add_micromap_range(struct sweep *sweep, uint32_t build, enum range_role role,
                               const struct memory_span *span)
{
    sweep_add(sweep, &(struct used_range){.role = role, .build = build, .span = *span});
}

struct host_scratch {
    struct sweep *sweep;
    uint32_t build;
};

static void add_scratch_piece(void *user, const struct memory_span *piece)
{
    const struct host_scratch *scratch = user;
    add_micromap_range(scratch->sweep, scratch->build, ROLE_SCRATCH, piece);
}

/* A build accesses no more bytes than the sizes say, however large the micromap was created. */
static void collect_micromap_ranges(struct check_context *context, struct sweep *sweep,
                                    uint32_t build, const struct built_micromap_view *built)
{
    const struct micromap_size_facts *sizes = &built->sizes;
    const struct address_facts *scratch = &built->scratch;
    struct memory_span dst = built->dst.span;
    if (!sizes->known)
        return;
    dst.end = dst.begin + smaller_of(sizes->micromap, dst.end - dst.begin);
    add_micromap_range(sweep, build, ROLE_DST, &dst);
    if (!command_is_recorded(built->call->command)) {
        if (!built->host_scratch.unreadable)
            resources_find_host_pieces(context->resources, built->info->scratchData.hostAddress,
                                       sizes->build_scratch, add_scratch_piece,
                                       &(struct host_scratch){sweep, build});
        return;
    }
    const struct memory_span bytes = memory_span_of(
        scratch->memory, scratch->begin, smaller_of(scratch->bytes_left, sizes->build_scratch));
    if (scratch->status == ADDRESS_IN_BUFFER && !scratch->is_sparse)
        add_micromap_range(sweep, build, ROLE_SCRATCH, &bytes);
}

/* ---- the call */

static void check_micromap_build(struct walk *walk, const struct call_view *call,
                                 bool call_is_valid, struct sweep *sweep, uint32_t index,
                                 const VkMicromapBuildInfoEXT *info)
{
    struct check_context *context = walk->context;
    const struct location location = check_element(call, "pInfos", index);
    const struct micromap_info_view view = view_micromap_info(context, call, info);
    const uint32_t findings = walk->findings;
    struct built_micromap_view built = {.call = call,
                                        .info = info,
                                        .count_known = view.usages.count == info->usageCountsCount,
                                        .triangle_count = usages_sum(&view.usages)};
    walk_micromap_info(walk, &view, &location);
    if (context->level >= LEVEL_STATE)
        view_built_micromap(context, &view, call_is_valid && walk->findings == findings, &built);
    walk_built_micromap(walk, &built, &location);
    if (context->level >= LEVEL_STATE)
        collect_micromap_ranges(context, sweep, index, &built);
    if (context->level >= LEVEL_CONTENT && !command_is_recorded(call->command)) {
        const struct micromap_triangles_view triangles = view_host_triangles(context, &built);
        if (triangles.first)
            walk_micromap_triangles(walk, &triangles, &location);
    }
}

void check_micromap_builds(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_CmdBuildMicromapsEXT *recorded = call->arguments;
    const struct arguments_of_BuildMicromapsEXT *hosted = call->arguments;
    const bool is_recorded = command_is_recorded(call->command);
    const uint32_t count = is_recorded ? recorded->infoCount : hosted->infoCount;
    const VkMicromapBuildInfoEXT *infos =
        check_read(walk->context, is_recorded ? recorded->pInfos : hosted->pInfos,
                   (size_t)count * sizeof(*infos));
    const bool call_is_valid = !walk->findings;
    struct sweep sweep;
    if (!infos)
        return;
    sweep_init(&sweep);
    for (uint32_t i = 0; i < count; i++)
        check_micromap_build(walk, call, call_is_valid, &sweep, i, &infos[i]);
    pairs_walk(walk, call, &sweep);
    sweep_release(&sweep);
}
