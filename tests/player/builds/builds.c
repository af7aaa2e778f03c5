/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of programs:
 *
 *     build NAME [vertices PLACE] [indices PLACE] [transform PLACE] [boxes PLACE] [micromap NAME]
 *         [scratch PLACE] [indirect PLACE] [update] [src NAME] [primitives COUNT] [and NAME ...]
 *         [opacity-indices PLACE] [flags FLAG|FLAG] [geometries COUNT] [opaque]
 *         [first VERTEX] [offset BYTES]                                  of the range
 *         [max VERTEX] [format NAME] [stride BYTES]                      of vertices
 *         [last-format rgba16] [last-stride BYTES] [last-primitives COUNT]
 *                                  of the last geometry
 *         [plain]                  with indices I0 and transform X0; what follows may change it
 *         [short-indices PLACE] [no-transform]
 *         [micromaps NAME]         this one and those with the next numbers, one for each geometry
 *         [instances PLACE]        on the bottom level, too: it becomes a top-level build
 *         [ranges PLACE]           indirect, and the host writes the ranges
 *         [no-indices]             of spheres
 *         [pointers PLACE]         instances behind pointers
 *     top NAME [NAME...] [instances PLACE] [...]
 *     host build ... [deferred NAME]
 *     build ... with the options of extensions.c and members.c
 *     create NAME fitting ...      a structure of the size that such a build needs
 *     create NAME scratch build | update B0 ...        a buffer for the scratch of such a build
 *
 * A build has 2 primitives unless it says otherwise, reads V0 if it names no input, allows updates
 * and compaction, and has scratch memory of its own. `update` without `src` is in place. A
 * top-level structure has an instance for each name, in a buffer that the host has written, unless
 * `instances` says where they are. */
#include "tests/player/builds/builds.h"
#include "tests/fixture/geometry.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- places */

enum { SCRATCH_SIZE = 64 * 1024, INSTANCES_SIZE = 1024 };

static VkDeviceOrHostAddressKHR place(const struct build_line *line, const char *word)
{
    return play_address_for(line->play, word, line->is_host);
}

VkDeviceOrHostAddressConstKHR build_input(const struct build_line *line, const char *word)
{
    return (VkDeviceOrHostAddressConstKHR){.deviceAddress = place(line, word).deviceAddress};
}

VkDeviceOrHostAddressKHR play_unused_scratch(struct play *play, bool is_host)
{
    const VkDeviceSize offset = play->scratch_used;
    play->scratch_used = (offset + SCRATCH_SIZE) % play->scratch.size;
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
                       .geometryCount = 1, .pGeometries = build->geometries);
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

VkBuildAccelerationStructureFlagsKHR play_flags(const struct play *play, const char *word)
{
    static const struct play_word names[] = {
        {"none", 0},
        {"update", VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR},
        {"compaction", VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR},
        {"fast_trace", VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR},
        {"fast_build", VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR},
        {"displacement_update",
         VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISPLACEMENT_MICROMAP_UPDATE_BIT_NV},
        {"low_memory", VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR},
        {"motion", VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV},
    };
    return (VkBuildAccelerationStructureFlagsKHR)play_words_value(play, word, names,
                                                                  ARRAY_COUNT(names));
}

static void set_transform(struct build_line *line, struct one_build *build, const char *word)
{
    if (word[0] != '@')
        play_init(line->play, (char *[]){"", (char *)(uintptr_t)word, "transform"});
    build->geometry.geometry.triangles.transformData = build_input(line, word);
}

/* An option without an operand. */
static bool read_word(struct build_line *line, struct one_build *build, const char *word)
{
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &build->geometry.geometry.triangles;
    if (play_is(word, "update")) {
        build->info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    } else if (play_is(word, "opaque")) {
        build->geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    } else if (play_is(word, "plain")) {
        triangles->indexData = build_input(line, "I0");
        triangles->indexType = VK_INDEX_TYPE_UINT32;
        set_transform(line, build, "X0");
    } else if (play_is(word, "no-transform")) {
        triangles->transformData.deviceAddress = 0;
    } else if (play_is(word, "no-indices")) { /* of both structures */
        build->chained.spheres.indexType = VK_INDEX_TYPE_NONE_KHR;
        build->chained.spheres.indexData.deviceAddress = 0;
        build->chained.swept.indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV;
    } else if (play_is(word, "list")) {
        build->chained.swept.indexingMode = VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV;
    } else if (play_is(word, "mixed")) {
        build_mix_usages(line->play, build);
    } else {
        return build_read_wild_word(build, word);
    }
    return true;
}

static VkFormat format_of(const struct play *play, const char *name)
{
    static const struct play_word formats[] = {{"rgba16", VK_FORMAT_R16G16B16A16_SFLOAT},
                                               {"rg16", VK_FORMAT_R16G16_SFLOAT},
                                               {"rg32", VK_FORMAT_R32G32_SFLOAT}};
    return (VkFormat)play_words_value(play, name, formats, ARRAY_COUNT(formats));
}

/* An option of vertices and indices. */
static bool read_triangles(struct build_line *line, struct one_build *build, const char *option,
                           const char *word)
{
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &build->geometry.geometry.triangles;
    if (play_is(option, "vertices")) {
        triangles->vertexData = build_input(line, word);
    } else if (play_is(option, "indices") || play_is(option, "short-indices")) {
        triangles->indexData = build_input(line, word);
        triangles->indexType =
            play_is(option, "indices") ? VK_INDEX_TYPE_UINT32 : VK_INDEX_TYPE_UINT16;
    } else if (play_is(option, "transform")) {
        set_transform(line, build, word);
    } else if (play_is(option, "format")) {
        triangles->vertexFormat = format_of(line->play, word);
    } else if (play_is(option, "last-format")) {
        build->last_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    } else if (play_is(option, "opacity-indices")) {
        build->micromap.indexType = VK_INDEX_TYPE_UINT16;
        build->micromap.indexStride = sizeof(uint16_t);
        build->micromap.indexBuffer = build_input(line, word);
        build->opacity.indexType = build->micromap.indexType;
        build->opacity.indexStride = build->micromap.indexStride;
        build->opacity.indexBuffer = build->micromap.indexBuffer.deviceAddress;
    } else if (play_is(option, "micromap") || play_is(option, "micromaps")) {
        attach_micromap(line->play, build, word);
        build->first_micromap = play_is(option, "micromaps") ? (uint32_t)atoi(word + 1) : 0;
    } else {
        return false;
    }
    return true;
}

static void use_instances(struct build_line *line, struct one_build *build, const char *word)
{
    build->geometry = instances_geometry(build_input(line, word).deviceAddress, false);
    build->info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
}

/* Another option with one operand. */
static void read_operand(struct build_line *line, struct one_build *build, const char *option,
                         char *word)
{
    struct play *play = line->play;
    PLAY_REQUIRE(play, word != NULL);
    if (read_triangles(line, build, option, word) ||
        build_read_extension(line, build, option, word) ||
        build_read_wild(line, build, option, word))
        return;
    if (play_is(option, "boxes")) {
        build->geometry =
            boxes_geometry(build_input(line, word).deviceAddress, sizeof(VkAabbPositionsKHR));
    } else if (play_is(option, "instances") || play_is(option, "pointers")) {
        use_instances(line, build, word);
        build->geometry.geometry.instances.arrayOfPointers = play_is(option, "pointers");
    } else if (play_is(option, "scratch")) {
        build->info.scratchData = place(line, word);
    } else if (play_is(option, "indirect") || play_is(option, "ranges")) {
        line->is_indirect = true;
        build->indirect = play_address(play, word);
        build->indirect_place = play_is(option, "ranges") ? word : NULL;
    } else if (play_is(option, "primitives")) {
        build->range.primitiveCount = (uint32_t)play_number(play, word);
        build->geometry.geometry.triangles.maxVertex = 3 * build->range.primitiveCount - 1;
    } else if (play_is(option, "flags")) {
        build->info.flags = play_flags(play, word);
    } else if (play_is(option, "geometries")) {
        build->info.geometryCount = (uint32_t)play_number(play, word);
        PLAY_REQUIRE(play, build->info.geometryCount <= GEOMETRIES);
    } else if (play_is(option, "src")) {
        build->info.srcAccelerationStructure = play_object(play, word)->structure;
    } else if (play_is(option, "deferred")) {
        line->operation = play_object(play, word)->operation;
    } else {
        play_fail(play, option);
    }
}

/* Attaches micromaps with numbers, one to each geometry. */
static void number_micromaps(struct play *play, struct one_build *build)
{
    for (uint32_t i = 0; build->first_micromap && i < build->info.geometryCount; i++) {
        char name[16];
        snprintf(name, sizeof(name), "M%u", build->first_micromap + i);
        build->micromaps[i] = build->micromap;
        build->micromaps[i].micromap = play_object(play, name)->micromap;
        build->geometries[i].geometry.triangles.pNext = &build->micromaps[i];
    }
}

static void set_last(struct one_build *build)
{
    if (!build->info.geometryCount)
        return;
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &build->geometries[build->info.geometryCount - 1].geometry.triangles;
    if (build->last_format)
        triangles->vertexFormat = build->last_format;
    if (build->last_stride)
        triangles->vertexStride = build->last_stride;
    if (build->last_primitives)
        build->counts[build->info.geometryCount - 1] =
            build->ranges[build->info.geometryCount - 1].primitiveCount = build->last_primitives;
}

/* Fills in what the line did not say. */
static void finish(struct build_line *line, struct one_build *build, char **references)
{
    struct play *play = line->play;
    VkAccelerationStructureBuildGeometryInfoKHR *info = &build->info;
    VkAccelerationStructureGeometryDataKHR *data = &build->geometry.geometry;
    if (info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR &&
        !info->srcAccelerationStructure)
        info->srcAccelerationStructure = info->dstAccelerationStructure;
    if (play_has(play, "VK_NV_ray_tracing_motion_blur"))
        info->flags |= VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    if (!info->scratchData.deviceAddress)
        info->scratchData = play_unused_scratch(play, line->is_host);
    if (build->geometry.geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR) {
        while (build->range.primitiveCount < PLAY_ITEMS && references[build->range.primitiveCount])
            build->range.primitiveCount++;
        if (!data->instances.data.deviceAddress)
            data->instances.data = unused_instances(line, references);
    } else if (build->geometry.geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR &&
               !data->triangles.vertexData.deviceAddress) {
        data->triangles.vertexData = build_input(line, "V0");
    }
    if (play->is_unjudged)
        build_bound(line, build);
    for (uint32_t i = 0; i < GEOMETRIES; i++) {
        build->geometries[i] = build->geometry;
        build->ranges[i] = build->range;
        build->counts[i] = build->range.primitiveCount;
    }
    number_micromaps(play, build);
    set_last(build);
    if (build->indirect_place)
        play_write(play, build->indirect_place, build->ranges, sizeof(build->ranges));
    build_point_to_geometries(play, build);
}

/* Reads one build. Returns the words behind it. */
static char **read_build(struct build_line *line, char **words)
{
    char *references[PLAY_ITEMS + 1] = {0};
    struct one_build *build = begin(line, *words++);
    uint32_t count = 0;
    for (; *words && !play_is(*words, "and"); words++) {
        if ((*words)[0] == 'B' && count < PLAY_ITEMS)
            references[count++] = *words;
        else if (!read_word(line, build, words[0])) {
            read_operand(line, build, words[0], words[1]);
            words++;
        }
    }
    finish(line, build, references);
    return *words ? words + 1 : words;
}

/* ---- commands */

/* An array of the call. */
static const void *array_of(const struct build_line *line, const char *name, const void *array,
                            size_t size)
{
    return play_is(line->null_array, name) ? NULL
           : play_is(line->astray_array, name)
               ? BUILD_NOWHERE
               : play_copy_for_call(line->play, array, line->count * size);
}
#define ARRAY_OF(line, name) array_of(line, #name, (line)->name, sizeof((line)->name[0]))

static void execute(struct build_line *line)
{
    struct play *play = line->play;
    for (uint32_t i = 0; i < line->count; i++) {
        const struct one_build *build = &line->builds[i];
        const uint32_t count = build->info.geometryCount;
        line->infos[i] = build->info;
        const VkGeometryTypeKHR type = build->geometry.geometryType;
        line->ranges[i] =
            type == VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX ||
                    type == VK_GEOMETRY_TYPE_MICROMAP_KHR
                ? NULL
                : play_copy_for_call(play, build->ranges, count * sizeof(build->ranges[0]));
        line->addresses[i] = build->indirect;
        if (build->lose_ranges)
            line->ranges[i] = BUILD_NOWHERE;
        line->strides[i] = sizeof(build->range);
        line->counts[i] = build->lose_ranges ? BUILD_NOWHERE
                                             : play_copy_for_call(play, build->counts,
                                                                  count * sizeof(build->counts[0]));
    }
    if (line->is_host)
        play_note(play, play->vk.BuildAccelerationStructuresKHR(play->device, line->operation,
                                                                line->count, ARRAY_OF(line, infos),
                                                                ARRAY_OF(line, ranges)));
    else if (line->is_indirect)
        play->vk.CmdBuildAccelerationStructuresIndirectKHR(
            play_commands(play), line->count, ARRAY_OF(line, infos), ARRAY_OF(line, addresses),
            ARRAY_OF(line, strides), ARRAY_OF(line, counts));
    else
        play->vk.CmdBuildAccelerationStructuresKHR(play_commands(play), line->count,
                                                   ARRAY_OF(line, infos), ARRAY_OF(line, ranges));
}

VkAccelerationStructureBuildSizesInfoKHR play_build_sizes(struct play *play, char **words,
                                                          VkAccelerationStructureBuildTypeKHR type)
{
    struct build_line line = {.play = play};
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    read_build(&line, words);
    play->vk.GetAccelerationStructureBuildSizesKHR(play->device, type, &line.builds[0].info,
                                                   line.builds[0].counts, &sizes);
    return sizes;
}

static void build_on_line(struct build_line *line, char **words)
{
    while (*words)
        words = read_build(line, words);
    execute(line);
}

/* What is deferred reads its parameters until it is complete. */
static void build(struct play *play, char **words, bool is_host)
{
    char **word = words;
    struct build_line line = {.play = play, .is_host = is_host}, *kept = &line;
    while (*word && !play_is(*word, "deferred"))
        word++;
    if (*word) {
        play->keeps_blocks = true;
        kept = play_block(play, sizeof(line));
        *kept = line;
    }
    build_on_line(kept, words);
}

bool play_build(struct play *play, char **words)
{
    const bool is_host = play_is(words[0], "host");
    words += is_host;
    if (play_is(words[0], "micromap")) {
        play_build_micromap(play, words, is_host);
        return true;
    }
    if (play_build_addressed(play, words))
        return true;
    if (!play_is(words[0], "build") && !play_is(words[0], "top"))
        return false;
    if (play->is_nv)
        play_build_nv(play, words);
    else
        build(play, words + 1, is_host);
    return true;
}
