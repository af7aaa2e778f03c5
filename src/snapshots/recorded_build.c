/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of command buffers: their parameters and snapshots. */
#include "src/snapshots/recorded_build.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/model/inputs.h"

/* ---- parameters */

/* Copies the chained input without micromap usages, which stay in `from` because normalization does
 * not change them. */
static bool keep_chained(const struct build_parameters *from, struct build_parameters *to)
{
    uint32_t count = from->info.geometryCount;
    to->chained = calloc(count, sizeof(*to->chained));
    for (uint32_t i = 0; to->chained && i < count; i++) {
        to->chained[i] = from->chained[i];
        to->chained[i].micromap = (struct micromap_parameters){0};
    }
    return to->chained;
}

static bool keep_given(struct recorded_build *build)
{
    const struct build_parameters *from = &build->parameters;
    struct build_parameters *to = &build->given;
    uint32_t count = from->info.geometryCount;
    to->info = from->info;
    to->had_chains = from->had_chains;
    if (build_parameters_allocate(to, count) != VK_SUCCESS)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        to->geometries[i] = from->geometries[i];
        to->ranges[i] = from->ranges[i];
    }
    return !from->chained || keep_chained(from, to);
}

const struct build_parameters *recorded_build_given(const struct recorded_build *build)
{
    return build->given.geometries ? &build->given : &build->parameters;
}

bool recorded_build_normalize(struct recorded_build *build)
{
    if (!keep_given(build))
        return false;
    for (uint32_t i = 0; i < build->parameters.info.geometryCount; i++) {
        VkAccelerationStructureGeometryKHR *geometry = &build->parameters.geometries[i];
        VkAccelerationStructureBuildRangeInfoKHR *range = &build->parameters.ranges[i];
        struct chained_input *chained =
            build->parameters.chained ? &build->parameters.chained[i] : NULL;
        struct geometry_input inputs[GEOMETRY_INPUTS];
        const uint32_t count =
            inputs_of_geometry(build->parameters.info.flags, geometry, chained, range, inputs);
        for (uint32_t j = 0; j < count; j++) {
            const struct geometry_input *input = &inputs[j];
            input_place(geometry, chained, input->role)->deviceAddress =
                input_extent(input->address.deviceAddress, 1, input->offset, 0);
        }
        if (type_is_triangles(geometry->geometryType))
            geometry->geometry.triangles.maxVertex -=
                (uint32_t)smaller_of(range->firstVertex, geometry->geometry.triangles.maxVertex);
        *range =
            (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = range->primitiveCount};
    }
    return true;
}

bool recorded_build_read_range(const struct recorded_build *build,
                               const struct input_memory *memory, uint32_t geometry,
                               VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const void *bytes;
    uint64_t address = build->indirect_address + geometry * build->indirect_stride;
    if (!type_takes_range(build->parameters.geometries[geometry].geometryType)) {
        *range = build->parameters.ranges[geometry];
        return true;
    }
    *range = (VkAccelerationStructureBuildRangeInfoKHR){0};
    if (memory->find(memory->context, address, sizeof(*range), &bytes) < sizeof(*range))
        return false;
    memcpy(range, bytes, sizeof(*range));
    return true;
}

void recorded_build_read_ranges(const struct recorded_build *build,
                                const struct input_memory *memory,
                                VkAccelerationStructureBuildRangeInfoKHR *ranges)
{
    for (uint32_t i = 0; i < build->parameters.info.geometryCount; i++) {
        const VkAccelerationStructureBuildRangeInfoKHR *most = &build->parameters.ranges[i];
        recorded_build_read_range(build, memory, i, &ranges[i]);
        if (ranges[i].primitiveCount > most->primitiveCount)
            ranges[i].primitiveCount = most->primitiveCount;
    }
}

/* ---- snapshots */

bool recorded_build_add(struct recorded_build *build, const struct snapshot *snapshot)
{
    if (!ARRAY_HAS_ROOM(build->snapshots, build->snapshot_count, build->snapshot_capacity))
        return false;
    build->snapshots[build->snapshot_count++] = *snapshot;
    return true;
}

struct gathering *recorded_build_add_gathering(struct recorded_build *build,
                                               const struct gathering *gathering)
{
    struct gathering *added = &build->gathering;
    if (added->count && (added = malloc(sizeof(*added)))) {
        *added = *gathering;
        added->next = build->gathering.next;
        build->gathering.next = added;
    } else if (added) {
        *added = *gathering;
    }
    return added;
}

static bool holds(const struct snapshot *snapshot, uint64_t address)
{
    return snapshot->address <= address && address - snapshot->address < snapshot->size;
}

/* Returns the snapshot that extends furthest if several overlap. */
const struct snapshot *snapshot_find(const struct snapshot *snapshots, uint32_t count,
                                     uint64_t address)
{
    const struct snapshot *found = NULL;
    for (uint32_t i = 0; i < count; i++) {
        const struct snapshot *snapshot = &snapshots[i];
        if (holds(snapshot, address) &&
            (!found || snapshot->address + snapshot->size > found->address + found->size))
            found = snapshot;
    }
    return found;
}

static unsigned char *bytes_of(const struct snapshot_memory *memory,
                               const struct snapshot *snapshot)
{
    return memory->bases[snapshot->chunk] + snapshot->offset;
}

/* The number of bytes of a snapshot that the device has copied. */
static uint64_t copied_bytes(struct snapshot_memory *memory, const struct snapshot *snapshot)
{
    const struct copy_orders *orders = &snapshot->orders;
    uint64_t copied = 0;
    for (uint32_t i = 0; i < orders->count && snapshot->size; i++) {
        struct copy_order order;
        memcpy(&order, memory->bases[orders->chunk] + orders->offset + i * sizeof(order),
               sizeof(order));
        if (!order.is_done)
            memory->lacks_copies = true;
        if (!order.is_done || !order.source)
            return order.is_done ? snapshot->size : 0;
        uint64_t part = order.left < order.size ? order.left : order.size;
        copied += part;
        if (part < order.size)
            break;
    }
    return copied;
}

static bool find_copied(struct snapshot_memory *memory)
{
    memory->copied = calloc(memory->count + 1u, sizeof(*memory->copied));
    for (uint32_t i = 0; memory->copied && i < memory->count; i++)
        memory->copied[i] = copied_bytes(memory, &memory->snapshots[i]);
    return memory->copied;
}

/* Repeats the decision of gather.comp. */
static bool was_read(const struct snapshot_memory *memory, const struct gathering *gathering,
                     uint64_t address, uint64_t size)
{
    const struct snapshot *list = &gathering->ranges;
    const uint64_t(*ranges)[2] = (const void *)bytes_of(memory, list);
    uint64_t low = 0, high = list->size / sizeof(ranges[0]);
    while (low < high) {
        uint64_t middle = (low + high) / 2;
        if (ranges[middle][0] <= address)
            low = middle + 1;
        else
            high = middle;
    }
    return low > 0 && address % 4 == 0 && address < ranges[low - 1][1] &&
           size <= ranges[low - 1][1] - address;
}

static uint64_t size_of_type(uint64_t type)
{
    switch (type) {
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV:
        return sizeof(VkAccelerationStructureMatrixMotionInstanceNV);
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV:
        return sizeof(VkAccelerationStructureSRTMotionInstanceNV);
    default:
        return sizeof(VkAccelerationStructureInstanceKHR);
    }
}

/* Adds the elements whose address has `type` in its `type_bits`. Elements with the same address are
 * equal, so any of them serves. Null pointers have no element. */
static bool add_elements(struct snapshot_memory *memory, uint64_t type_bits, uint64_t type)
{
    const struct gathering *gathering = memory->gathering;
    uint64_t element_size = gathering->elements.size / gathering->count;
    uint64_t size = size_of_type(type);
    uint64_t words = copied_bytes(memory, &gathering->addresses) / sizeof(uint64_t);
    for (uint32_t i = 0; i < gathering->count; i++) {
        uint64_t at = gathering->first + (uint64_t)i * gathering->stride, address;
        if (at >= words)
            break;
        memcpy(&address, bytes_of(memory, &gathering->addresses) + 8 * at, sizeof(address));
        if ((address & type_bits) != type || address == type)
            continue;
        if (memory->omits_unread && !was_read(memory, gathering, address - type, size))
            continue;
        if (!handle_table_set(&memory->gathered, address - type,
                              bytes_of(memory, &gathering->elements) + i * element_size))
            return false;
    }
    return true;
}

/* Adds elements in ascending order of type. If an address occurs with several types, the last one
 * is the largest and contains the others. */
bool snapshot_memory_open(struct snapshot_memory *memory)
{
    const struct gathering *gathering = memory->gathering;
    memory->gathered = (struct handle_table){0};
    memory->lacks_copies = false;
    if (!find_copied(memory))
        return false;
    if (!gathering || !gathering->count || gathering->parts > 1)
        return true;
    uint64_t type_bits = gathering->is_typed ? 0xf : 0;
    uint64_t last =
        gathering->is_typed ? VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV : 0;
    bool is_whole = true;
    for (uint64_t type = 0; type <= last && is_whole; type++)
        is_whole = add_elements(memory, type_bits, type);
    if (!is_whole)
        snapshot_memory_close(memory);
    return is_whole;
}

void snapshot_memory_close(struct snapshot_memory *memory)
{
    handle_table_release(&memory->gathered);
    free(memory->copied);
    memory->copied = NULL;
}

/* Elements behind an address in the middle of those of a base: an array that is gathered is read
 * element by element. The bases may be in elements of another gathering, which are zeros as far as
 * these were not read. */
static uint64_t find_part(struct snapshot_memory *memory, const struct gathering *gathering,
                          uint64_t address, uint64_t size, const void **bytes)
{
    const uint64_t element_size = gathering->elements.size / gathering->count,
                   whole = element_size * gathering->parts;
    const struct snapshot *addresses = &gathering->addresses;
    const uint64_t words =
        (addresses->orders.count ? copied_bytes(memory, addresses) : addresses->size) /
        sizeof(uint64_t);
    for (uint32_t i = 0; i < gathering->count / gathering->parts; i++) {
        const uint64_t at = gathering->first + (uint64_t)i * gathering->stride;
        uint64_t base;
        if (at >= words)
            break;
        memcpy(&base, bytes_of(memory, addresses) + 8 * at, sizeof(base));
        if (!base || address - base >= whole || size > whole - (address - base) ||
            !was_read(memory, gathering, address - (address - base) % element_size, element_size) ||
            !was_read(memory, gathering,
                      base + (address - base + size - 1) / element_size * element_size,
                      element_size))
            continue;
        *bytes = bytes_of(memory, &gathering->elements) + i * whole + (address - base);
        return size;
    }
    return 0;
}

/* A null pointer reads as zeros, as it was gathered. */
static uint64_t find_gathered(struct snapshot_memory *memory, uint64_t address, uint64_t size,
                              const void **bytes)
{
    static const VkAccelerationStructureMotionInstanceDataNV nothing;
    const struct gathering *gathering = memory->gathering;
    *bytes = NULL;
    if (!gathering || !gathering->count)
        return 0;
    for (; gathering && gathering->parts > 1; gathering = gathering->next)
        if (find_part(memory, gathering, address, size, bytes))
            return size;
    if (!gathering)
        return 0;
    *bytes = address ? handle_table_find(&memory->gathered, address) : &nothing;
    uint64_t there = *bytes ? gathering->elements.size / gathering->count : 0;
    return size < there ? size : there;
}

/* Returns the bytes of the snapshot that extends furthest from the address. */
static uint64_t find_bytes(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    struct snapshot_memory *memory = context;
    const struct snapshot *found = NULL;
    uint64_t there = 0;
    for (uint32_t i = 0; i < memory->count; i++) {
        const struct snapshot *snapshot = &memory->snapshots[i];
        uint64_t skipped = address - snapshot->address;
        if (address < snapshot->address || skipped >= memory->copied[i] ||
            memory->copied[i] - skipped <= there)
            continue;
        found = snapshot;
        there = memory->copied[i] - skipped;
    }
    if (!found)
        return find_gathered(memory, address, size, bytes);
    *bytes = bytes_of(memory, found) + (address - found->address);
    return size < there ? size : there;
}

static uint64_t find_left(void *context, uint64_t address)
{
    const struct snapshot_memory *memory = context;
    for (uint32_t i = 0; i < memory->count; i++) {
        const struct snapshot *snapshot = &memory->snapshots[i];
        struct copy_order order;
        if (snapshot->size || snapshot->address != address || !snapshot->orders.count)
            continue;
        memcpy(&order, memory->bases[snapshot->orders.chunk] + snapshot->orders.offset,
               sizeof(order));
        return order.left;
    }
    return 0;
}

struct input_memory snapshot_memory_of(struct snapshot_memory *memory)
{
    return (struct input_memory){.find = find_bytes, .context = memory, .find_left = find_left};
}

void recorded_build_free(struct recorded_build *build)
{
    if (!build)
        return;
    build_parameters_release(&build->parameters);
    build_parameters_release(&build->given);
    free(build->deserialization);
    free(build->addressed);
    free(build->snapshots);
    free(build->guard);
    for (struct gathering *next, *gathering = build->gathering.next; gathering; gathering = next) {
        next = gathering->next;
        free(gathering);
    }
    free(build);
}
