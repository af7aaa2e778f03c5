/* SPDX-License-Identifier: Apache-2.0 */
/* Names, and labels of queues:
 *
 *     name NAME TEXT             of a structure, a buffer, or a command buffer that has begun
 *     queue label QUEUE TEXT     queue insert QUEUE TEXT     queue unlabel QUEUE
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

static void name(struct play *play, char **words)
{
    struct play_object *object = play_object(play, words[1]);
    char text[LABEL_SIZE];
    join(play, words + 2, text);
    STRUCT(VkDebugUtilsObjectNameInfoEXT, info, .objectType = VK_OBJECT_TYPE_BUFFER,
           .objectHandle = (uint64_t)object->buffer.handle, .pObjectName = text);
    if (words[1][0] == 'c') {
        PLAY_REQUIRE(play, object->commands != NULL);
        info.objectType = VK_OBJECT_TYPE_COMMAND_BUFFER;
        info.objectHandle = (uint64_t)(uintptr_t)object->commands;
    } else if (words[1][0] == 'B' || words[1][0] == 'T') {
        info.objectType = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
        info.objectHandle = (uint64_t)object->structure;
    }
    GET(play->vk.SetDebugUtilsObjectNameEXT(play->device, &info));
}

bool play_label(struct play *play, char **words)
{
    char text[LABEL_SIZE];
    if (play_is(words[0], "name")) {
        name(play, words);
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
