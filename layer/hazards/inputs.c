/* SPDX-License-Identifier: Apache-2.0 */
/* Records the input data that builds certainly read. What an indirect build reads depends on counts
 * in device memory, so nothing of it is certain. */
#include "layer/hazards/builds.h"

#include <stdlib.h>
#include <string.h>

#include "layer/hazards/executed/host_writes.h"
#include "layer/hazards/recording.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/check/assemble/extended.h"
#include "src/check/assemble/views.h"
#include "src/model/formats.h"
#include "src/model/inputs.h"
#include "src/view/extension_view.h"

/* ---- bytes */

static void add_in_buffer(struct hazard_recording *recording, const struct hazard_use *use,
                          const struct hazard_elements *from, uint64_t begin, uint64_t end)
{
    const struct address_facts *facts = from->facts;
    uint64_t size = facts->bytes_left;
    const struct hazard_bytes bytes = {from->memory_id,
                                       facts->begin + (begin < size ? begin : size),
                                       facts->begin + (end < size ? end : size)};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer),
                         &bytes);
}

/* NULL if there are none, or if the offset leads past the last address. */
static const void *host_bytes_at(const void *host, uint64_t offset)
{
    const uintptr_t begin = (uintptr_t)host;
    return host && offset <= UINTPTR_MAX - begin ? (const void *)(begin + (uintptr_t)offset) : NULL;
}

static void add_bytes(struct hazard_recording *recording, const struct hazard_use *use,
                      const struct hazard_elements *from, uint64_t begin, uint64_t end)
{
    if (end == UINT64_MAX)
        return;
    if (from->memory_id)
        add_in_buffer(recording, use, from, begin, end);
    else if (from->host)
        hazards_add_host(recording, use, host_bytes_at(from->host, begin), end - begin);
    else
        hazard_recording_add_address(recording, use, from->facts, begin, end);
}

/* Whether the host alone may write what a build of the device reads. */
static bool is_of_host(const struct hazard_elements *elements)
{
    return !elements->host && elements->facts->status == ADDRESS_IN_BUFFER &&
           buffer_is_only_read(elements->facts->usage);
}

void hazards_add_elements(struct hazard_recording *recording, const struct hazard_use *use,
                          const struct hazard_elements *elements)
{
    uint64_t size = elements->size, stride = elements->stride;
    if (!elements->count || !size)
        return;
    recording->journal->reads_host_data |= is_of_host(elements);
    uint64_t begin = elements->offset;
    uint64_t last = input_extent(begin, elements->count - 1, stride, 0);
    uint64_t end = input_extent(begin, elements->count - 1, stride, size);
    if (stride <= size || elements->count == 1) {
        add_bytes(recording, use, elements, begin, end);
        return;
    }
    add_bytes(recording, use, elements, begin, begin + size);
    add_bytes(recording, use, elements, last, end);
}

void hazards_add_indexed(struct hazard_recording *recording, const struct hazard_use *use,
                         const struct hazard_elements *elements)
{
    const struct address_facts *facts = elements->facts;
    const bool is_content = recording->device->level >= LEVEL_CONTENT;
    if (elements->host || facts->status != ADDRESS_IN_BUFFER ||
        elements->offset >= facts->bytes_left || elements->stride > UINT32_MAX ||
        (!is_content && !is_of_host(elements)))
        return;
    const uint64_t memory =
        elements->memory_id
            ? elements->memory_id
            : hazard_memory_id(recording->journal, recording->device->resources, facts->memory);
    struct hazard_entry *item =
        memory ? hazard_recording_add_entry(recording, HAZARD_INDEXED, use) : NULL;
    if (!item)
        return;
    item->object_type = VK_OBJECT_TYPE_BUFFER;
    item->object = handle_number(facts->buffer);
    item->vertex_stride = (uint32_t)elements->stride;
    item->vertex_size = (uint32_t)elements->size;
    item->bytes = (struct hazard_bytes){memory, facts->begin + elements->offset,
                                        facts->begin + facts->bytes_left};
    recording->journal->awaits_inputs |= is_content;
}

/* ---- geometries */

/* A geometry that is being recorded. */
struct reading {
    struct hazard_recording *recording;
    const struct geometry_view *geometry;
    bool is_host;
};

enum hazard_role hazards_role_of(enum input_role role, bool has_pointers)
{
    switch (role) {
    case INPUT_VERTEX:
        return HAZARD_VERTICES;
    case INPUT_INDEX:
        return HAZARD_INDICES;
    case INPUT_MATRIX:
        return HAZARD_TRANSFORM;
    case INPUT_AABBS:
        return HAZARD_BOXES;
    case INPUT_INSTANCES:
        return has_pointers ? HAZARD_INSTANCE_POINTERS : HAZARD_INSTANCES;
    case INPUT_MOTION_VERTEX:
    case INPUT_SPHERE_VERTEX:
    case INPUT_SPHERE_RADIUS:
    case INPUT_SPHERE_INDEX:
    case INPUT_SWEPT_VERTEX:
    case INPUT_SWEPT_RADIUS:
    case INPUT_SWEPT_INDEX:
    case INPUT_MICROMAP_DATA:
    case INPUT_MICROMAP_TRIANGLES:
    case INPUT_OPACITY_INDEX:
    case INPUT_OPACITY_EXT_INDEX:
    case INPUT_DENSE_DATA:
    case INPUT_SCRATCH:
    case INPUT_UPDATE_SCRATCH:
    case INPUT_INDIRECT:
    case INPUT_DISPLACEMENT_INDEX:
    case INPUT_DISPLACEMENT_VECTOR:
    case INPUT_DISPLACEMENT_BIAS:
    case INPUT_DISPLACEMENT_FLAGS:
    case INPUT_ROLES:
        break;
    }
    return HAZARD_OTHER_INPUT;
}

/* Level content reads the data, and shaders may be what wrote them. */
static void await_data(const struct reading *reading, const struct address_facts *facts)
{
    const struct layer_device *device = reading->recording->device;
    if (!reading->is_host && device->level >= LEVEL_CONTENT && facts->status == ADDRESS_IN_BUFFER &&
        !resources_find_memory(device->resources, facts->memory).is_shared)
        reading->recording->journal->awaits_inputs = true;
}

/* Addresses of extensions are looked up into `other`. */
static const struct address_facts *facts_of(const struct reading *reading,
                                            const struct geometry_input *input,
                                            struct address_facts *other)
{
    const struct geometry_view *geometry = reading->geometry;
    if (input->role <= INPUT_LAST_PLAIN)
        return input_facts(geometry, input->role);
    *other = (struct address_facts){.status = ADDRESS_UNKNOWN};
    if (!reading->is_host)
        resources_look_up_address(reading->recording->device->resources,
                                  input->address.deviceAddress, other);
    return other;
}

/* Indices may skip any vertex, and maxVertex is an upper bound: without the indices no vertex of an
 * indexed geometry is certain, with them those of the smallest and the largest one. */
static void add_input(const struct reading *reading, const struct geometry_input *input)
{
    struct address_facts other;
    const struct hazard_use use = {
        .kind = reading->is_host ? ACCESS_HOST_READ : ACCESS_BUILD_SHADER_READ,
        .role = hazards_role_of(input->role, input->stride == sizeof(VkDeviceAddress)),
        .info = reading->geometry->build->index,
        .geometry = reading->geometry->index,
        .index_size = input->role == INPUT_INDEX ? (uint32_t)input->size : 0,
    };
    const struct hazard_elements elements = {
        .facts = facts_of(reading, input, &other),
        .host = reading->is_host ? input->address.hostAddress : NULL,
        .offset = input->offset,
        .count = input->count,
        .stride = input->stride,
        .size = input->size,
    };
    if (reading->is_host && (!elements.host || input->is_of_device))
        return;
    if (!input->is_chosen)
        hazards_add_elements(reading->recording, &use, &elements);
    else if (input->follows_indices && !reading->is_host)
        hazards_add_indexed(reading->recording, &use, &elements);
    if (input->role == INPUT_VERTEX || input->role == INPUT_AABBS)
        await_data(reading, elements.facts);
}

/* The references of a host build are handles, in host memory, which level content reads. */
static void add_host_references(const struct reading *reading, const struct geometry_input *input)
{
    const size_t size = sizeof(VkAccelerationStructureInstanceKHR);
    const char *first = host_bytes_at(input->address.hostAddress, input->offset);
    const struct hazard_use use = {.kind = ACCESS_HOST_READ,
                                   .role = HAZARD_REFERENCE,
                                   .info = reading->geometry->build->index};
    uint64_t last = 0;
    if (!first || input->size != size ||
        !readable(readable_cache_of_thread(), first, input->count * size))
        return;
    for (uint64_t i = 0; i < input->count; i++) {
        VkAccelerationStructureInstanceKHR instance;
        struct accel_facts facts;
        memcpy(&instance, first + i * size, size);
        if (instance.accelerationStructureReference == last)
            continue;
        last = instance.accelerationStructureReference;
        resources_look_up_accel(reading->recording->device->resources,
                                (VkAccelerationStructureKHR)(uintptr_t)last, &facts);
        hazard_recording_add_accel(reading->recording, &use, &facts, 1);
    }
}

void hazards_add_inputs(struct hazard_recording *recording, const struct geometry_view *geometry)
{
    const struct build_view *build = geometry->build;
    const struct reading reading = {recording, geometry, build->call->command == COMMAND_HOST};
    const VkBuildAccelerationStructureFlagsKHR flags = build->info->flags;
    struct chained_input chained = {0};
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const bool has_chain =
        geometry->chained && chained_input_copy(readable_cache_of_thread(), flags,
                                                geometry->geometry, &chained) == VK_SUCCESS;
    const uint32_t count =
        inputs_of_geometry(flags, geometry->geometry, has_chain ? &chained : NULL,
                           build->ranges ? &build->ranges[geometry->index] : NULL, inputs);
    for (uint32_t i = 0; i < count; i++) {
        add_input(&reading, &inputs[i]);
        if (reading.is_host && inputs[i].role == INPUT_INSTANCES &&
            recording->device->level >= LEVEL_CONTENT)
            add_host_references(&reading, &inputs[i]);
    }
    free(chained.micromap.usages);
}

/* ---- what the host has overwritten */

/* Call before the host submits or waits. It does not know yet that the builds are complete, so it
 * wrote too early whatever it has written by now. */
void hazards_look_at_inputs(struct layer_device *device)
{
    host_writes_look(device->host_writes);
}

/* Call before the host sets an event. It may have written in time for batches that wait. */
void hazards_forget_inputs(struct layer_device *device)
{
    host_writes_forget(device->host_writes);
}
