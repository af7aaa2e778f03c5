/* SPDX-License-Identifier: Apache-2.0 */
/* Where the indirect command reads its build ranges, and what their maxima need. */
#include "case.h"
#include "placing.h"

#define ADDRESS(build) indirect_addresses[build]
#define STRIDE(build) indirect_strides[build]

enum { STEP = sizeof(VkAccelerationStructureBuildRangeInfoKHR) };

#define ADDRESSES_AT_EDGE                                                                          \
    PUT_AT_EDGE(indirect_addresses_argument, SCENE_BASE_BUILDS * sizeof(VkDeviceAddress))
#define STRIDES_AT_EDGE PUT_AT_EDGE(indirect_strides_argument, SCENE_BASE_BUILDS * sizeof(uint32_t))

/* ---- buffers ---- */

static void read_from_the_end(struct scene *scene, uint32_t build, VkDeviceSize less)
{
    scene->ADDRESS(build) = scene->indirect.address + scene->indirect.size - less;
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

static void set_dst_size(struct scene *scene, uint32_t build, VkDeviceSize less)
{
    const struct test_buffer buffer = place_buffer(scene);
    scene->infos[build].dstAccelerationStructure = scene_accel_in(
        scene, &buffer, 0, place_size(scene, build) - less, scene->infos[build].type);
}

static const struct test_case cases[] = {
    SHARED(RULE(indirect_addresses_are_readable)),
    CASE("indirect_addresses_unreadable", EDITS(UNREADABLE(indirect_addresses_argument)),
         TWIN_EDITS(ADDRESSES_AT_EDGE), .path = "pIndirectDeviceAddresses"),
    CASE("indirect_addresses_null", EDITS(SET(indirect_addresses_argument, 0))),
    CASE("indirect_addresses_one_short", PREPARE_EDITS(ADDRESSES_AT_EDGE),
         EDITS(ADD(indirect_addresses_argument, 1))),

    SHARED(RULE(indirect_strides_are_readable)),
    CASE("indirect_strides_unreadable", EDITS(UNREADABLE(indirect_strides_argument)),
         TWIN_EDITS(STRIDES_AT_EDGE), .path = "pIndirectStrides"),
    CASE("indirect_strides_null", EDITS(SET(indirect_strides_argument, 0))),
    CASE("indirect_strides_one_short", PREPARE_EDITS(STRIDES_AT_EDGE),
         EDITS(ADD(indirect_strides_argument, 1))),

    SHARED(RULE(indirect_ranges_are_in_one_buffer), .path = "pIndirectDeviceAddresses[1]"),
    CASE("indirect_address_not_aligned", RULE(indirect_address_is_aligned),
         EITHER_ADD(ADDRESS(UNINDEXED), 2, 4)),
    CASE("indirect_stride_not_aligned", RULE(indirect_stride_is_aligned),
         EITHER_SET(STRIDE(TLAS), STEP + 2, STEP + 4), .path = "pIndirectStrides[3]"),
    CASE("indirect_ranges_beyond_the_end",
         EITHER_CALL_FOR(read_from_the_end, UNINDEXED, 2 * STEP - 4, 2 * STEP)),
    CASE("indirect_stride_beyond_the_end", EITHER_SET(STRIDE(UNINDEXED), 0x80000000, 0)),
    CASE("indirect_address_null", EDITS(SET(ADDRESS(INDEXED), 0)),
         .path = "pIndirectDeviceAddresses[0]"),

    SHARED(RULE(indirect_ranges_are_in_one_buffer)),
    CASE("indirect_address_nowhere", EDITS(SET(ADDRESS(INDEXED), 0x40)),
         .path = "pIndirectDeviceAddresses[0]"),
    CASE("indirect_address_of_nothing", .silent = true,
         EDITS(CALL_FOR(read_from_the_end, AABBS, -64), SET(infos[AABBS].geometryCount, 0))),
    CASE("indirect_buffer_without_memory", RULE(input_buffer_is_bound), .commands = ON_INDIRECT,
         .prepare = forget_memory, TWIN_EDITS(SET(infos[UNINDEXED].geometryCount, 0)), .count = 1,
         .path = "pIndirectDeviceAddresses[1]"),

    SHARED(RULE(dst_is_large_enough_for_max_primitive_counts)),
    CASE("indirect_buffer_of_scratch", RULE(indirect_buffer_has_indirect_usage),
         EITHER_CALL(read_from, SCRATCH_USAGE, SCRATCH_USAGE | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT),
         .path = "pIndirectDeviceAddresses[1]"),
    CASE("dst_too_small_for_maxima", EITHER_CALL_FOR(set_dst_size, AABBS, 1, 0),
         .path = "pInfos[2].dstAccelerationStructure"),
    CASE("dst_of_update_too_small_for_maxima", EITHER_CALL_FOR(set_dst_size, UPDATE, 1, 0),
         .path = "pInfos[4].dstAccelerationStructure"),
};

CASE_LIST(cases_indirect, cases);
