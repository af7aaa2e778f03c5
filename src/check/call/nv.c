/* SPDX-License-Identifier: Apache-2.0 */
/* Validates a call of vkCmdBuildAccelerationStructureNV, and what vkCreateAccelerationStructureNV
 * has in common with it, and makes the views. */
#include <string.h>

#include "src/check/assemble/views.h"
#include "src/check/call/check.h"
#include "src/check/walk/walk.h"

/* ---- parameters */

/* The caller releases `build`. */
static void view_parameters(struct check_context *context, struct nv_call_view *call,
                            struct build_parameters *build)
{
    const VkAccelerationStructureInfoNV *info = call->info_argument;
    struct readable_cache *cache = context->readable;
    const struct nv_data data = {.instances = {call->instance_data, call->instance_offset}};
    *build = (struct build_parameters){0};
    call->info = readable(cache, info, sizeof(*info)) ? info : NULL;
    if (!call->info)
        return;
    call->geometries_unreadable =
        info->geometryCount && !readable(cache, info->pGeometries,
                                         (size_t)info->geometryCount * sizeof(*info->pGeometries));
    if (call->geometries_unreadable || nv_info_copy(cache, info, &data, build) != VK_SUCCESS)
        return;
    call->geometries = info->pGeometries;
    call->geometry_count = info->geometryCount;
    call->build = (struct build_view){.call = call->call,
                                      .info = &build->info,
                                      .geometries = build->geometries,
                                      .geometry_count = build->info.geometryCount,
                                      .ranges = build->ranges};
}

static struct nv_info_view view_info(const struct nv_call_view *call)
{
    struct nv_info_view view = {
        .call = call, .info = call->info, .first_other_type = call->geometry_count};
    for (uint32_t i = call->geometry_count; i-- > 0;)
        if (call->geometries[i].geometryType != call->geometries[0].geometryType)
            view.first_other_type = i;
    for (uint32_t i = 0; i < call->build.geometry_count; i++)
        if (type_is_triangles(call->build.geometries[i].geometryType))
            view.triangle_count += call->build.ranges[i].primitiveCount;
    return view;
}

static struct nv_geometry_view view_nv_geometry(const struct nv_call_view *call, uint32_t index)
{
    const VkGeometryNV *geometry = &call->geometries[index];
    struct nv_geometry_view view = {.call = call, .index = index, .geometry = geometry};
    /* A top-level structure has one geometry: the instances. */
    const uint32_t translated = index < call->build.geometry_count ? index : 0;
    view.translated.build = &call->build;
    view.translated.geometry = &call->build.geometries[translated];
    if (type_is_triangles(geometry->geometryType) &&
        geometry->geometry.triangles.sType == VK_STRUCTURE_TYPE_GEOMETRY_TRIANGLES_NV)
        view.triangles = &geometry->geometry.triangles;
    if (type_is_aabbs(geometry->geometryType) &&
        geometry->geometry.aabbs.sType == VK_STRUCTURE_TYPE_GEOMETRY_AABB_NV)
        view.aabbs = &geometry->geometry.aabbs;
    if (view.triangles || view.aabbs)
        nv_places_of(geometry, view.places);
    return view;
}

/* ---- state */

/* Looks for a handle on other devices only if this device has no such object. */
static bool is_of_another_device(struct check_context *context, enum resource_kind kind,
                                 uint64_t handle, enum tristate alive)
{
    return handle && alive == NO && context->hooks->of_another_device(context->user, kind, handle);
}

static void find_accel(struct check_context *context, VkAccelerationStructureNV handle,
                       struct nv_accel_facts *facts)
{
    resources_look_up_nv_accel(context->resources, handle, facts);
    facts->of_another_device =
        is_of_another_device(context, RESOURCE_ACCEL_NV, handle_number(handle), facts->alive);
}

static void find_buffer(struct check_context *context, VkBuffer handle, struct buffer_facts *facts)
{
    resources_look_up_buffer(context->resources, handle, facts);
    facts->of_another_device =
        is_of_another_device(context, RESOURCE_BUFFER, handle_number(handle), facts->alive);
}

static void find_call(struct check_context *context, struct nv_call_view *call)
{
    find_accel(context, call->dst, &call->dst_facts);
    find_accel(context, call->src, &call->src_facts);
    find_buffer(context, call->scratch, &call->scratch_facts);
    find_buffer(context, call->instance_data, &call->instance_facts);
}

static void find_geometry(struct check_context *context, struct nv_geometry_view *geometry)
{
    for (enum input_role role = 0; role <= INPUT_LAST_PLAIN; role++)
        find_buffer(context, geometry->places[role].buffer, &geometry->found[role]);
}

static void record_input(struct check_context *context, uint32_t geometry, enum input_role role,
                         const struct buffer_facts *facts)
{
    if (facts->id)
        context->recorder->record_nv_input(context->user, geometry, role, facts);
}

static void record_geometry(struct check_context *context, const struct nv_geometry_view *geometry)
{
    for (enum input_role role = 0; role <= INPUT_LAST_PLAIN; role++)
        record_input(context, geometry->index, role, &geometry->found[role]);
}

static void record_call(struct check_context *context, const struct nv_call_view *call)
{
    context->recorder->record_nv_build(context->user, call);
    record_input(context, 0, INPUT_SCRATCH, &call->scratch_facts);
    record_input(context, 0, INPUT_INSTANCES, &call->instance_facts);
}

/* ---- the call */

static void check_geometries(struct walk *walk, const struct nv_call_view *call, bool with_state)
{
    struct check_context *context = walk->context;
    for (uint32_t i = 0; i < call->geometry_count; i++) {
        struct nv_geometry_view geometry = view_nv_geometry(call, i);
        walk_nv_geometry(walk, &geometry, LEVEL_PARAMETERS);
        if (!with_state)
            continue;
        find_geometry(context, &geometry);
        walk_nv_geometry(walk, &geometry, LEVEL_STATE);
        if (context->recorder)
            record_geometry(context, &geometry);
    }
}

static void check_info(struct walk *walk, const struct nv_call_view *call, bool with_state)
{
    const struct nv_info_view info = view_info(call);
    walk_nv_info(walk, &info, LEVEL_PARAMETERS);
    if (with_state)
        walk_nv_info(walk, &info, LEVEL_STATE);
    check_geometries(walk, call, with_state);
}

void check_nv_info(struct walk *walk, const struct call_view *call,
                   const VkAccelerationStructureInfoNV *info)
{
    struct nv_call_view view = {.call = call, .info_argument = info};
    struct build_parameters build;
    if (!align_nv_call(walk->context, &view))
        return;
    view_parameters(walk->context, &view, &build);
    if (view.info)
        check_info(walk, &view, walk->context->level >= LEVEL_STATE);
    build_parameters_release(&build);
}

static void check_parameters(struct walk *walk, struct nv_call_view *call)
{
    struct check_context *context = walk->context;
    bool with_state = context->level >= LEVEL_STATE;
    struct build_parameters build;
    view_parameters(context, call, &build);
    if (with_state)
        find_call(context, call);
    walk_nv_call(walk, call, LEVEL_PARAMETERS);
    if (with_state)
        walk_nv_call(walk, call, LEVEL_STATE);
    if (call->info)
        check_info(walk, call, with_state);
    if (context->recorder)
        record_call(context, call);
    build_parameters_release(&build);
    nv_shape_release(call->dst_facts.created);
    nv_shape_release(call->src_facts.created);
}

void check_nv_build(struct check_context *context, struct nv_call_view *call)
{
    struct aligned_copies copies = {NULL};
    struct walk walk;
    walk_start(&walk, context);
    context->copies = &copies;
    walk_call(&walk, call->call, LEVEL_PARAMETERS);
    walk_call(&walk, call->call, LEVEL_STATE);
    if (call->call->device->extension.ray_tracing_nv && align_nv_call(context, call))
        check_parameters(&walk, call);
    aligned_copies_release(&copies);
}
