/* SPDX-License-Identifier: Apache-2.0 */
/* Where the indirect command reads its build ranges, and what their maxima need. */
#include <string.h>

#include "case.h"
#include "placing.h"

#define ADDRESS(build) indirect_addresses[build]
#define STRIDE(build) indirect_strides[build]

enum { STEP = sizeof(VkAccelerationStructureBuildRangeInfoKHR) };

/* ---- arrays ---- */

static void put_addresses_at_edge(struct scene *scene)
{
    const size_t size = scene->info_count * sizeof(scene->indirect_addresses[0]);
    scene->indirect_addresses_argument =
        memcpy(bytes_before_unreadable_page(size), scene->indirect_addresses, size);
}

static void put_strides_at_edge(struct scene *scene)
{
    const size_t size = scene->info_count * sizeof(scene->indirect_strides[0]);
    scene->indirect_strides_argument =
        memcpy(bytes_before_unreadable_page(size), scene->indirect_strides, size);
}

/* ---- buffers ---- */

static VkDeviceAddress end_of(const struct test_buffer *buffer)
{
    return buffer->address + buffer->size;
}

/* UNINDEXED has two geometries. */
static void read_to_the_end(struct scene *scene)
{
    scene->ADDRESS(UNINDEXED) = end_of(&scene->indirect) - 2 * STEP;
}

static void read_beyond_the_end(struct scene *scene)
{
    scene->ADDRESS(UNINDEXED) = end_of(&scene->indirect) - 2 * STEP + 4;
}

static void read_nothing_beyond_the_end(struct scene *scene)
{
    scene->ADDRESS(AABBS) = end_of(&scene->indirect) + 64;
    scene->infos[AABBS].geometryCount = 0;
}

static void forget_memory(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, scene->indirect.usage);
    scene->ADDRESS(UNINDEXED) = buffer.address;
    scene_destroy(scene, (uint64_t)buffer.memory);
}

static void read_from(struct scene *scene, VkBufferUsageFlags usage)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, usage);
    scene->ADDRESS(UNINDEXED) = buffer.address + 64;
}

/* ---- sizes ---- */

static void set_dst_size(struct scene *scene, uint32_t build, VkDeviceSize size)
{
    const struct test_buffer buffer = place_buffer(scene);
    scene->infos[build].dstAccelerationStructure =
        scene_accel_in(scene, &buffer, 0, size, scene->infos[build].type);
}

static void shrink_dst(struct scene *scene)
{
    set_dst_size(scene, AABBS, place_size(scene, AABBS) - 1);
}

static void fit_dst(struct scene *scene)
{
    set_dst_size(scene, AABBS, place_size(scene, AABBS));
}

static void shrink_dst_of_update(struct scene *scene)
{
    set_dst_size(scene, UPDATE, place_size(scene, UPDATE) - 1);
}

static void fit_dst_of_update(struct scene *scene)
{
    set_dst_size(scene, UPDATE, place_size(scene, UPDATE));
}

static const struct test_case cases[] = {
    SHARED(RULE(indirect_addresses_are_readable)),
    CASE("indirect_addresses_unreadable", EDITS(UNREADABLE(indirect_addresses_argument)),
         .mutate_twin = put_addresses_at_edge, .path = "pIndirectDeviceAddresses"),
    CASE("indirect_addresses_null", EDITS(SET(indirect_addresses_argument, 0))),
    CASE("indirect_addresses_one_short", .prepare = put_addresses_at_edge,
         EDITS(ADD(indirect_addresses_argument, 1))),

    SHARED(RULE(indirect_strides_are_readable)),
    CASE("indirect_strides_unreadable", EDITS(UNREADABLE(indirect_strides_argument)),
         .mutate_twin = put_strides_at_edge, .path = "pIndirectStrides"),
    CASE("indirect_strides_null", EDITS(SET(indirect_strides_argument, 0))),
    CASE("indirect_strides_one_short", .prepare = put_strides_at_edge,
         EDITS(ADD(indirect_strides_argument, 1))),

    SHARED(RULE(indirect_ranges_are_in_one_buffer)),
    CASE("indirect_address_not_aligned", RULE(indirect_address_is_aligned),
         EITHER_ADD(ADDRESS(UNINDEXED), 2, 4), .path = "pIndirectDeviceAddresses[1]"),
    CASE("indirect_stride_not_aligned", RULE(indirect_stride_is_aligned),
         EITHER_SET(STRIDE(TLAS), STEP + 2, STEP + 4), .path = "pIndirectStrides[3]"),
    CASE("indirect_ranges_beyond_the_end", .mutate = read_beyond_the_end,
         .mutate_twin = read_to_the_end, .path = "pIndirectDeviceAddresses[1]"),
    CASE("indirect_stride_beyond_the_end", EITHER_SET(STRIDE(UNINDEXED), 0x80000000, 0),
         .path = "pIndirectDeviceAddresses[1]"),
    CASE("indirect_address_null", EDITS(SET(ADDRESS(INDEXED), 0)),
         .path = "pIndirectDeviceAddresses[0]"),
    CASE("indirect_address_nowhere", EDITS(SET(ADDRESS(INDEXED), 0x40)),
         .path = "pIndirectDeviceAddresses[0]"),
    CASE("indirect_address_of_nothing", .silent = true, .mutate = read_nothing_beyond_the_end),
    CASE("indirect_buffer_without_memory", RULE(input_buffer_is_bound), .commands = ON_INDIRECT,
         .prepare = forget_memory, TWIN_EDITS(SET(infos[UNINDEXED].geometryCount, 0)), .count = 1,
         .path = "pIndirectDeviceAddresses[1]"),

    SHARED(RULE(dst_is_large_enough_for_max_primitive_counts)),
    CASE("indirect_buffer_of_scratch", RULE(indirect_buffer_has_indirect_usage),
         EITHER_CALL(read_from, SCRATCH_USAGE, SCRATCH_USAGE | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT),
         .path = "pIndirectDeviceAddresses[1]"),
    CASE("dst_too_small_for_maxima", .mutate = shrink_dst, .mutate_twin = fit_dst,
         .path = "pInfos[2].dstAccelerationStructure"),
    CASE("dst_of_update_too_small_for_maxima", .mutate = shrink_dst_of_update,
         .mutate_twin = fit_dst_of_update, .path = "pInfos[4].dstAccelerationStructure"),
};

CASE_LIST(cases_indirect, cases);
