/* SPDX-License-Identifier: Apache-2.0 */
/* Gathers instances by a compute shader. */
#include "layer/snapshots/copies/copies.h"

#include <string.h>

/* Push constants, in the layout of gather.comp. */
struct constants {
    uint64_t gate, addresses, ranges, target;
    uint32_t count, range_count, words, typed, first, stride, parts, reserved;
};
_Static_assert(sizeof(VkAccelerationStructureInstanceKHR) == 4 * 16 &&
                   sizeof(VkAccelerationStructureMatrixMotionInstanceNV) == 4 * 28 &&
                   sizeof(VkAccelerationStructureSRTMotionInstanceNV) == 4 * 36,
               "words of elements that have types");
_Static_assert(sizeof(struct constants) <= SHADER_CONSTANTS_MAX, "they can be pushed");

enum { GROUP = 64, GROUPS_MAX = 65535, RANGE_SIZE = 16, SPARE_RANGES = 16 };
/* Bytes of an element if several follow each other: so few that the last one is readable. */
enum { PART_SIZE = 8 };

/* ---- where the shader may read */

struct ranges {
    uint64_t (*at)[2];
    uint32_t count, capacity;
};

static void add_range(void *user, uint64_t begin, uint64_t end)
{
    struct ranges *ranges = user;
    if (ranges->count < ranges->capacity) {
        ranges->at[ranges->count][0] = begin;
        ranges->at[ranges->count][1] = end;
    }
    ranges->count++;
}

bool gather_write_ranges(struct resources *resources, unsigned char *bytes, uint64_t size)
{
    struct ranges ranges = {.at = (void *)bytes, .capacity = (uint32_t)(size / RANGE_SIZE)};
    resources_find_ranges(resources, add_range, &ranges);
    if (ranges.count < ranges.capacity)
        memset(ranges.at[ranges.count], 0xff, (ranges.capacity - ranges.count) * RANGE_SIZE);
    return ranges.count <= ranges.capacity;
}

/* Has room for more ranges, because more may exist when the command executes. */
uint64_t gather_ranges_size(struct resources *resources)
{
    struct ranges ranges = {0};
    resources_find_ranges(resources, add_range, &ranges);
    return (2ull * ranges.count + SPARE_RANGES) * RANGE_SIZE;
}

uint64_t snapshot_address(const struct recorder *recorder, const struct snapshot *snapshot)
{
    const struct staging_chunk *chunk =
        (const struct staging_chunk *)recorder->recording->chunks[snapshot->chunk];
    return chunk->buffer.address + snapshot->offset;
}

static bool list_ranges(struct recorder *recorder, struct snapshot *list)
{
    struct resources *resources = recorder->device->resources;
    if (!recorder_reserve(recorder, gather_ranges_size(resources), list))
        return false;
    gather_write_ranges(resources, snapshot_bytes(recorder->recording, list), list->size);
    return true;
}

void gather_renew_ranges(const struct layer_device *device, const struct recording *recording)
{
    if (!recording->has_gatherings)
        return;
    for (const struct recorded_build *build = recording->builds; build; build = build->next)
        for (const struct gathering *gathering = &build->gathering; gathering;
             gathering = gathering->next) {
            const struct snapshot *list = &gathering->ranges;
            if (list->size && list->chunk < recording->chunk_count)
                gather_write_ranges(device->resources, snapshot_bytes(recording, list), list->size);
        }
}

/* ---- the command */

/* The pointers are in a copy that the layer has just made. */
static void wait_for_addresses(const struct recorder *recorder, const struct snapshot *addresses)
{
    const struct staging_chunk *chunk =
        (const struct staging_chunk *)recorder->recording->chunks[addresses->chunk];
    const struct own_dependency copied = {
        .src = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
        .dst = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
        .src_access = VK_ACCESS_SHADER_WRITE_BIT,
        .dst_access = VK_ACCESS_SHADER_READ_BIT,
    };
    recorder_order_buffer(recorder, chunk->buffer.handle, &copied);
}

bool recorder_gather(struct recorder *recorder, const struct snapshot *addresses,
                     struct gathering *gathering)
{
    const uint64_t words = addresses->size / sizeof(uint64_t);
    const uint64_t address_count =
        words > gathering->first ? (words - gathering->first - 1) / gathering->stride + 1 : 0;
    const uint32_t size = gathering->parts > 1 ? PART_SIZE
                          : gathering->is_typed
                              ? sizeof(VkAccelerationStructureMotionInstanceDataNV)
                              : sizeof(VkAccelerationStructureInstanceKHR);
    const uint64_t all = address_count * gathering->parts;
    const uint32_t count = (uint32_t)all;
    if (!all)
        return false;
    if (all > (uint32_t)GROUP * GROUPS_MAX || !dispatches_prepare(recorder, SHADER_GATHER)) {
        recorder_fail(recorder);
        return false;
    }
    if (!list_ranges(recorder, &gathering->ranges) ||
        !recorder_reserve(recorder, (uint64_t)count * size, &gathering->elements))
        return false;
    const struct constants constants = {
        .gate = recorder->recording->gate.address,
        .addresses = snapshot_address(recorder, addresses),
        .ranges = snapshot_address(recorder, &gathering->ranges),
        .target = snapshot_address(recorder, &gathering->elements),
        .count = count,
        .range_count = (uint32_t)(gathering->ranges.size / RANGE_SIZE),
        .words = size / 4,
        .typed = gathering->is_typed,
        .first = gathering->first,
        .stride = gathering->stride,
        .parts = gathering->parts,
    };
    copy_orders_flush(recorder);
    wait_for_addresses(recorder, addresses);
    dispatches_add(recorder, SHADER_GATHER, &constants, sizeof(constants),
                   (count + GROUP - 1) / GROUP);
    recorder->recording->has_gatherings = true;
    gathering->addresses = *addresses;
    gathering->count = count;
    return true;
}
