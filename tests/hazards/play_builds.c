/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of cases:
 *
 *     build NAME [vertices PLACE] [indices PLACE] [transform PLACE] [boxes PLACE] [micromap NAME]
 *         [scratch PLACE] [indirect PLACE] [update] [src NAME] [primitives COUNT] [and NAME ...]
 *         [opacity-indices PLACE]
 *         [first VERTEX] [max VERTEX] [format rgba16] [stride BYTES]     of vertices
 *     top NAME [NAME...] [instances PLACE] [...]
 *     micromap NAME [data PLACE] [triangles PLACE] [scratch PLACE]
 *     host build ...
 *
 * A build has 2 primitives unless it says otherwise, reads V0 if it names no input, and has scratch
 * memory of its own.
 * `update` without `src` is in place. A top-level structure has an instance for each name, in a
 * buffer that the host has written, unless `instances` says where they are. */
#include "play.h"
#include "tests/fixture/geometry.h"

#include <stdlib.h>
#include <string.h>

enum { PRIMITIVES = 2, SCRATCH_SIZE = 64 * 1024, INSTANCES_SIZE = 1024 };

struct one_build {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureTrianglesOpacityMicromapEXT micromap;
    VkMicromapUsageEXT usage;
    VkAccelerationStructureBuildRangeInfoKHR range;
    VkDeviceAddress indirect;
};

struct build_line {
    struct play *play;
    struct one_build builds[PLAY_ITEMS];
    uint32_t count;
    bool is_host, is_indirect;
};

/* ---- places */

static VkDeviceOrHostAddressKHR place(const struct build_line *line, const char *word)
{
    return play_address_for(line->play, word, line->is_host);
}

static VkDeviceOrHostAddressConstKHR input(const struct build_line *line, const char *word)
{
    return (VkDeviceOrHostAddressConstKHR){.deviceAddress = place(line, word).deviceAddress};
}

static VkDeviceOrHostAddressKHR unused_scratch(struct play *play, bool is_host)
{
    const VkDeviceSize offset = play->scratch_used;
    play->scratch_used += SCRATCH_SIZE;
    PLAY_REQUIRE(play, play->scratch_used <= play->scratch.size);
    return play_address_in(&play->scratch, offset, is_host);
}

static VkDeviceOrHostAddressConstKHR unused_instances(const struct build_line *line, char **names)
{
    struct play *play = line->play;
    const VkDeviceSize offset = play->instances_used;
    play->instances_used += INSTANCES_SIZE;
    PLAY_REQUIRE(play, play->instances_used <= play->instances.size);
    play_write_instances(play, play->instances.bytes + offset, names, line->is_host);
    return (VkDeviceOrHostAddressConstKHR){
        .deviceAddress = play_address_in(&play->instances, offset, line->is_host).deviceAddress};
}

/* ---- the line */

static struct one_build *begin(struct build_line *line, const char *name)
{
    PLAY_REQUIRE(line->play, line->count < PLAY_ITEMS);
    struct one_build *build = &line->builds[line->count++];
    const bool is_top = name[0] == 'T';
    build->geometry = is_top ? instances_geometry(0, false)
                             : triangles_geometry(0, 3 * PRIMITIVES - 1, VK_INDEX_TYPE_NONE_KHR, 0);
    build->info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                       .type = is_top ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                      : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                       .flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
                                VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
                       .dstAccelerationStructure = play_object(line->play, name)->structure,
                       .geometryCount = 1, .pGeometries = &build->geometry);
    build->range.primitiveCount = is_top ? 0 : PRIMITIVES;
    return build;
}

static void attach_micromap(struct play *play, struct one_build *build, const char *name)
{
    build->usage = (VkMicromapUsageEXT){1, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    build->micromap =
        MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT,
             .indexType = VK_INDEX_TYPE_NONE_KHR, .usageCountsCount = 1,
             .pUsageCounts = &build->usage, .micromap = play_object(play, name)->micromap);
    build->usage.count = PRIMITIVES;
    build->geometry.geometry.triangles.pNext = &build->micromap;
}

/* Reads an option with one operand. */
static void read_operand(struct build_line *line, struct one_build *build, const char *option,
                         const char *word)
{
    struct play *play = line->play;
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &build->geometry.geometry.triangles;
    PLAY_REQUIRE(play, word != NULL);
    if (play_is(option, "vertices")) {
        triangles->vertexData = input(line, word);
    } else if (play_is(option, "indices")) {
        triangles->indexData = input(line, word);
        triangles->indexType = VK_INDEX_TYPE_UINT32;
    } else if (play_is(option, "transform")) {
        play_init(play, (char *[]){"", (char *)(uintptr_t)word, "transform"});
        triangles->transformData = input(line, word);
    } else if (play_is(option, "boxes")) {
        build->geometry =
            boxes_geometry(input(line, word).deviceAddress, sizeof(VkAabbPositionsKHR));
    } else if (play_is(option, "micromap")) {
        attach_micromap(play, build, word);
    } else if (play_is(option, "scratch")) {
        build->info.scratchData = place(line, word);
    } else if (play_is(option, "indirect")) {
        line->is_indirect = true;
        build->indirect = play_address(play, word);
    } else if (play_is(option, "primitives")) {
        build->range.primitiveCount = (uint32_t)atoi(word);
        triangles->maxVertex = 3 * build->range.primitiveCount - 1;
    } else if (play_is(option, "opacity-indices")) {
        build->micromap.indexType = VK_INDEX_TYPE_UINT16;
        build->micromap.indexStride = sizeof(uint16_t);
        build->micromap.indexBuffer = input(line, word);
    } else if (play_is(option, "first")) {
        build->range.firstVertex = (uint32_t)atoi(word);
    } else if (play_is(option, "max")) {
        triangles->maxVertex = (uint32_t)atoi(word);
    } else if (play_is(option, "format")) {
        PLAY_REQUIRE(play, play_is(word, "rgba16"));
        triangles->vertexFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
    } else if (play_is(option, "stride")) {
        triangles->vertexStride = (VkDeviceSize)atoi(word);
    } else if (play_is(option, "src")) {
        build->info.srcAccelerationStructure = play_object(play, word)->structure;
    } else {
        play_fail(play, option);
    }
}

/* Fills in what the line did not say. */
static void finish(struct build_line *line, struct one_build *build, char **references,
                   const char *instances)
{
    struct play *play = line->play;
    VkAccelerationStructureBuildGeometryInfoKHR *info = &build->info;
    VkAccelerationStructureGeometryDataKHR *data = &build->geometry.geometry;
    if (info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR &&
        !info->srcAccelerationStructure)
        info->srcAccelerationStructure = info->dstAccelerationStructure;
    if (!info->scratchData.deviceAddress)
        info->scratchData = unused_scratch(play, line->is_host);
    if (build->geometry.geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR) {
        while (references[build->range.primitiveCount])
            build->range.primitiveCount++;
        data->instances.data =
            instances ? input(line, instances) : unused_instances(line, references);
    } else if (build->geometry.geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR &&
               !data->triangles.vertexData.deviceAddress) {
        data->triangles.vertexData = input(line, "V0");
    }
}

/* Reads one build. Returns the words behind it. */
static char **read_build(struct build_line *line, char **words)
{
    char *references[PLAY_ITEMS + 1] = {0}, *instances = NULL;
    struct one_build *build = begin(line, *words++);
    uint32_t count = 0;
    for (; *words && !play_is(*words, "and"); words++) {
        if (play_is(*words, "update"))
            build->info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        else if (play_is(*words, "instances"))
            instances = *++words;
        else if ((*words)[0] == 'B' && count < PLAY_ITEMS)
            references[count++] = *words;
        else {
            read_operand(line, build, words[0], words[1]);
            words++;
        }
    }
    finish(line, build, references, instances);
    return *words ? words + 1 : words;
}

/* ---- commands */

static void execute(const struct build_line *line)
{
    const struct play *play = line->play;
    VkAccelerationStructureBuildGeometryInfoKHR infos[PLAY_ITEMS];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[PLAY_ITEMS];
    VkDeviceAddress indirect[PLAY_ITEMS];
    uint32_t strides[PLAY_ITEMS];
    const uint32_t *counts[PLAY_ITEMS];
    for (uint32_t i = 0; i < line->count; i++) {
        infos[i] = line->builds[i].info;
        ranges[i] = &line->builds[i].range;
        indirect[i] = line->builds[i].indirect;
        strides[i] = sizeof(line->builds[i].range);
        counts[i] = &line->builds[i].range.primitiveCount;
    }
    if (line->is_host)
        GET(play->vk.BuildAccelerationStructuresKHR(play->device, NULL, line->count, infos,
                                                    ranges));
    else if (line->is_indirect)
        play->vk.CmdBuildAccelerationStructuresIndirectKHR(play_commands(line->play), line->count,
                                                           infos, indirect, strides, counts);
    else
        play->vk.CmdBuildAccelerationStructuresKHR(play_commands(line->play), line->count, infos,
                                                   ranges);
}

static void build_micromap(struct play *play, char **words)
{
    const VkMicromapUsageEXT usage = {PRIMITIVES, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    STRUCT(VkMicromapBuildInfoEXT, info, .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
           .dstMicromap = play_object(play, words[1])->micromap, .usageCountsCount = 1,
           .pUsageCounts = &usage, .triangleArrayStride = sizeof(VkMicromapTriangleEXT));
    char *triangles = "V1";
    info.data.deviceAddress = play_address(play, "V0");
    info.scratchData = unused_scratch(play, false);
    for (words += 2; *words; words += 2) {
        if (play_is(words[0], "data"))
            info.data.deviceAddress = play_address(play, words[1]);
        else if (play_is(words[0], "triangles"))
            triangles = words[1];
        else if (play_is(words[0], "scratch"))
            info.scratchData.deviceAddress = play_address(play, words[1]);
        else
            play_fail(play, words[0]);
    }
    play_init(play, (char *[]){"", triangles, "triangles"});
    info.triangleArray.deviceAddress = play_address(play, triangles);
    play->vk.CmdBuildMicromapsEXT(play_commands(play), 1, &info);
}

bool play_build(struct play *play, char **words)
{
    struct build_line line = {.play = play, .is_host = play_is(words[0], "host")};
    if (line.is_host)
        words++;
    if (play_is(words[0], "micromap")) {
        build_micromap(play, words);
        return true;
    }
    if (!play_is(words[0], "build") && !play_is(words[0], "top"))
        return false;
    for (words++; *words;)
        words = read_build(&line, words);
    execute(&line);
    return true;
}
