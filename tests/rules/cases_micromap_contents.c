/* SPDX-License-Identifier: Apache-2.0 */
/* The triangles that micromaps of VK_KHR_opacity_micromap are built from, and the indices by which
 * triangles use them. */
#include <string.h>

#include "case.h"

static void set_limits(struct null_driver_config *config)
{
    config->micromap_properties_khr.maxOpacity2StateSubdivisionLevel = 6;
    config->micromap_properties_khr.maxOpacity4StateSubdivisionLevel = 5;
    config->micromap_properties_khr.maxOpacityLossy4StateSubdivisionLevel = 4;
}

static const struct setup with_limits = {
    .configure = set_limits, .enable = ENABLE_OPACITY_MICROMAP_KHR, .level = "content"};
static const struct setup with_content = {.enable = ENABLE_OPACITY_MICROMAP_KHR,
                                          .level = "content"};

/* ---- a micromap of 4 triangles, in place of AABBS ---- */

enum { TRIANGLES_BUILT = 4, LEVEL_OF_NONE = 16 };

static void build_micromap(struct scene *scene)
{
    scene_build_micromap(scene);
    scene->micromaps.usages[0].count = TRIANGLES_BUILT;
}

static void build_lossy_micromap(struct scene *scene)
{
    build_micromap(scene);
    scene->infos[AABBS].flags |= VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR;
    scene->micromaps.usages[0].format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR;
    for (uint32_t i = 0; i < TRIANGLES_BUILT; i++)
        scene->micromaps.triangles[i].format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR;
}

#define TRIANGLE(index, offset, level, format)                                                     \
    WRITE(micromaps.triangle_buffer, uint64_t, sizeof(VkMicromapTriangleKHR) * (index),            \
          (uint64_t)(offset) | (uint64_t)(level) << 32 | (uint64_t)(format) << 48)

#define END SCENE_MICROMAP_INPUT_SIZE /* of the data's buffer */
#define STATES_2 VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR
#define STATES_4 VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR

static void unmap_triangles(struct scene *scene)
{
    scene->vk->UnmapMemory(scene->fixture->device, scene->micromaps.triangle_buffer.memory);
}

/* ---- INDEXED, whose 2 triangles use a micromap of 4 by indices from this offset on ---- */

enum { OPACITY_INDICES = 1024 };

static void use_micromap_of(struct scene *scene, VkIndexType type, uint32_t stride)
{
    scene_use_micromap(scene);
    scene->micromaps.opacity.micromap = scene_record_micromap(scene, TRIANGLES_BUILT);
    scene->micromaps.opacity.indexBuffer = scene->indices.address + OPACITY_INDICES;
    scene->micromaps.opacity.indexType = type;
    scene->micromaps.opacity.indexStride = stride;
}

static void use_micromap(struct scene *scene)
{
    use_micromap_of(scene, VK_INDEX_TYPE_UINT32, sizeof(uint32_t));
}

static void use_micromap_by_short_indices(struct scene *scene)
{
    use_micromap_of(scene, VK_INDEX_TYPE_UINT16, 6);
}

static void use_micromap_without_indices(struct scene *scene)
{
    use_micromap(scene);
    scene->micromaps.opacity.indexType = VK_INDEX_TYPE_NONE_KHR;
    scene->micromaps.opacity.indexBuffer = 0;
}

static void use_clone_of_micromap(struct scene *scene)
{
    use_micromap(scene);
    const VkAccelerationStructureKHR clone =
        scene_micromap_structure(scene, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    scene_copy(scene, scene->micromaps.opacity.micromap, clone,
               VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    scene->micromaps.opacity.micromap = clone;
}

static void use_deserialized_micromap(struct scene *scene)
{
    use_micromap(scene);
    scene_deserialize(scene, scene->micromaps.opacity.micromap);
}

static void set_special_indices(struct scene *scene)
{
    memset(scene->indices.host + OPACITY_INDICES, 0xff, 16);
}

static void use_no_micromap(struct scene *scene)
{
    use_micromap(scene);
    scene->micromaps.opacity.micromap = VK_NULL_HANDLE;
    set_special_indices(scene);
    scene_inputs_remember(scene);
}

#define INDEX(offset, type, value) WRITE(indices, type, OPACITY_INDICES + (offset), value)

#define LEADS_TO(index)                                                                            \
    "pInfos[2].pGeometries[0].pNext<VkAccelerationStructureGeometryMicromapDataKHR>."              \
    "triangleArray leads to triangle " #index ", "
#define HAS_INDEX                                                                                  \
    "pInfos[0].pGeometries[0].geometry.triangles.pNext"                                            \
    "<VkAccelerationStructureTrianglesOpacityMicromapKHR>.indexBuffer has index "

static const struct test_case cases[] = {
    SHARED(RULE(micromap_triangle_data_is_in_its_buffer), .commands = ON_DEVICE,
           .setup = &with_content, .prepare = build_micromap, .is_for_contents = true),
    CASE("micromap_byte_past_the_end", EDITS(TRIANGLE(2, END, 0, STATES_2)),
         TWIN_EDITS(TRIANGLE(2, END - 1, 0, STATES_2)),
         .path = LEADS_TO(2) "which needs 1 byte at dataOffset 65536, but the buffer has 65536 "
                             "bytes from data on"),
    CASE("micromap_data_past_the_end", EDITS(TRIANGLE(3, END - 7, 3, STATES_2)),
         TWIN_EDITS(TRIANGLE(3, END - 8, 3, STATES_2)), .path = LEADS_TO(3) "which needs 8 bytes"),
    CASE("micromap_data_of_4_states_past_the_end", EDITS(TRIANGLE(0, END - 15, 3, STATES_4)),
         TWIN_EDITS(TRIANGLE(0, END - 16, 3, STATES_4)),
         .path = LEADS_TO(0) "which needs 16 bytes"),
    CASE("micromap_data_far_beyond", EDITS(TRIANGLE(1, UINT32_MAX, 0, STATES_2)),
         TWIN_EDITS(TRIANGLE(TRIANGLES_BUILT, UINT32_MAX, 99, 99)), .path = LEADS_TO(1)),
    CASE("micromap_data_past_the_end_at_a_stride",
         PREPARE_EDITS(SET(micromaps.data.triangleArrayStride, 2 * sizeof(VkMicromapTriangleKHR))),
         EDITS(TRIANGLE(2, END, 0, STATES_2)), TWIN_EDITS(TRIANGLE(1, UINT32_MAX, 99, 99)),
         .path = LEADS_TO(1)),
    CASE("micromap_format_undefined", RULE(micromap_triangle_format_is_valid),
         EDITS(TRIANGLE(1, 0, 0, 3)), TWIN_EDITS(TRIANGLE(3, 0, 5, STATES_4)),
         .path = LEADS_TO(1) "whose format 3 is not"),
    CASE("micromap_format_zero", RULE(micromap_triangle_format_is_valid),
         EDITS(TRIANGLE(0, 0, 0, 0)), TWIN_EDITS(TRIANGLE(TRIANGLES_BUILT, UINT32_MAX, 99, 99)),
         .path = LEADS_TO(0)),
    CASE("micromap_format_zero_of_large_level", RULE(micromap_triangle_format_is_valid),
         EDITS(TRIANGLE(0, 0, UINT16_MAX, 0)), .path = LEADS_TO(0)),

    SHARED(.commands = ON_DEVICE, .setup = &with_limits, .prepare = build_micromap,
           .is_for_contents = true),
    CASE("micromap_level_of_2_states", RULE(triangle_2_state_level_is_within_limit),
         EDITS(TRIANGLE(1, 0, 7, STATES_2)), TWIN_EDITS(TRIANGLE(1, 0, 6, STATES_2)),
         .path = LEADS_TO(1) "whose subdivisionLevel 7 with format 1 exceeds "
                             "maxOpacity2StateSubdivisionLevel (6)"),
    CASE("micromap_level_of_4_states", RULE(triangle_4_state_level_is_within_limit),
         .refusal = &indirect_takes_no_micromap, EDITS(TRIANGLE(3, 0, 6, STATES_4)),
         TWIN_EDITS(TRIANGLE(3, 0, 5, STATES_4)),
         .path = LEADS_TO(3) "whose subdivisionLevel 6 with format 2"),
    CASE("lossy_micromap_level", RULE(lossy_triangle_level_is_within_limit),
         .refusal = &indirect_takes_no_micromap, .prepare = build_lossy_micromap,
         EDITS(TRIANGLE(3, 0, 5, STATES_4)), TWIN_EDITS(TRIANGLE(3, 0, 4, STATES_4)),
         .path = LEADS_TO(3) "whose subdivisionLevel 5"),
    CASE("micromap_level_of_2_states_beyond_any", RULE(triangle_2_state_level_is_within_limit),
         .setup = &with_content, EDITS(TRIANGLE(1, 0, LEVEL_OF_NONE, STATES_2)),
         TWIN_EDITS(TRIANGLE(1, 0, 6, STATES_2)),
         .path = LEADS_TO(1) "whose subdivisionLevel 16 with format 1"),

    SHARED(.commands = ON_DEVICE, .refusal = &indirect_takes_no_micromap, .setup = &with_content,
           .prepare = build_lossy_micromap, .is_for_contents = true),
    CASE("micromap_level_of_4_states_beyond_any", RULE(triangle_4_state_level_is_within_limit),
         .prepare = build_micromap, EDITS(TRIANGLE(3, 0, LEVEL_OF_NONE, STATES_4)),
         TWIN_EDITS(TRIANGLE(3, 0, 5, STATES_4)),
         .path = LEADS_TO(3) "whose subdivisionLevel 16 with format 2"),
    CASE("lossy_micromap_level_beyond_any", RULE(lossy_triangle_level_is_within_limit),
         EDITS(TRIANGLE(3, 0, LEVEL_OF_NONE, STATES_4)), TWIN_EDITS(TRIANGLE(3, 0, 4, STATES_4)),
         .path = LEADS_TO(3) "whose subdivisionLevel 16"),
    CASE("lossy_micromap_of_2_states", RULE(lossy_triangle_is_4_state),
         EDITS(TRIANGLE(2, 0, 4, STATES_2)), TWIN_EDITS(TRIANGLE(3, 0, 4, STATES_4)),
         .path = LEADS_TO(2) "whose format 1 is not"),

    SHARED(.commands = ON_HOST, .setup = &with_content, .may_fail_on_cpu = true,
           .is_for_the_call = true),
    CASE("host_micromap_level_of_4_states", RULE(triangle_4_state_level_is_within_limit),
         .mutate = build_micromap, EDITS(TRIANGLE(3, 0, LEVEL_OF_NONE, STATES_4)),
         .mutate_twin = build_micromap, TWIN_EDITS(TRIANGLE(3, 0, 5, STATES_4)),
         .path = LEADS_TO(3) "whose subdivisionLevel 16 with format 2"),
    CASE("lossy_host_micromap_level", RULE(lossy_triangle_level_is_within_limit),
         .mutate = build_lossy_micromap, EDITS(TRIANGLE(3, 0, LEVEL_OF_NONE, STATES_4)),
         .mutate_twin = build_lossy_micromap, TWIN_EDITS(TRIANGLE(3, 0, 4, STATES_4)),
         .path = LEADS_TO(3) "whose subdivisionLevel 16"),
    CASE("lossy_host_micromap_of_2_states", RULE(lossy_triangle_is_4_state),
         .mutate = build_lossy_micromap, EDITS(TRIANGLE(2, 0, 4, STATES_2)),
         .mutate_twin = build_lossy_micromap, TWIN_EDITS(TRIANGLE(3, 0, 4, STATES_4)),
         .path = LEADS_TO(2) "whose format 1 is not"),
    CASE("host_micromap_not_mapped", RULE(triangle_4_state_level_is_within_limit), .silent = true,
         .mutate = build_micromap,
         EDITS(TRIANGLE(3, 0, LEVEL_OF_NONE, STATES_4), CALL(unmap_triangles))),

    SHARED(RULE(opacity_triangles_are_within_micromap), .commands = ON_INDIRECT,
           .setup = &with_content, .prepare = use_micromap_without_indices,
           .is_for_contents = true),
    CASE("lossless_micromap_of_2_states", RULE(lossy_triangle_is_4_state), .silent = true,
         .commands = ON_DEVICE, .prepare = build_micromap, EDITS(TRIANGLE(2, 0, 4, STATES_2))),
    /* The device's command is judged before: it says how many triangles it has. */
    CASE("opacity_without_indices_past_the_end", EITHER_SET(micromaps.opacity.baseTriangle, 4, 3),
         .path = "baseTriangle 4 and 2 triangles in the build range reach triangle 5"),
    CASE("opacity_without_indices_of_no_triangle", .silent = true,
         EDITS(SET(micromaps.opacity.baseTriangle, 4), SET(ranges[INDEXED][0].primitiveCount, 0))),

    SHARED(RULE(opacity_index_is_within_micromap), .commands = ON_DEVICE, .setup = &with_content,
           .prepare = use_micromap, .is_for_contents = true),
    CASE("opacity_index_past_the_end", EDITS(INDEX(4, uint32_t, 5)),
         TWIN_EDITS(INDEX(4, uint32_t, 4)), .path = HAS_INDEX "5 for primitive 1"),
    CASE("opacity_index_largest", EDITS(INDEX(0, uint32_t, INT32_MAX)),
         TWIN_EDITS(INDEX(0, uint32_t, VK_OPACITY_MICROMAP_SPECIAL_INDEX_FULLY_TRANSPARENT_KHR)),
         .path = HAS_INDEX "2147483647 for primitive 0"),
    CASE("opacity_index_past_the_end_by_base",
         PREPARE_EDITS(SET(micromaps.opacity.baseTriangle, 2)), EDITS(INDEX(4, uint32_t, 3)),
         TWIN_EDITS(INDEX(4, uint32_t, 2)),
         .path = HAS_INDEX "3 for primitive 1, which plus baseTriangle 2 is beyond the 4"),
    CASE("opacity_short_index_past_the_end", .prepare = use_micromap_by_short_indices,
         EDITS(INDEX(6, uint16_t, 5)),
         TWIN_EDITS(INDEX(6, uint16_t, VK_OPACITY_MICROMAP_SPECIAL_INDEX_FULLY_UNKNOWN_OPAQUE_KHR)),
         .path = HAS_INDEX "5 for primitive 1"),
    CASE("opacity_index_past_the_end_of_clone", .prepare = use_clone_of_micromap,
         EDITS(INDEX(4, uint32_t, 5)), TWIN_EDITS(INDEX(4, uint32_t, 4)), .path = HAS_INDEX "5"),
    CASE("opacity_index_of_no_triangle", .silent = true, EDITS(INDEX(8, uint32_t, 5))),

    SHARED(RULE(opacity_index_without_micromap_is_special), .commands = ON_DEVICE,
           .setup = &with_content, .prepare = use_no_micromap, .is_for_contents = true),
    CASE("opacity_index_into_deserialized_micromap", RULE(opacity_index_is_within_micromap),
         .silent = true, .prepare = use_deserialized_micromap, EDITS(INDEX(4, uint32_t, 5))),
    CASE("opacity_index_without_micromap", EDITS(INDEX(4, uint32_t, 0)),
         TWIN_EDITS(INDEX(4, uint32_t, VK_OPACITY_MICROMAP_SPECIAL_INDEX_FULLY_UNKNOWN_OPAQUE_KHR)),
         .path = HAS_INDEX "0 for primitive 1"),
    CASE("opacity_index_negative_without_micromap", EDITS(INDEX(4, uint32_t, -6)),
         TWIN_EDITS(INDEX(4, uint32_t, VK_OPACITY_MICROMAP_SPECIAL_INDEX_FULLY_UNKNOWN_OPAQUE_KHR)),
         .path = HAS_INDEX "4294967290"),
    CASE("opacity_byte_index_without_micromap",
         PREPARE_EDITS(SET(micromaps.opacity.indexType, VK_INDEX_TYPE_UINT8_KHR),
                       SET(micromaps.opacity.indexStride, 1)),
         EDITS(INDEX(1, uint8_t, 1)),
         TWIN_EDITS(INDEX(1, uint8_t, VK_OPACITY_MICROMAP_SPECIAL_INDEX_FULLY_OPAQUE_KHR)),
         .path = HAS_INDEX "1 for primitive 1"),
    CASE("opacity_index_beyond_of_no_triangle_and_micromap", .silent = true,
         EDITS(INDEX(8, uint32_t, 5))),
};

CASE_LIST(cases_micromap_contents, cases);
