/* SPDX-License-Identifier: Apache-2.0 */
/* Addresses of input data: given, and aligned. */
#include "addresses.h"

#define PACKED_VERTICES SET(TRIANGLES(INDEXED, 0).vertexFormat, VK_FORMAT_A2B10G10R10_SNORM_PACK32)
#define SHORT_VERTICES SET(TRIANGLES(INDEXED, 0).vertexFormat, VK_FORMAT_R16G16B16A16_SNORM)

static const struct test_case cases[] = {
    /* given */
    CASE("vertex_address_null", RULE(vertex_address_is_given), EDITS(SET(VERTEX, 0)),
         .path = VERTEX_PATH),
    CASE("index_address_null", RULE(index_address_is_given), PREPARE_EDITS(SET(INDEX, 0)),
         TWIN_EDITS(SET(TRIANGLES(INDEXED, 0).indexType, VK_INDEX_TYPE_NONE_KHR)),
         .path = INDEX_PATH),
    CASE("transform_address_null", RULE(transform_address_is_valid), .silent = true,
         .commands = ON_COMMAND_BUFFERS, EDITS(SET(TRANSFORM, 0))),
    CASE("box_address_null", RULE(aabb_address_is_given), EDITS(SET(BOX, 0)), .path = BOX_PATH),
    CASE("instance_address_null", RULE(instance_address_is_given), EDITS(SET(INSTANCE, 0)),
         .path = INSTANCE_PATH),
    CASE("instance_address_null_in_array_of_pointers", RULE(instance_address_is_given),
         EDITS(SET(INSTANCE, 0), SET(INSTANCES(TLAS, 0).arrayOfPointers, VK_TRUE))),
    /* aligned */
    CASE("vertex_address_misaligned", RULE(vertex_address_is_aligned), EITHER_ADD(VERTEX, 2, 4),
         .path = VERTEX_PATH),
    CASE("vertex_address_misaligned_to_16_bits", RULE(vertex_address_is_aligned),
         PREPARE_EDITS(SHORT_VERTICES), EITHER_ADD(VERTEX, 1, 2)),
    CASE("vertex_address_misaligned_to_pack", RULE(vertex_address_is_aligned),
         SETUP(.configure = offer_packed_format), PREPARE_EDITS(PACKED_VERTICES),
         EITHER_ADD(VERTEX, 2, 4)),
    CASE("index_address_misaligned", RULE(index_address_is_aligned), EITHER_ADD(INDEX, 2, 4),
         .path = INDEX_PATH),
    CASE("index_address_misaligned_to_16_bits", RULE(index_address_is_aligned),
         EITHER_ADD(SHORT_INDEX, 1, 2),
         .path = "pInfos[1].pGeometries[1].geometry.triangles.indexData.deviceAddress"),
    CASE("index_address_ignored",
         RULES(RULE_index_address_is_aligned, RULE_input_address_is_in_a_buffer), .silent = true,
         .commands = ON_COMMAND_BUFFERS,
         EDITS(SET(INDEX, WILD + 1), SET(TRIANGLES(INDEXED, 0).indexType, VK_INDEX_TYPE_NONE_KHR))),
    CASE("transform_address_misaligned", RULE(transform_address_is_aligned),
         EITHER_ADD(TRANSFORM, 8, 16), .path = TRANSFORM_PATH),
    CASE("box_address_misaligned", RULE(aabb_address_is_aligned), EITHER_ADD(BOX, 4, 8),
         .path = BOX_PATH),
    CASE("instance_address_misaligned", RULE(instance_array_is_aligned),
         EITHER_ADD(INSTANCE, 8, 16), .path = INSTANCE_PATH),
    CASE("instance_pointers_misaligned", RULE(instance_pointers_are_aligned),
         PREPARE_EDITS(SET(INSTANCES(TLAS, 0).arrayOfPointers, VK_TRUE)),
         EITHER_ADD(INSTANCE, 4, 8), .path = INSTANCE_PATH),
};

CASE_LIST(cases_alignment, cases);
