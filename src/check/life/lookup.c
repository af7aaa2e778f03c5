/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of queries of sizes, addresses, handles and data for capture of structures, and
 * of their bindings. */
#include "arguments.h"
#include "src/check/life/life.h"
#include "src/state/resources/nv_shape.h"

/* ---- sizes */

static bool pointers_are_readable(struct check_context *context, struct size_query_view *query)
{
    const VkAccelerationStructureGeometryKHR *const *pointers = query->geometry_pointers;
    for (uint32_t i = 0; i < query->info->geometryCount; i++)
        if (!readable(context->readable, pointers[i], sizeof(**pointers)))
            return false;
    return true;
}

static void view_geometries(struct check_context *context, struct size_query_view *query)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = query->info;
    if (info->pGeometries) {
        query->geometries = check_read(context, info->pGeometries,
                                       (size_t)info->geometryCount * sizeof(*info->pGeometries));
        return;
    }
    query->geometry_pointers = check_read(
        context, info->ppGeometries, (size_t)info->geometryCount * sizeof(*info->ppGeometries));
    if (query->geometry_pointers && !pointers_are_readable(context, query))
        query->geometry_pointers = NULL;
}

void check_size_query(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetAccelerationStructureBuildSizesKHR *arguments = call->arguments;
    struct check_context *context = walk->context;
    const struct location location = check_argument(call, NULL);
    struct size_query_view query = {
        .call = call,
        .build_type = arguments->buildType,
        .counts_argument = arguments->pMaxPrimitiveCounts,
        .info = check_read(context, arguments->pBuildInfo, sizeof(*arguments->pBuildInfo))};
    if (!query.info)
        return;
    if (query.info->geometryCount) {
        query.counts =
            check_read(context, arguments->pMaxPrimitiveCounts,
                       (size_t)query.info->geometryCount * sizeof(*arguments->pMaxPrimitiveCounts));
        view_geometries(context, &query);
    }
    walk_size_query(walk, &query, &location);
}

/* ---- addresses and handles */

static void check_address(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetAccelerationStructureDeviceAddressKHR *arguments = call->arguments;
    struct check_context *context = walk->context;
    const VkAccelerationStructureDeviceAddressInfoKHR *info =
        check_read(context, arguments->pInfo, sizeof(*info));
    const struct location location = check_argument(call, "pInfo");
    struct lookup_view lookup = {.call = call};
    if (!info)
        return;
    lookup.object = check_find_object(context, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                      (uint64_t)(uintptr_t)info->accelerationStructure);
    if (lookup.object.details_known && lookup.object.buffer && !lookup.object.by_address)
        resources_ask_buffer(context->resources, lookup.object.buffer, &lookup.buffer);
    walk_lookup(walk, &lookup, &location);
}

void check_lookup(struct walk *walk, const struct call_view *call)
{
    if (call->command == COMMAND_GetAccelerationStructureDeviceAddressKHR) {
        check_address(walk, call);
        return;
    }
    const struct arguments_of_GetAccelerationStructureHandleNV *arguments = call->arguments;
    const struct location location = check_argument(call, NULL);
    const struct lookup_view lookup = {
        .call = call,
        .data_size = arguments->dataSize,
        .object = check_find_object(walk->context, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                                    (uint64_t)(uintptr_t)arguments->accelerationStructure)};
    walk_lookup(walk, &lookup, &location);
}

/* ---- data for capture */

void check_capture(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetAccelerationStructureOpaqueCaptureDescriptorDataEXT *arguments =
        call->arguments;
    const struct location location = check_argument(call, "pInfo");
    struct capture_view capture = {
        .call = call,
        .info = check_read(walk->context, arguments->pInfo, sizeof(*arguments->pInfo)),
        .data = arguments->pData};
    if (!capture.info)
        return;
    capture.structure = check_find_object(walk->context, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                          (uint64_t)(uintptr_t)capture.info->accelerationStructure);
    capture.nv_structure =
        check_find_object(walk->context, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                          (uint64_t)(uintptr_t)capture.info->accelerationStructureNV);
    capture.data_is_cut =
        !readable(walk->context->readable, capture.data, call->device->accel_capture_size);
    walk_capture(walk, &capture, &location);
}

/* ---- memory */

void check_bindings(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_BindAccelerationStructureMemoryNV *arguments = call->arguments;
    struct check_context *context = walk->context;
    const VkBindAccelerationStructureMemoryInfoNV *infos =
        check_read(context, arguments->pBindInfos,
                   (size_t)arguments->bindInfoCount * sizeof(*arguments->pBindInfos));
    for (uint32_t i = 0; infos && context->level >= LEVEL_STATE && i < arguments->bindInfoCount;
         i++) {
        struct nv_accel_facts facts;
        resources_ask_nv_accel(context->resources, infos[i].accelerationStructure, &facts);
        const struct binding_view binding = {
            .call = call,
            .info = &infos[i],
            .before = facts.binding,
            .required = facts.sizes,
            .memory = resources_find_memory(context->resources, infos[i].memory)};
        const struct location location = check_element(call, "pBindInfos", i);
        nv_shape_release(facts.created);
        walk_binding(walk, &binding, &location);
    }
}
