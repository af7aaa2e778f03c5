/* SPDX-License-Identifier: Apache-2.0 */
/* Members of builds that no other option sets, and arrays that are not where they should be:
 *
 *     [set:MEMBER NUMBER]      a member of the table below
 *     [by-pointers] [hole]     ppGeometries; the first pointer is NULL
 *     [misplaced]              the geometries are misaligned
 *     [null ARRAY] [astray ARRAY]     the pointer is NULL, or leads nowhere: infos, ranges,
 *                              addresses, strides or counts of the call, or the geometries of the
 *                              build; `astray own-ranges`: the build's ranges and counts
 *     [unknown] [astray-chain]        what is chained to geometries has an unknown type, or is
 *                              nowhere */
#include "tests/player/builds/builds.h"

#include <stddef.h>
#include <string.h>

#define MEMBER(name) PLAY_MEMBER(#name, struct one_build, name)
#define TRIANGLES(member) MEMBER(geometry.geometry.triangles.member)

static const struct play_member members[] = {
    /* Options of their own. */
    PLAY_MEMBER("first", struct one_build, range.firstVertex),
    PLAY_MEMBER("offset", struct one_build, range.primitiveOffset),
    PLAY_MEMBER("max", struct one_build, geometry.geometry.triangles.maxVertex),
    PLAY_MEMBER("stride", struct one_build, geometry.geometry.triangles.vertexStride),
    PLAY_MEMBER("last-stride", struct one_build, last_stride),
    PLAY_MEMBER("last-primitives", struct one_build, last_primitives),
    PLAY_MEMBER("triangles", struct one_build, chained.dense.numTriangles),
    PLAY_MEMBER("dense-vertices", struct one_build, chained.dense.numVertices),
    PLAY_MEMBER("max-primitive", struct one_build, chained.dense.maxPrimitiveIndex),
    PLAY_MEMBER("max-geometry", struct one_build, chained.dense.maxGeometryIndex),
    PLAY_MEMBER("size", struct one_build, chained.dense.dataSize),
    /* By `set:`. */
    MEMBER(info.type),
    MEMBER(info.mode),
    MEMBER(info.flags),
    MEMBER(info.geometryCount), /* 0 to 20 */
    MEMBER(range.primitiveCount),
    MEMBER(range.primitiveOffset),
    MEMBER(range.firstVertex),
    MEMBER(range.transformOffset),
    MEMBER(geometry.geometryType),
    MEMBER(geometry.flags),
    TRIANGLES(vertexFormat),
    TRIANGLES(vertexStride),
    TRIANGLES(maxVertex),
    TRIANGLES(indexType),
    MEMBER(geometry.geometry.aabbs.stride),
    MEMBER(usage.count),
    MEMBER(usage.subdivisionLevel),
    MEMBER(usage.format),
    MEMBER(micromap.indexType),
    MEMBER(micromap.indexStride),
    MEMBER(micromap.baseTriangle),
    MEMBER(displaced.indexType),
    MEMBER(displaced.indexStride),
    MEMBER(opacity.indexType),
    MEMBER(opacity.indexStride),
    MEMBER(opacity.indexBuffer),
    MEMBER(opacity.baseTriangle),
    MEMBER(opacity.micromap),
    MEMBER(usage_khr.count),
    MEMBER(usage_khr.subdivisionLevel),
    MEMBER(usage_khr.format),
    MEMBER(chained.spheres.vertexFormat),
    MEMBER(chained.spheres.vertexStride),
    MEMBER(chained.spheres.radiusFormat),
    MEMBER(chained.spheres.radiusStride),
    MEMBER(chained.spheres.indexType),
    MEMBER(chained.spheres.indexStride),
    MEMBER(chained.swept.indexingMode),
};

bool build_read_wild_word(struct one_build *build, const char *word)
{
    const void **chain = build->info.type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR
                             ? &build->geometry.geometry.triangles.pNext
                             : &build->geometry.pNext;
    if (play_is(word, "by-pointers")) {
        build->are_pointers = true;
    } else if (play_is(word, "hole")) {
        build->are_pointers = build->have_hole = true;
    } else if (play_is(word, "misplaced")) {
        build->are_misplaced = true;
    } else if (play_is(word, "unknown")) {
        build->unknown.sType = (VkStructureType)0x7ffffff0;
        *chain = &build->unknown;
    } else if (play_is(word, "astray-chain")) {
        *chain = BUILD_NOWHERE;
    } else {
        return false;
    }
    return true;
}

bool build_read_wild(struct build_line *line, struct one_build *build, const char *option,
                     const char *word)
{
    if (play_is(option, "null") && play_is(word, "geometries")) {
        build->are_null = true;
    } else if (play_is(option, "astray") && play_is(word, "geometries")) {
        build->are_astray = true;
    } else if (play_is(option, "astray") && play_is(word, "usages")) {
        build->micromap.pUsageCounts = build->displaced.pUsageCounts = BUILD_NOWHERE;
    } else if (play_is(option, "astray") && play_is(word, "own-ranges")) {
        build->lose_ranges = true;
    } else if (play_is(option, "null")) {
        line->null_array = word;
    } else if (play_is(option, "astray")) {
        line->astray_array = word;
    } else {
        const bool sets = strncmp(option, "set:", 4) == 0;
        const bool is_member =
            play_set_member(build, members, ARRAY_COUNT(members), option + (sets ? 4 : 0),
                            play_number(line->play, word));
        PLAY_REQUIRE(line->play, is_member || !sets);
        PLAY_REQUIRE(line->play, build->info.geometryCount <= GEOMETRIES);
        return is_member;
    }
    return true;
}

/* A misaligned copy, which ends where its block ends. */
static const void *misplace(struct play *play, const void *array, size_t size)
{
    enum { OFFSET = 4 };
    return memcpy((char *)play_block(play, OFFSET + size) + OFFSET, array, size);
}

void build_point_to_geometries(struct play *play, struct one_build *build)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &build->info;
    const size_t size = info->geometryCount * sizeof(build->geometries[0]);
    const VkAccelerationStructureGeometryKHR *pointers[GEOMETRIES];
    info->pGeometries = build->are_misplaced ? misplace(play, build->geometries, size)
                                             : play_copy_for_call(play, build->geometries, size);
    for (uint32_t i = 0; build->are_pointers && i < info->geometryCount; i++)
        pointers[i] = build->have_hole && i == 0 ? NULL : &info->pGeometries[i];
    if (build->are_pointers) {
        info->pGeometries = NULL;
        info->ppGeometries =
            play_copy_for_call(play, pointers, info->geometryCount * sizeof(pointers[0]));
    }
    if (build->are_null)
        info->pGeometries = NULL;
    if (build->are_astray)
        info->pGeometries = BUILD_NOWHERE;
}

/* ---- bounds */

static void bound(uint32_t *count)
{
    enum { FEW = 5000 };
    *count = *count > FEW ? FEW : *count;
}

static void bound_stride(VkDeviceSize *stride)
{
    enum { WIDE = 1 << 16 };
    *stride = *stride > WIDE && *stride != UINT64_MAX ? WIDE : *stride;
}

void build_bound(const struct build_line *line, struct one_build *build)
{
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &build->geometry.geometry.triangles;
    VkDeviceSize *boxes = &build->geometry.geometry.aabbs.stride;
    const bool is_triangles = build->geometry.geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    if (is_triangles ? triangles->vertexStride == 0 || triangles->pNext
                     : *boxes == 0 || build->geometry.pNext)
        bound(&build->range.primitiveCount);
    if (!line->is_host)
        return;
    bound(&build->range.firstVertex);
    if (is_triangles)
        bound_stride(&triangles->vertexStride);
    else if (build->geometry.geometryType != VK_GEOMETRY_TYPE_INSTANCES_KHR)
        bound_stride(boxes);
}
