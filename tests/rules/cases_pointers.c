/* SPDX-License-Identifier: Apache-2.0 */
/* Pointers that lead nowhere: null, a small number, a page that may not be read, and arrays that
 * end before their count. */
#include "case.h"

#define SMALL 0x10

static void use_pointers(struct scene *scene, uint32_t build)
{
    scene->infos[build].pGeometries = NULL;
    scene->infos[build].ppGeometries = scene->geometry_pointers[build];
}

#define GEOMETRY_SIZE sizeof(VkAccelerationStructureGeometryKHR)

static const struct test_case cases[] = {
    CASE("infos_null", RULE(infos_are_readable), EDITS(SET(infos_argument, 0))),
    CASE("infos_small", RULE(infos_are_readable), EDITS(SET(infos_argument, SMALL))),
    CASE("infos_unreadable", RULE(infos_are_readable), EDITS(UNREADABLE(infos_argument))),
    CASE("infos_end_too_early", RULE(infos_are_readable),
         PREPARE_EDITS(
             PUT_AT_EDGE(infos_argument,
                         SCENE_BASE_BUILDS * sizeof(VkAccelerationStructureBuildGeometryInfoKHR))),
         EDITS(ADD(info_count, 1))),
    CASE("ranges_null", RULE(build_ranges_are_readable), EDITS(SET(ranges_argument, 0))),
    CASE("ranges_small", RULE(build_ranges_are_readable), EDITS(SET(ranges_argument, SMALL))),
    CASE("ranges_unreadable", RULE(build_ranges_are_readable), EDITS(UNREADABLE(ranges_argument))),

    SHARED(RULE(max_primitive_counts_are_readable)),
    CASE("ranges_end_too_early", RULE(build_ranges_are_readable),
         PREPARE_EDITS(PUT_AT_EDGE(ranges_argument, SCENE_BASE_BUILDS * sizeof(void *))),
         EDITS(ADD(ranges_argument, 1))),
    CASE("counts_null", EDITS(SET(counts_argument, 0))),
    CASE("counts_small", EDITS(SET(counts_argument, SMALL))),
    CASE("counts_unreadable", EDITS(UNREADABLE(counts_argument))),
    CASE("counts_end_too_early",
         PREPARE_EDITS(PUT_AT_EDGE(counts_argument, SCENE_BASE_BUILDS * sizeof(void *))),
         EDITS(ADD(counts_argument, 1))),

    SHARED(RULE(build_ranges_of_build_are_readable)),
    CASE("ranges_of_build_null", EDITS(SET(range_pointers[AABBS], 0))),
    CASE("ranges_of_build_small", EDITS(SET(range_pointers[INDEXED], SMALL))),
    CASE("ranges_of_build_unreadable", EDITS(UNREADABLE(range_pointers[TLAS]))),
    CASE("ranges_of_build_end_too_early",
         PREPARE_EDITS(PUT_AT_EDGE(range_pointers[UNINDEXED],
                                   2 * sizeof(VkAccelerationStructureBuildRangeInfoKHR))),
         EDITS(ADD(range_pointers[UNINDEXED], 1))),

    SHARED(RULE(geometries_are_readable)),
    CASE("geometries_small", EDITS(SET(infos[INDEXED].pGeometries, SMALL)),
         .path = "pInfos[0].pGeometries"),
    CASE("geometries_unreadable", EDITS(UNREADABLE(infos[AABBS].pGeometries))),
    CASE("geometries_end_too_early",
         PREPARE_EDITS(PUT_AT_EDGE(infos[UNINDEXED].pGeometries, 2 * GEOMETRY_SIZE)),
         EDITS(ADD(infos[UNINDEXED].pGeometries, 1))),
    CASE("geometries_unreadable_with_every_other_mistake_hidden",
         EDITS(UNREADABLE(infos[AABBS].pGeometries), SET(ranges[AABBS][0].primitiveOffset, 1))),
    CASE("geometries_unreadable_but_none", .silent = true,
         EDITS(UNREADABLE(infos[AABBS].pGeometries), SET(infos[AABBS].geometryCount, 0))),

    SHARED(RULE(geometry_pointers_are_readable)),
    CASE("geometry_pointers_small",
         EDITS(SET(infos[TLAS].pGeometries, 0), SET(infos[TLAS].ppGeometries, SMALL)),
         .path = "pInfos[3].ppGeometries"),
    CASE("geometry_pointers_unreadable",
         EDITS(CALL_WITH(use_pointers, AABBS), UNREADABLE(infos[AABBS].ppGeometries))),
    CASE("geometry_pointers_end_too_early",
         EDITS(CALL_WITH(use_pointers, UNINDEXED),
               PUT_AT_EDGE(infos[UNINDEXED].ppGeometries, sizeof(void *)))),
    CASE("geometry_pointer_null", PREPARE_EDITS(CALL_WITH(use_pointers, UNINDEXED)),
         EDITS(SET(geometry_pointers[UNINDEXED][0], 0))),
    CASE("geometry_pointer_small",
         EDITS(CALL_WITH(use_pointers, UNINDEXED), SET(geometry_pointers[UNINDEXED][1], SMALL))),
    CASE("geometry_pointer_unreadable",
         EDITS(CALL_WITH(use_pointers, UNINDEXED), UNREADABLE(geometry_pointers[UNINDEXED][1]))),
    CASE("geometry_pointer_too_near_the_edge",
         EDITS(CALL_WITH(use_pointers, UNINDEXED),
               PUT_AT_EDGE(geometry_pointers[UNINDEXED][1], GEOMETRY_SIZE - 8)),
         TWIN_EDITS(CALL_WITH(use_pointers, UNINDEXED),
                    PUT_AT_EDGE(geometry_pointers[UNINDEXED][1], GEOMETRY_SIZE))),
};

CASE_LIST(cases_pointers, cases);
