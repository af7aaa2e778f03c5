/* SPDX-License-Identifier: Apache-2.0 */
/* Pointers that lead nowhere: null, a small number, a page that may not be read, and arrays that
 * end before their count. */
#include <string.h>

#include "case.h"

#define SMALL 0x10

/* ---- whole arrays ---- */

static void put_infos_at_edge(struct scene *scene)
{
    const size_t size = scene->info_count * sizeof(scene->infos[0]);
    scene->infos_argument = memcpy(bytes_before_unreadable_page(size), scene->infos, size);
}

static void put_ranges_at_edge(struct scene *scene)
{
    const size_t size = scene->info_count * sizeof(scene->range_pointers[0]);
    scene->ranges_argument =
        memcpy(bytes_before_unreadable_page(size), scene->range_pointers, size);
}

static void put_counts_at_edge(struct scene *scene)
{
    const size_t size = scene->info_count * sizeof(scene->count_pointers[0]);
    scene->counts_argument =
        memcpy(bytes_before_unreadable_page(size), scene->count_pointers, size);
}

/* ---- arrays of a build ---- */

static void put_ranges_of_build_at_edge(struct scene *scene)
{
    const size_t size = scene->infos[UNINDEXED].geometryCount * sizeof(scene->ranges[0][0]);
    scene->range_pointers[UNINDEXED] =
        memcpy(bytes_before_unreadable_page(size), scene->ranges[UNINDEXED], size);
}

static void put_geometries_at_edge(struct scene *scene)
{
    const size_t size = scene->infos[UNINDEXED].geometryCount * sizeof(scene->geometries[0][0]);
    scene->infos[UNINDEXED].pGeometries =
        memcpy(bytes_before_unreadable_page(size), scene->geometries[UNINDEXED], size);
}

static void use_pointers(struct scene *scene, uint32_t build)
{
    scene->infos[build].pGeometries = NULL;
    scene->infos[build].ppGeometries = scene->geometry_pointers[build];
}

static void put_pointed_geometry_at_edge(struct scene *scene)
{
    const size_t size = sizeof(scene->geometries[0][0]);
    use_pointers(scene, UNINDEXED);
    scene->geometry_pointers[UNINDEXED][1] =
        memcpy(bytes_before_unreadable_page(size), &scene->geometries[UNINDEXED][1], size);
}

static void put_pointed_geometry_short(struct scene *scene)
{
    const size_t size = sizeof(scene->geometries[0][0]) - 8;
    use_pointers(scene, UNINDEXED);
    scene->geometry_pointers[UNINDEXED][1] =
        memcpy(bytes_before_unreadable_page(size), &scene->geometries[UNINDEXED][1], size);
}

static void put_geometry_pointers_short(struct scene *scene)
{
    const size_t size = sizeof(scene->geometry_pointers[0][0]);
    use_pointers(scene, UNINDEXED);
    scene->infos[UNINDEXED].ppGeometries =
        memcpy(bytes_before_unreadable_page(size), scene->geometry_pointers[UNINDEXED], size);
}

static const struct test_case cases[] = {
    CASE("infos_null", RULE(infos_are_readable), EDITS(SET(infos_argument, 0))),
    CASE("infos_small", RULE(infos_are_readable), EDITS(SET(infos_argument, SMALL))),
    CASE("infos_unreadable", RULE(infos_are_readable), EDITS(UNREADABLE(infos_argument))),
    CASE("infos_end_too_early", RULE(infos_are_readable), .prepare = put_infos_at_edge,
         EDITS(ADD(info_count, 1))),
    CASE("ranges_null", RULE(build_ranges_are_readable), EDITS(SET(ranges_argument, 0))),
    CASE("ranges_small", RULE(build_ranges_are_readable), EDITS(SET(ranges_argument, SMALL))),
    CASE("ranges_unreadable", RULE(build_ranges_are_readable), EDITS(UNREADABLE(ranges_argument))),

    SHARED(RULE(max_primitive_counts_are_readable)),
    CASE("ranges_end_too_early", RULE(build_ranges_are_readable), .prepare = put_ranges_at_edge,
         EDITS(ADD(ranges_argument, 1))),
    CASE("counts_null", EDITS(SET(counts_argument, 0))),
    CASE("counts_small", EDITS(SET(counts_argument, SMALL))),
    CASE("counts_unreadable", EDITS(UNREADABLE(counts_argument))),
    CASE("counts_end_too_early", .prepare = put_counts_at_edge, EDITS(ADD(counts_argument, 1))),

    SHARED(RULE(build_ranges_of_build_are_readable)),
    CASE("ranges_of_build_null", EDITS(SET(range_pointers[AABBS], 0))),
    CASE("ranges_of_build_small", EDITS(SET(range_pointers[INDEXED], SMALL))),
    CASE("ranges_of_build_unreadable", EDITS(UNREADABLE(range_pointers[TLAS]))),
    CASE("ranges_of_build_end_too_early", .prepare = put_ranges_of_build_at_edge,
         EDITS(ADD(range_pointers[UNINDEXED], 1))),

    SHARED(RULE(geometries_are_readable)),
    CASE("geometries_small", EDITS(SET(infos[INDEXED].pGeometries, SMALL)),
         .path = "pInfos[0].pGeometries"),
    CASE("geometries_unreadable", EDITS(UNREADABLE(infos[AABBS].pGeometries))),
    CASE("geometries_end_too_early", .prepare = put_geometries_at_edge,
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
    CASE("geometry_pointers_end_too_early", .mutate = put_geometry_pointers_short),
    CASE("geometry_pointer_null", PREPARE_EDITS(CALL_WITH(use_pointers, UNINDEXED)),
         EDITS(SET(geometry_pointers[UNINDEXED][0], 0))),
    CASE("geometry_pointer_small",
         EDITS(CALL_WITH(use_pointers, UNINDEXED), SET(geometry_pointers[UNINDEXED][1], SMALL))),
    CASE("geometry_pointer_unreadable",
         EDITS(CALL_WITH(use_pointers, UNINDEXED), UNREADABLE(geometry_pointers[UNINDEXED][1]))),
    CASE("geometry_pointer_too_near_the_edge", .mutate = put_pointed_geometry_short,
         .mutate_twin = put_pointed_geometry_at_edge),
};

CASE_LIST(cases_pointers, cases);
