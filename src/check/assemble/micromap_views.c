/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of micromaps. */
#include "src/check/assemble/views.h"

#include "src/base/chain.h"
#include "src/check/assemble/extended.h"
#include "src/model/geometry.h"
#include "src/rules/micromap/shared.h"
#include "src/rules/shared.h"

static const void *find_in_triangles_chain(const struct geometry_view *geometry,
                                           VkStructureType type)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return triangles ? chain_member(triangles->pNext, &geometry->triangles_chain, type) : NULL;
}

bool view_micromap_data(struct check_context *context, const struct geometry_view *geometry,
                        struct micromap_data_view *view)
{
    const VkAccelerationStructureGeometryMicromapDataKHR *data =
        chain_member(geometry->geometry->pNext, &geometry->chain,
                     VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR);
    if (!data || !geometry->build->call->device->extension.opacity_micromap_khr)
        return false;
    *view =
        (struct micromap_data_view){.geometry = geometry,
                                    .data = data,
                                    .usages = {.array_field = MICROMAP_DATA "pUsageCounts",
                                               .pointers_field = MICROMAP_DATA "ppUsageCounts"}};
    chain_view_usages(context->readable, data->usageCountsCount, data->pUsageCounts,
                      (const void *const *)data->ppUsageCounts, &view->usages);
    return true;
}

bool view_opacity(const struct geometry_view *geometry, struct opacity_view *view)
{
    const VkAccelerationStructureTrianglesOpacityMicromapKHR *opacity = find_in_triangles_chain(
        geometry, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR);
    const struct build_view *build = geometry->build;
    if (!opacity || !build->call->device->extension.opacity_micromap_khr)
        return false;
    *view = (struct opacity_view){.geometry = geometry, .opacity = opacity};
    if (build->ranges) {
        view->count_known = true;
        view->primitive_count = build->ranges[geometry->index].primitiveCount;
    }
    return true;
}

bool view_opacity_ext(struct check_context *context, const struct geometry_view *geometry,
                      struct opacity_ext_view *view)
{
    const VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity = find_in_triangles_chain(
        geometry, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT);
    if (!opacity || !geometry->build->call->device->extension.opacity_micromap_ext)
        return false;
    *view =
        (struct opacity_ext_view){.geometry = geometry,
                                  .opacity = opacity,
                                  .usages = {.array_field = OPACITY_EXT_DATA "pUsageCounts",
                                             .pointers_field = OPACITY_EXT_DATA "ppUsageCounts"}};
    chain_view_usages(context->readable, opacity->usageCountsCount, opacity->pUsageCounts,
                      (const void *const *)opacity->ppUsageCounts, &view->usages);
    return true;
}

bool view_displacement(struct check_context *context, const struct geometry_view *geometry,
                       struct displacement_view *view)
{
    const VkAccelerationStructureTrianglesDisplacementMicromapNV *displacement =
        find_in_triangles_chain(
            geometry, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV);
    if (!displacement || !geometry->build->call->device->extension.displacement_micromap_nv)
        return false;
    *view =
        (struct displacement_view){.geometry = geometry,
                                   .displacement = displacement,
                                   .usages = {.array_field = DISPLACEMENT_DATA "pUsageCounts",
                                              .pointers_field = DISPLACEMENT_DATA "ppUsageCounts"}};
    chain_view_usages(context->readable, displacement->usageCountsCount, displacement->pUsageCounts,
                      (const void *const *)displacement->ppUsageCounts, &view->usages);
    return true;
}

bool micromap_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry)
{
    return chain_find(geometry->pNext,
                      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR) != NULL;
}

bool is_micromap_build_for_device(const struct build_view *build)
{
    const struct call_view *call = build->call;
    return build->info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR &&
           call->command == COMMAND_DEVICE && call->device->micromap.khr &&
           call->device->extension.opacity_micromap_khr && build->geometry_count == 1 &&
           type_is_micromap(build_geometry(build->info, 0)->geometryType);
}

/* ---- state */

/* Host builds use host addresses, except for the indices of micromaps of
 * VK_KHR_opacity_micromap. */
static bool has_addresses(const struct geometry_view *geometry)
{
    return geometry->build->call->command != COMMAND_HOST;
}

void view_micromap_data_state(struct check_context *context, struct geometry_view *geometry,
                              struct micromap_data_view *view)
{
    if (!has_addresses(geometry))
        return;
    chained_input(context, geometry, INPUT_MICROMAP_DATA, view->data->data);
    view->triangles_facts =
        chained_input(context, geometry, INPUT_MICROMAP_TRIANGLES, view->data->triangleArray);
}

void view_opacity_state(struct check_context *context, struct geometry_view *geometry,
                        struct opacity_view *view)
{
    const VkAccelerationStructureTrianglesOpacityMicromapKHR *opacity = view->opacity;
    resources_look_up_accel(context->resources, opacity->micromap, &view->micromap);
    if (view->micromap.alive == NO)
        view->micromap.of_another_device = context->hooks->of_another_device(
            context->user, RESOURCE_ACCEL, handle_number(view->micromap.handle));
    if (index_type_size(opacity->indexType))
        view->indices = chained_input(context, geometry, INPUT_OPACITY_INDEX, opacity->indexBuffer);
}

static void find_micromap(struct check_context *context, VkMicromapEXT handle,
                          struct micromap_facts *facts)
{
    resources_find_micromap(context->resources, handle, facts);
    if (facts->alive == NO)
        facts->of_another_device = context->hooks->of_another_device(
            context->user, RESOURCE_MICROMAP, handle_number(handle));
}

void view_opacity_ext_state(struct check_context *context, struct geometry_view *geometry,
                            struct opacity_ext_view *view)
{
    const VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity = view->opacity;
    find_micromap(context, opacity->micromap, &view->micromap);
    if (has_addresses(geometry) && index_type_size(opacity->indexType))
        chained_input(context, geometry, INPUT_OPACITY_EXT_INDEX,
                      opacity->indexBuffer.deviceAddress);
}

void view_displacement_state(struct check_context *context, struct geometry_view *geometry,
                             struct displacement_view *view)
{
    const VkAccelerationStructureTrianglesDisplacementMicromapNV *data = view->displacement;
    const struct chained_input chained = {.displacement = *data};
    find_micromap(context, data->micromap, &view->micromap);
    if (!has_addresses(geometry) || !data->micromap)
        return;
    for (enum input_role role = INPUT_DISPLACEMENT_INDEX; role <= INPUT_DISPLACEMENT_FLAGS;
         role++) {
        const VkDeviceAddress address =
            input_place(geometry->geometry, &chained, role)->deviceAddress;
        const bool is_used = role != INPUT_DISPLACEMENT_INDEX || index_type_size(data->indexType);
        if (address && is_used)
            chained_input(context, geometry, role, address);
    }
}
