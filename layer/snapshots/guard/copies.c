/* SPDX-License-Identifier: Apache-2.0 */
/* Records guarded copies: their memory, the dispatch of guard.comp, and the parameters that read
 * them. */
#include "layer/snapshots/guard/copies.h"

#include <stdlib.h>
#include <string.h>

#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/guard/execution.h"
#include "layer/snapshots/guard/references.h"
#include "src/base/array.h"
#include "src/model/inputs.h"
#include "src/snapshots/recorded_build.h"

/* As guard.comp has them. */
enum { WITH_POINTERS = 1, WITH_MOTION = 2, OF_NV = 4, OF_PARTITIONS = 8, WITH_CLUSTERS = 16 };
struct constants {
    uint64_t gate, references, order, range, pointers, elements;
    uint32_t count, flags;
};
_Static_assert(sizeof(struct constants) <= SHADER_CONSTANTS_MAX, "they can be pushed");

/* Each of the 64 invocations of a workgroup copies some instances, which costs less on CPUs. */
enum { GROUP_INSTANCES = 512, GROUPS_MAX = 65535, ALIGNMENT = 256, MOTION_STRIDE = 160 };

/* ---- memory */

static uint64_t align(uint64_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

/* Takes `size` bytes of the recording's guarded memory. Returns NULL without memory, or if the
 * budget is full. */
static struct staging_chunk *take_memory(const struct recorder *recorder, uint64_t size,
                                         uint64_t *offset)
{
    struct guard *guard = recorder->device->snapshots->guard;
    struct recording *recording = recorder->recording;
    struct staging_chunk *chunk = (struct staging_chunk *)recording->guarded;
    if (!chunk || align(size) > chunk->chunk.size - chunk->chunk.used) {
        if (staging_take_part(guard_memory(guard), align(size), &chunk) != VK_SUCCESS)
            return NULL;
        chunk->next = (struct staging_chunk *)recording->guarded;
        recording->guarded = &chunk->chunk;
    }
    *offset = chunk->chunk.used;
    chunk->chunk.used += align(size);
    return chunk;
}

void guard_free_copies(const struct guard *guard, struct snapshot_chunk *copies)
{
    for (struct staging_chunk *next, *chunk = (void *)copies; chunk; chunk = next) {
        next = chunk->next;
        staging_give_back(guard_memory(guard), chunk);
    }
}

/* ---- builds that can be guarded */

static bool has_instances(const struct build_parameters *parameters)
{
    return parameters->info.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR &&
           parameters->info.geometryCount == 1 &&
           type_is_instances(parameters->geometries[0].geometryType) &&
           parameters->ranges[0].primitiveCount;
}

/* Returns why a build cannot be guarded here, or NULL. */
static const char *find_obstacle(const struct recorder *recorder, bool is_nv, uint64_t source)
{
    struct buffer_target target;
    if (recorder->device->facts.newer_than_registry)
        return "an enabled extension is not known to the layer";
    if (recorder->cannot_inject || !dispatches_are_allowed(recorder))
        return is_nv && !recorder->device->snapshots->has_addresses
                   ? "the feature bufferDeviceAddress is not enabled"
                   : "the layer cannot add commands in front of them without disturbing the "
                     "application's";
    if (!is_nv && recorder_find(recorder, source, &target) && target.is_protected)
        return "their instances are in a protected buffer";
    return NULL;
}

/* ---- the copy */

struct layout {
    uint64_t element_size, pointers_offset, elements_offset, size;
};

static struct layout layout_of(const struct recorded_build *build, bool has_pointers,
                               bool has_motion)
{
    uint64_t count = build->parameters.ranges[0].primitiveCount;
    struct layout layout = {
        .element_size = has_motion ? MOTION_STRIDE : sizeof(VkAccelerationStructureInstanceKHR)};
    layout.pointers_offset = build->is_indirect ? ALIGNMENT : 0;
    layout.elements_offset =
        layout.pointers_offset + (has_pointers ? align(count * sizeof(uint64_t)) : 0);
    layout.size = layout.elements_offset + count * layout.element_size;
    return layout;
}

/* Reserves a list of `size` bytes; none for 0. */
static bool reserve_list(struct recorder *recorder, uint64_t size, struct snapshot *list)
{
    *list = (struct snapshot){0};
    return !size || recorder_reserve(recorder, size, list);
}

static uint64_t list_address(const struct recorder *recorder, const struct snapshot *list)
{
    return list->size ? snapshot_address(recorder, list) : 0;
}

/* Takes the order, the list of memory ranges for pointers, and that of structures without a handle.
 * Without an order, it lies in a chunk that stays unused. */
static bool take_order(struct recorder *recorder, struct recorded_build *build,
                       const struct build_guard *wanted, bool has_pointers)
{
    struct resources *resources = recorder->device->resources;
    struct build_guard *guard = malloc(sizeof(*guard));
    enum left_out before = recorder->left_out;
    if (guard)
        *guard = *wanted;
    bool is_taken =
        guard && dispatches_prepare(recorder, SHADER_GUARD) &&
        recorder_reserve(recorder, sizeof(struct guard_order), &guard->order) &&
        reserve_list(recorder, has_pointers ? gather_ranges_size(resources) : 0, &guard->ranges) &&
        reserve_list(recorder, guard_places_size(recorder->device), &guard->places);
    recorder->left_out = before; /* the build's inputs are copied nevertheless */
    if (!is_taken) {
        free(guard);
        return false;
    }
    build->guard = guard;
    atomic_init(&guard->limit, GUARD_UNLIMITED);
    *guard_order_of(recorder->recording, guard) = (struct guard_order){
        .source = guard->source,
        .ranges = list_address(recorder, &guard->ranges),
        .places = list_address(recorder, &guard->places),
        .indirect = guard->indirect,
        .readable = GUARD_UNLIMITED,
        .range_count = GUARD_UNLIMITED,
        .limit = GUARD_UNLIMITED,
        .can_read_range = true,
        .place_count = GUARD_UNLIMITED,
    };
    return true;
}

static void dispatch(struct recorder *recorder, const struct constants *constants)
{
    uint32_t groups = constants->count ? (constants->count - 1) / GROUP_INSTANCES + 1 : 1;
    dispatches_add(recorder, SHADER_GUARD, constants, sizeof(*constants),
                   groups < GROUPS_MAX ? groups : GROUPS_MAX);
}

/* VK_NV_ray_tracing names instances by buffer, so a transfer copies them, and the shader works in
 * place. */
static void copy_nv_instances(struct recorder *recorder, VkBuffer instances, VkDeviceSize offset,
                              const struct guarded_copy *copy, uint64_t size)
{
    const VkBufferCopy region = {offset, copy->offset, size};
    const struct own_dependency copied = {
        .src = VK_PIPELINE_STAGE_TRANSFER_BIT,
        .dst = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
        .src_access = VK_ACCESS_TRANSFER_WRITE_BIT,
        .dst_access = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT,
    };
    const VkuDeviceDispatchTable *next = &recorder->device->snapshots->next;
    recorder_start_copies(recorder);
    next->CmdCopyBuffer(recorder->handle, instances, copy->buffer, 1, &region);
    recorder_order_buffer(recorder, copy->buffer, &copied);
}

/* The part of the NV instances that is in the application's buffer; 0 if it cannot be copied. */
static bool nv_source_is_whole(const struct recorder *recorder, VkBuffer instances,
                               VkDeviceSize offset, uint64_t size)
{
    struct buffer_facts facts;
    resources_look_up_buffer(recorder->device->resources, instances, &facts);
    return facts.alive == YES && facts.status == ADDRESS_IN_BUFFER && offset <= facts.size &&
           size <= facts.size - offset &&
           snapshots_can_copy(recorder->device->snapshots, instances);
}

static bool record_guard(struct recorder *recorder, struct recorded_build *build,
                         VkBuffer instances, VkDeviceSize offset, struct guarded_copy *copy)
{
    struct guard *guard = recorder->device->snapshots->guard;
    const struct build_parameters *parameters = &build->parameters;
    bool has_pointers = has_instance_pointers(&parameters->geometries[0]);
    bool has_motion = parameters->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    uint32_t count = parameters->ranges[0].primitiveCount;
    const struct layout layout = layout_of(build, has_pointers, has_motion);
    uint64_t at;
    struct constants constants = {.references = guard_table(guard), .count = count};
    const struct staging_chunk *chunk =
        constants.references ? take_memory(recorder, layout.size, &at) : NULL;
    if (!chunk)
        return false;
    constants.flags = (has_pointers ? WITH_POINTERS : 0) | (has_motion ? WITH_MOTION : 0) |
                      (instances ? OF_NV : 0);
    constants.elements = chunk->buffer.address + at + layout.elements_offset;
    constants.pointers = has_pointers ? chunk->buffer.address + at + layout.pointers_offset : 0;
    constants.range = build->is_indirect ? chunk->buffer.address + at : 0;
    *copy = (struct guarded_copy){.data = has_pointers ? constants.pointers : constants.elements,
                                  .range = constants.range,
                                  .buffer = chunk->buffer.handle,
                                  .offset = chunk->offset + at + layout.elements_offset};
    const struct build_guard wanted = {
        .is_nv = instances,
        .source = instances ? constants.elements
                            : input_address(&parameters->geometries[0], INPUT_INSTANCES),
        .source_size = build->is_indirect
                           ? UINT64_MAX
                           : count * (has_pointers ? sizeof(uint64_t) : layout.element_size),
        .indirect = build->is_indirect ? build->indirect_address : 0,
        .indirect_size = sizeof(VkAccelerationStructureBuildRangeInfoKHR)};
    if (!take_order(recorder, build, &wanted, has_pointers))
        return false;
    constants.gate = recorder->recording->gate.address;
    constants.order = snapshot_address(recorder, &build->guard->order);
    if (instances)
        copy_nv_instances(recorder, instances, offset, copy, count * layout.element_size);
    dispatch(recorder, &constants);
    recorder->recording->has_guards = true;
    return true;
}

/* ---- partitioned structures: copies of the count, of the operations, and of the arrays to which
 * those lead. The operations that write and update instances have one element at most for each. */

enum { OPERATIONS_OFFSET = ALIGNMENT, ARRAYS_OFFSET = 2 * ALIGNMENT, ARRAY_ALIGNMENT = 16 };

static bool record_partitions(struct recorder *recorder, struct recorded_build *build,
                              struct guarded_copy *copy)
{
    struct guard *guard = recorder->device->snapshots->guard;
    const VkBuildPartitionedAccelerationStructureInfoNV *info = &build->addressed->partitions.info;
    const uint64_t arrays = (uint64_t)info->input.instanceCount *
                            (sizeof(VkPartitionedAccelerationStructureWriteInstanceDataNV) +
                             sizeof(VkPartitionedAccelerationStructureUpdateInstanceDataNV)),
                   size = (arrays + 2 * ARRAY_ALIGNMENT - 1) / ARRAY_ALIGNMENT * ARRAY_ALIGNMENT;
    uint64_t at;
    struct constants constants = {
        .references = guard_table(guard),
        .count = info->input.instanceCount,
        .flags =
            OF_PARTITIONS |
            (recorder->device->facts.extension.cluster_acceleration_structure_nv ? WITH_CLUSTERS
                                                                                 : 0)};
    const struct staging_chunk *chunk = constants.references && size <= UINT32_MAX
                                            ? take_memory(recorder, ARRAYS_OFFSET + size, &at)
                                            : NULL;
    if (!chunk)
        return false;
    constants.range = chunk->buffer.address + at;
    constants.pointers = constants.range + OPERATIONS_OFFSET;
    constants.elements = constants.range + ARRAYS_OFFSET;
    *copy = (struct guarded_copy){
        .data = constants.pointers, .range = constants.range, .buffer = chunk->buffer.handle};
    const struct build_guard wanted = {
        .source = info->srcInfos,
        .source_size =
            PARTITION_OPERATIONS * sizeof(VkBuildPartitionedAccelerationStructureIndirectCommandNV),
        .indirect = info->srcInfosCount,
        .indirect_size = sizeof(uint32_t)};
    if (!take_order(recorder, build, &wanted, true))
        return false;
    constants.gate = recorder->recording->gate.address;
    constants.order = snapshot_address(recorder, &build->guard->order);
    dispatch(recorder, &constants);
    recorder->recording->has_guards = true;
    return true;
}

/* ---- all builds */

/* Records a copy of a build's instances that guard.comp writes. Returns false if the build has no
 * instances, or goes down unguarded. For vkCmdBuildAccelerationStructureNV, `instances` is the
 * application's buffer at that offset; else VK_NULL_HANDLE. */
static bool guard_copy(struct recorder *recorder, struct recorded_build *build, VkBuffer instances,
                       VkDeviceSize offset, struct guarded_copy *copy)
{
    struct guard *guard = recorder->device->snapshots->guard;
    const bool is_partitioned = build->addressed;
    if (!guard || !(is_partitioned || has_instances(&build->parameters)))
        return false;
    const char *obstacle = find_obstacle(
        recorder, instances,
        is_partitioned ? build->addressed->partitions.info.srcInfos
                       : input_address(&build->parameters.geometries[0], INPUT_INSTANCES));
    if (!obstacle && instances &&
        !nv_source_is_whole(recorder, instances, offset,
                            build->parameters.ranges[0].primitiveCount *
                                sizeof(VkAccelerationStructureInstanceKHR)))
        obstacle = "the layer cannot copy their instances";
    if (!obstacle && (is_partitioned ? record_partitions(recorder, build, copy)
                                     : record_guard(recorder, build, instances, offset, copy)))
        return true;
    guard_warn_unguarded(guard, obstacle ? obstacle : GUARD_LACKS_MEMORY);
    return false;
}

/* Makes the copies in the buffer of `copy` visible to the builds of the command. Called after the
 * last copy. */
static void guard_end_copy(const struct recorder *recorder, const struct guarded_copy *copy)
{
    const struct own_dependency guarded = {
        .src = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
        .dst = recorder_build_stages(recorder),
        .src_access = VK_ACCESS_SHADER_WRITE_BIT,
        .dst_access = VK_ACCESS_MEMORY_READ_BIT,
    };
    recorder_order_buffer(recorder, copy->buffer, &guarded);
}

/* ---- copies the parameters of calls with guarded builds */

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
