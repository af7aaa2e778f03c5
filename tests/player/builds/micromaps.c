/* SPDX-License-Identifier: Apache-2.0 */
/* Micromaps:
 *
 *     micromap NAME [data PLACE] [triangles PLACE] [scratch PLACE] [usage pointer] [mixed PLACE]
 *         [flags NUMBER] [and NAME ...]
 *     clone | compact | serialize | deserialize SRC > DST
 *     query NAME > POOL          of the serialization size if the pool's name begins with PM, of
 *                                the compacted size if it begins with PC
 *     host micromap ...          host clone | serialize | deserialize ...
 *
 * A micromap has 2 triangles; its data are in V0, and the triangles in V1. With `mixed` it has what
 * play_mixed_usages() says, and the triangles are those that the host has written to the place. */
#include "tests/player/play.h"

enum { TRIANGLES = 2 };

static VkDeviceOrHostAddressConstKHR input(struct play *play, const char *word, bool is_host)
{
    return (VkDeviceOrHostAddressConstKHR){.deviceAddress =
                                               play_address_for(play, word, is_host).deviceAddress};
}

const VkMicromapUsageEXT *play_mixed_usages(const struct play *play)
{
    static const VkMicromapUsageEXT opacities[PLAY_MIXED_USAGES] = {
        {2, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
        {1, 1, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT}};
    static const VkMicromapUsageEXT displacements[PLAY_MIXED_USAGES] = {
        {1, 1, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV},
        {1, 0, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV}};
    return play_has(play, "VK_NV_displacement_micromap") ? displacements : opacities;
}

/* Reads one build. Returns the words behind it. */
static char **read_build(struct play *play, char **words, bool is_host,
                         VkMicromapBuildInfoEXT *info)
{
    static const VkMicromapUsageEXT usage = {TRIANGLES, 0, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
    static const VkMicromapUsageEXT *const usage_pointer = &usage;
    char *triangles = "V1";
    *info = MAKE(VkMicromapBuildInfoEXT, .type = play_micromap_type(play),
                 .flags = VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT,
                 .dstMicromap = play_object(play, *words++)->micromap, .usageCountsCount = 1,
                 .pUsageCounts = &usage, .data = input(play, "V0", is_host),
                 .scratchData = play_unused_scratch(play, is_host),
                 .triangleArrayStride = sizeof(VkMicromapTriangleEXT));
    for (; *words && !play_is(*words, "and"); words += 2) {
        if (play_is(words[0], "data")) {
            info->data = input(play, words[1], is_host);
        } else if (play_is(words[0], "triangles")) {
            triangles = words[1];
        } else if (play_is(words[0], "scratch")) {
            info->scratchData = play_address_for(play, words[1], is_host);
        } else if (play_is(words[0], "flags")) {
            info->flags = (VkBuildMicromapFlagsEXT)play_number(play, words[1]);
        } else if (play_is(words[0], "usage") && play_is(words[1], "pointer")) {
            info->pUsageCounts = NULL;
            info->ppUsageCounts = &usage_pointer;
        } else if (play_is(words[0], "mixed")) {
            triangles = words[1];
            info->pUsageCounts = play_mixed_usages(play);
            info->usageCountsCount = PLAY_MIXED_USAGES;
        } else {
            play_fail(play, words[0]);
        }
    }
    if (info->usageCountsCount == 1)
        play_init(play, (char *[]){"", triangles, "triangles"});
    info->triangleArray = input(play, triangles, is_host);
    return *words ? words + 1 : words;
}

/* Records a command, or calls the host's form. */
#define RUN(command, ...)                                                                          \
    (is_host ? play_note(play, play->vk.command(play->device, VK_NULL_HANDLE, __VA_ARGS__))        \
             : play->vk.Cmd##command(play_commands(play), __VA_ARGS__))

void play_build_micromap(struct play *play, char **words, bool is_host)
{
    VkMicromapBuildInfoEXT infos[PLAY_ITEMS];
    uint32_t count = 0;
    for (words++; *words && count < PLAY_ITEMS;)
        words = read_build(play, words, is_host, &infos[count++]);
    RUN(BuildMicromapsEXT, count, infos);
}

static void serialize(struct play *play, char **words, bool is_host)
{
    const STRUCT(VkCopyMicromapToMemoryInfoEXT, info, .mode = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT,
                 .src = play_object(play, words[1])->micromap,
                 .dst = play_address_for(play, words[3], is_host));
    RUN(CopyMicromapToMemoryEXT, &info);
}

static void deserialize(struct play *play, char **words, bool is_host)
{
    const STRUCT(VkCopyMemoryToMicromapInfoEXT, info, .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT,
                 .src = input(play, words[1], is_host),
                 .dst = play_object(play, words[3])->micromap);
    RUN(CopyMemoryToMicromapEXT, &info);
}

static void copy(struct play *play, char **words, bool is_host)
{
    const STRUCT(VkCopyMicromapInfoEXT, info,
                 .mode = play_is(words[0], "compact") ? VK_COPY_MICROMAP_MODE_COMPACT_EXT
                                                      : VK_COPY_MICROMAP_MODE_CLONE_EXT,
                 .src = play_object(play, words[1])->micromap,
                 .dst = play_object(play, words[3])->micromap);
    RUN(CopyMicromapEXT, &info);
}

void play_copy_micromap(struct play *play, char **words, bool is_host)
{
    if (play_is(words[0], "serialize"))
        serialize(play, words, is_host);
    else if (play_is(words[0], "deserialize"))
        deserialize(play, words, is_host);
    else
        copy(play, words, is_host);
}
