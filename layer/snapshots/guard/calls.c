/* SPDX-License-Identifier: Apache-2.0 */
/* Copies the parameters of calls with guarded builds. */
#include "layer/snapshots/guard/calls.h"

#include <stdlib.h>
#include <string.h>

#include "layer/snapshots/guard/references.h"
#include "src/base/array.h"

void guard_call_add(struct guard_call *call, struct recorder *recorder,
                    struct recorded_build *build)
{
    if (!call || !recorder->device->snapshots->guard)
        return;
    if (!ARRAY_HAS_ROOM(call->builds, call->count, call->capacity)) {
        guard_warn_unguarded(recorder->device->snapshots->guard, GUARD_LACKS_MEMORY);
        return;
    }
    struct guarded_build *added = &call->builds[call->count];
    added->info = build->place.info;
    call->count += guard_copy(recorder, build, call->instances, call->offset, &added->copy);
}

void guard_call_end(struct guard_call *call, const struct recorder *recorder)
{
    VkBuffer last = VK_NULL_HANDLE; /* most calls have one buffer for all copies */
    for (uint32_t i = 0; i < call->count; i++) {
        if (call->builds[i].copy.buffer != last)
            guard_end_copy(recorder, &call->builds[i].copy);
        last = call->builds[i].copy.buffer;
    }
}

void guard_call_release(struct guard_call *call)
{
    free(call->builds);
    free(call->parameters);
}

/* ---- parameters */

struct guarded_parameters {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildRangeInfoKHR range;
};

_Static_assert(sizeof(void *) == sizeof(uint64_t), "elements are pointers or device addresses");

/* Copies `count` infos and `count` elements of 8 bytes, and allocates the parameters of each
 * guarded build. Returns NULL if no build is guarded, or without memory: then nothing is guarded.
 */
static struct guarded_parameters *
copy_parameters(struct guard_call *call, uint32_t count,
                const VkAccelerationStructureBuildGeometryInfoKHR *given_infos,
                const void *given_elements, VkAccelerationStructureBuildGeometryInfoKHR **infos,
                void **elements)
{
    size_t size = (sizeof(**infos) + sizeof(uint64_t)) * count;
    if (!call->count)
        return NULL;
    call->parameters = malloc(size + call->count * sizeof(struct guarded_parameters));
    if (!call->parameters)
        return NULL;
    *infos = call->parameters;
    *elements = *infos + count;
    memcpy(*infos, given_infos, count * sizeof(**infos));
    memcpy(*elements, given_elements, count * sizeof(uint64_t));
    return (void *)((char *)call->parameters + size);
}

/* Takes the geometry from `info`, and lets it read the guarded copy. Arrays of the application may
 * be misaligned. */
static void guard_geometry(VkAccelerationStructureBuildGeometryInfoKHR *info,
                           const struct guarded_copy *copy,
                           VkAccelerationStructureGeometryKHR *geometry)
{
    const void *given = info->pGeometries;
    if (!given)
        memcpy(&given, info->ppGeometries, sizeof(given));
    memcpy(geometry, given, sizeof(*geometry));
    geometry->geometry.instances.data.deviceAddress = copy->data;
    info->pGeometries = geometry;
    info->ppGeometries = NULL;
}

void guard_call_direct(struct guard_call *call, uint32_t count,
                       const VkAccelerationStructureBuildGeometryInfoKHR **infos,
                       const VkAccelerationStructureBuildRangeInfoKHR *const **ranges)
{
    VkAccelerationStructureBuildGeometryInfoKHR *own;
    void *elements;
    struct guarded_parameters *parameters =
        copy_parameters(call, count, *infos, *ranges, &own, &elements);
    if (!parameters)
        return;
    const VkAccelerationStructureBuildRangeInfoKHR **own_ranges = elements;
    for (uint32_t i = 0; i < call->count; i++) {
        uint32_t info = call->builds[i].info;
        guard_geometry(&own[info], &call->builds[i].copy, &parameters[i].geometry);
        memcpy(&parameters[i].range, own_ranges[info], sizeof(parameters[i].range));
        parameters[i].range.primitiveOffset = 0;
        own_ranges[info] = &parameters[i].range;
    }
    *infos = own;
    *ranges = own_ranges;
}

void guard_call_indirect(struct guard_call *call, uint32_t count,
                         const VkAccelerationStructureBuildGeometryInfoKHR **infos,
                         const VkDeviceAddress **addresses)
{
    VkAccelerationStructureBuildGeometryInfoKHR *own;
    void *elements;
    struct guarded_parameters *parameters =
        copy_parameters(call, count, *infos, *addresses, &own, &elements);
    if (!parameters)
        return;
    VkDeviceAddress *own_addresses = elements;
    for (uint32_t i = 0; i < call->count; i++) {
        uint32_t info = call->builds[i].info;
        guard_geometry(&own[info], &call->builds[i].copy, &parameters[i].geometry);
        own_addresses[info] = call->builds[i].copy.range;
    }
    *infos = own;
    *addresses = own_addresses;
}
