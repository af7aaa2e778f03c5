/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of queries of addresses, handles and data for capture of structures, and of their
 * bindings. */
#include "arguments.h"
#include "src/check/life/life.h"
#include "src/state/resources/nv_shape.h"

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
                                      handle_number(info->accelerationStructure));
    if (lookup.object.details_known && lookup.object.buffer && !lookup.object.by_address)
        resources_look_up_buffer(context->resources, lookup.object.buffer, &lookup.buffer);
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
                                    handle_number(arguments->accelerationStructure))};
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
                                          handle_number(capture.info->accelerationStructure));
    capture.nv_structure =
        check_find_object(walk->context, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                          handle_number(capture.info->accelerationStructureNV));
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
        resources_look_up_nv_accel(context->resources, infos[i].accelerationStructure, &facts);
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
