/* SPDX-License-Identifier: Apache-2.0 */
/* Names, private data, and labels of queues:
 *
 *     name NAME TEXT             gives a structure, a buffer, or a command buffer that has begun
 *                                this name, and a tag
 *     private NAME NAME NUMBER   the number in a slot of the first object, and another one in that
 *                                of the second, until the slots are destroyed
 *     queue label QUEUE TEXT
 *     queue insert QUEUE TEXT
 *     queue unlabel QUEUE
 *
 * TEXT ends with the line or a semicolon; in it, \n is a line feed. */
#include "tests/player/play.h"

#include <stdio.h>
#include <string.h>

enum { LABEL_SIZE = 256 };

static void join(const struct play *play, char **words, char text[LABEL_SIZE])
{
    size_t length = 0;
    PLAY_REQUIRE(play, *words != NULL);
    text[0] = '\0';
    for (; *words && length < LABEL_SIZE; words++)
        length +=
            (size_t)snprintf(text + length, LABEL_SIZE - length, "%s%s", length ? " " : "", *words);
    for (char *feed; (feed = strstr(text, "\\n"));) {
        *feed = '\n';
        memmove(feed + 1, feed + 2, strlen(feed + 1));
    }
}

/* The object that a word names. */
struct named {
    VkObjectType type;
    uint64_t handle;
};

static struct named find_named(struct play *play, const char *word)
{
    const struct play_object *object = play_object(play, word);
    if (word[0] == 'c') {
        PLAY_REQUIRE(play, object->commands != NULL);
        return (struct named){VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)object->commands};
    }
    if (word[0] == 'B' || word[0] == 'T')
        return (struct named){object->is_nv ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                            : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                              (uint64_t)object->structure};
    return (struct named){VK_OBJECT_TYPE_BUFFER, (uint64_t)object->buffer.handle};
}

static void name(struct play *play, char **words)
{
    const struct named named = find_named(play, words[1]);
    char text[LABEL_SIZE];
    join(play, words + 2, text);
    GET(play->vk.SetDebugUtilsObjectNameEXT(
        play->device, &MAKE(VkDebugUtilsObjectNameInfoEXT, .objectType = named.type,
                            .objectHandle = named.handle, .pObjectName = text)));
    GET(play->vk.SetDebugUtilsObjectTagEXT(
        play->device, &MAKE(VkDebugUtilsObjectTagInfoEXT, .objectType = named.type,
                            .objectHandle = named.handle, .tagSize = 4, .pTag = "tag")));
}

/* What a slot has of an object. */
static void expect_private(struct play *play, struct named named, VkPrivateDataSlot slot,
                           uint64_t wanted)
{
    uint64_t found = UINT64_MAX;
    play->vk.GetPrivateData(play->device, named.type, named.handle, slot, &found);
    play_expect_number(play, "private data", found, wanted);
}

static void use_private_data(struct play *play, char **words)
{
    PLAY_REQUIRE(play, words[1] && words[2] && words[3]);
    const struct named objects[] = {find_named(play, words[1]), find_named(play, words[2])};
    const uint64_t value = play_number(play, words[3]);
    const STRUCT(VkPrivateDataSlotCreateInfo, info);
    VkPrivateDataSlot slots[2];
    for (int i = 0; i < 2; i++) {
        GET(play->vk.CreatePrivateDataSlot(play->device, &info, NULL, &slots[i]));
        for (uint64_t j = 0; j < 2; j++) /* the second value replaces the first */
            GET(play->vk.SetPrivateData(play->device, objects[i].type, objects[i].handle, slots[i],
                                        value + (uint64_t)i + j));
    }
    for (uint64_t i = 0; i < 2; i++)
        expect_private(play, objects[i], slots[i], value + i + 1);
    if (objects[0].handle != objects[1].handle)
        expect_private(play, objects[0], slots[1], 0);
    play->vk.DestroyPrivateDataSlot(play->device, slots[0], NULL);
    expect_private(play, objects[1], slots[1], value + 2);
    play->vk.DestroyPrivateDataSlot(play->device, slots[1], NULL);
    GET(play->vk.CreatePrivateDataSlot(play->device, &info, NULL, &slots[0]));
    expect_private(play, objects[0], slots[0], 0);
    play->vk.DestroyPrivateDataSlot(play->device, slots[0], NULL);
}

bool play_label(struct play *play, char **words)
{
    char text[LABEL_SIZE];
    if (play_is(words[0], "name")) {
        name(play, words);
        return true;
    }
    if (play_is(words[0], "private")) {
        use_private_data(play, words);
        return true;
    }
    if (!play_is(words[0], "queue"))
        return false;
    const VkQueue queue = play->queues[play_queue_of(play, words[2])];
    if (play_is(words[1], "unlabel")) {
        play->vk.QueueEndDebugUtilsLabelEXT(queue);
        return true;
    }
    join(play, words + 3, text);
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = text);
    PLAY_REQUIRE(play, play_is(words[1], "label") || play_is(words[1], "insert"));
    if (play_is(words[1], "label"))
        play->vk.QueueBeginDebugUtilsLabelEXT(queue, &label);
    else
        play->vk.QueueInsertDebugUtilsLabelEXT(queue, &label);
    return true;
}
