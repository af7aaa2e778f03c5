/* SPDX-License-Identifier: Apache-2.0 */
/* Records the structures, scratch memory, build ranges and micromaps that builds access, and the
 * inputs of vkCmdBuildAccelerationStructureNV. */
#include "layer/hazards/builds.h"

#include <stdlib.h>

#include "layer/hazards/recording.h"
#include "layer/intercepts/intercepts.h"
#include "observers.h"
#include "src/base/array.h"
#include "src/base/readable.h"
#include "src/model/build_parameters.h"
#include "src/model/inputs.h"

/* Starts to record a part of a build call; the first part begins the command. */
static void hazards_start_build(struct hazard_recording *recording, struct build_call *call)
{
    *recording = (struct hazard_recording){.device = call->device,
                                           .command_buffer = call->command_buffer,
                                           .journal = call->journal,
                                           .command = call->hazards};
    if (recording->command)
        return;
    hazard_recording_command(recording, build_command_name(call->view.command),
                             call_site_of_call(call->device));
    call->hazards = recording->command;
    if (!recording->command)
        return;
    recording->command->build_count = call->view.info_count;
    recording->command->first_build = call->view.command_buffer.build_index;
}

static bool is_host(const struct build_view *build)
{
    return build->call->command == COMMAND_HOST;
}

/* A build accesses only accelerationStructureSize bytes of a structure, however large it was
 * created, and an unknown part if that size is unknown: the first byte. */
static VkDeviceSize size_in_structure(const struct build_view *build)
{
    return build->sizes.known ? build->sizes.acceleration_structure : 1;
}

/* The read comes first, so that the write of an update in place does not hide an earlier one. */
static void add_structures(struct hazard_recording *recording, const struct build_view *build)
{
    const VkDeviceSize size = size_in_structure(build);
    struct hazard_use use = {.kind = is_host(build) ? ACCESS_HOST_READ : ACCESS_BUILD_ACCEL_READ,
                             .role = HAZARD_SRC,
                             .info = build->index};
    if (build_is_update(build->info))
        hazard_recording_add_accel(recording, &use, &build->src, size);
    use.kind = is_host(build) ? ACCESS_HOST_WRITE : ACCESS_BUILD_ACCEL_WRITE;
    use.role = build->info->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ? HAZARD_TOP_DST
                                                                                 : HAZARD_DST;
    hazard_recording_add_accel(recording, &use, &build->dst, size);
}

static void add_scratch(struct hazard_recording *recording, const struct build_view *build)
{
    struct hazard_use use = {
        .kind = ACCESS_BUILD_ACCEL_WRITE, .role = HAZARD_SCRATCH, .info = build->index};
    if (!build->sizes.known)
        return;
    VkDeviceSize size = build_scratch_size(build);
    if (!is_host(build)) {
        hazard_recording_add_address(recording, &use, &build->scratch, 0, size);
        return;
    }
    use.kind = ACCESS_HOST_WRITE;
    hazards_add_host(recording, &use, build->info->scratchData.hostAddress, size);
}

/* A build reads an unknown part of a micromap, which begins where the micromap does. Micromaps of
 * VK_KHR_opacity_micromap are acceleration structures. */
static void add_micromap(struct hazard_recording *recording, const struct build_view *build,
                         const struct micromap_use *micromap)
{
    struct hazard_use use = {.kind = ACCESS_BUILD_ACCEL_READ,
                             .role = HAZARD_MICROMAP,
                             .info = build->index,
                             .geometry = micromap->geometry};
    struct memory_bytes all;
    if (is_host(build))
        use.kind = ACCESS_HOST_READ;
    if (!micromap->is_ext) {
        hazard_recording_add_accel(recording, &use, &micromap->accel, 1);
        return;
    }
    if (!is_host(build))
        use.kind = ACCESS_BUILD_MICROMAP_READ;
    VkMicromapEXT handle = (VkMicromapEXT)(uintptr_t)micromap->handle;
    if (resources_find_micromap_bytes(recording->device->resources, handle, &all) && all.size)
        hazard_recording_add(recording, &use, VK_OBJECT_TYPE_MICROMAP_EXT, micromap->handle,
                             &(struct hazard_bytes){all.memory_id, all.begin, all.begin + 1});
}

static void add_micromaps(struct hazard_recording *recording, const struct build_view *build)
{
    const struct micromap_uses *micromaps = build->micromaps;
    for (uint32_t i = 0; micromaps && i < micromaps->count; i++)
        if (micromaps->items[i].handle &&
            (!i || micromaps->items[i].handle != micromaps->items[i - 1].handle))
            add_micromap(recording, build, &micromaps->items[i]);
}

static void add_geometry(struct hazard_recording *recording, const struct geometry_view *geometry)
{
    struct hazard_entry *command = recording->command;
    bool has_instances =
        type_is_instances(geometry->geometry->geometryType) && !geometry_is_empty(geometry);
    if (has_instances && command && !is_host(geometry->build)) {
        command->reads_references = true;
        recording->journal->awaits_inputs = true;
    }
    hazards_add_inputs(recording, geometry);
}

/* ---- the recorder */

static void record_build(void *user, const struct build_view *build,
                         const struct geometry_view *geometry)
{
    struct build_call *call = user;
    struct hazard_recording recording;
    build_notes_recorder()->record_build(user, build, geometry);
    hazards_start_build(&recording, call);
    add_structures(&recording, build);
    add_scratch(&recording, build);
    if (geometry)
        add_geometry(&recording, geometry);
    add_micromaps(&recording, build);
}

static void record_geometry(void *user, const struct geometry_view *geometry)
{
    struct build_call *call = user;
    struct hazard_recording recording;
    build_notes_recorder()->record_geometry(user, geometry);
    hazards_start_build(&recording, call);
    add_geometry(&recording, geometry);
}

static void record_indirect(void *user, const struct indirect_view *indirect)
{
    struct build_call *call = user;
    struct hazard_recording recording;
    const struct hazard_use use = {
        .kind = ACCESS_BUILD_INDIRECT_READ, .role = HAZARD_RANGES, .info = indirect->build->index};
    build_notes_recorder()->record_indirect(user, indirect);
    if (!indirect->stride)
        return;
    hazards_start_build(&recording, call);
    hazards_add_elements(
        &recording, &use,
        &(struct hazard_elements){.facts = &indirect->facts,
                                  .count = indirect->build->info->geometryCount,
                                  .stride = *indirect->stride,
                                  .size = sizeof(VkAccelerationStructureBuildRangeInfoKHR)});
}

static void record_nv_build(void *user, const struct nv_call_view *view)
{
    struct build_call *call = user;
    struct hazard_recording recording;
    build_notes_recorder()->record_nv_build(user, view);
    hazards_start_build(&recording, call);
    hazards_add_nv_build(&recording, view);
}

const struct build_recorder *hazards_build_recorder(void)
{
    static const struct build_recorder recorder = {
        .record_build = record_build,
        .record_geometry = record_geometry,
        .record_indirect = record_indirect,
        .record_ranges = build_notes_record_ranges,
        .record_nv_build = record_nv_build,
        .record_nv_input = nv_record_input,
    };
    return &recorder;
}

/* ---- VK_NV_ray_tracing */

static void add_nv_structures(struct hazard_recording *recording, const struct nv_call_view *view)
{
    struct hazard_use use = {.kind = ACCESS_BUILD_ACCEL_READ, .role = HAZARD_SRC};
    if (view->update)
        hazard_recording_add_nv(recording, &use, &view->src_facts);
    use.kind = ACCESS_BUILD_ACCEL_WRITE;
    use.role = HAZARD_TOP_DST;
    hazard_recording_add_nv(recording, &use, &view->dst_facts);
}

static void add_nv_scratch(struct hazard_recording *recording, const struct nv_call_view *view)
{
    const struct nv_size_facts *sizes = &view->dst_facts.sizes;
    if (sizes->known)
        hazards_access_buffer(recording, ACCESS_BUILD_ACCEL_WRITE, HAZARD_SCRATCH, view->scratch,
                              view->scratch_offset,
                              view->update ? sizes->update_scratch : sizes->build_scratch);
}

static void add_nv_input(struct hazard_recording *recording, uint32_t geometry,
                         const struct geometry_input *input, const struct nv_place *place)
{
    const struct hazard_use use = {.kind = ACCESS_BUILD_SHADER_READ,
                                   .role = hazards_role_of(input->role, false),
                                   .geometry = geometry};
    struct memory_bytes bytes;
    if (!resources_find_buffer_bytes(recording->device->resources, place->buffer, &bytes))
        return;
    const struct address_facts facts = {.status = ADDRESS_IN_BUFFER,
                                        .buffer = place->buffer,
                                        .begin = bytes.begin,
                                        .bytes_left = bytes.size};
    const struct hazard_elements elements = {
        .memory_id = bytes.memory_id,
        .facts = &facts,
        .offset = input_extent(place->offset, 1, input->offset, 0),
        .count = input->count,
        .stride = input->stride,
        .size = input->size,
    };
    if (input->is_chosen)
        hazards_add_indexed(recording, &use, &elements);
    else
        hazards_add_elements(recording, &use, &elements);
    if (input->role == INPUT_INSTANCES) {
        if (recording->command)
            recording->command->reads_references = true;
        recording->journal->awaits_inputs = true;
    }
}

static struct nv_place place_of_input(const struct nv_call_view *view, uint32_t geometry,
                                      enum input_role role)
{
    struct nv_place places[NV_PLACES];
    if (role == INPUT_INSTANCES)
        return (struct nv_place){view->instance_data, view->instance_offset};
    nv_places_of(&view->geometries[geometry], places);
    return places[role];
}

static void add_nv_inputs(struct hazard_recording *recording, const struct nv_call_view *view)
{
    const struct build_view *build = &view->build;
    struct geometry_input inputs[GEOMETRY_INPUTS];
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        const uint32_t count = inputs_of_geometry(build->info->flags, &build->geometries[i], NULL,
                                                  &build->ranges[i], inputs);
        for (uint32_t j = 0; j < count; j++) {
            const struct nv_place place = place_of_input(view, i, inputs[j].role);
            if (place.buffer)
                add_nv_input(recording, i, &inputs[j], &place);
        }
    }
}

void hazards_add_nv_build(struct hazard_recording *recording, const struct nv_call_view *view)
{
    add_nv_structures(recording, view);
    add_nv_scratch(recording, view);
    add_nv_inputs(recording, view);
}

/* ---- builds of structures at addresses */

/* How many structures a build of clusters builds may be in device memory: without any it accesses
 * nothing but the count. What is built where is unknown to traces, and to data that builds read. */
void hazards_build_addressed(struct hazard_recording *recording, struct addressed_build *build)
{
    const struct hazard_use anywhere = {
        .kind = build->is_partitioned ? ACCESS_BUILD_ACCEL_WRITE : ACCESS_TRANSFER_WRITE,
        .role = build->is_partitioned ? HAZARD_TOP_DST : HAZARD_DST};
    struct addressed_range ranges[ADDRESSED_MEMBERS];
    const uint32_t count = addressed_ranges(build, addressed_certain_infos(build), ranges);
    hazard_recording_add_anywhere(recording, &anywhere);
    for (uint32_t i = 0; i < count; i++) {
        struct address_facts facts;
        const struct addressed_access access = hazard_access_of(build->is_partitioned, &ranges[i]);
        const struct hazard_use use = {.kind = access.kind, .role = access.role};
        if (!access.is_certain)
            continue;
        resources_look_up_address(recording->device->resources, ranges[i].address, &facts);
        hazards_add_elements(recording, &use,
                             &(struct hazard_elements){.facts = &facts,
                                                       .count = ranges[i].count,
                                                       .stride = ranges[i].stride,
                                                       .size = ranges[i].size});
    }
    if (recording->device->level < LEVEL_CONTENT || !recording->command || !build->is_valid)
        return;
    recording->command->has_accesses = true;
    recording->command->first_build = recording->journal->place_count - 1;
    recording->journal->awaits_inputs = true;
}
