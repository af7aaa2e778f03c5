/* SPDX-License-Identifier: Apache-2.0 */
/* What no application may do, for programs that are not judged:
 *
 *     ghost NAME                 destroys an object, or frees a command buffer; the name keeps the
 *                                handle. (The handle that `destroy` leaves is null.)
 *     into NAME | @NUMBER        the next commands go to a command buffer in whatever state it is,
 *                                or to a pointer that is none
 *     out                        ends that
 *     bare begin | end | reset NAME | @NUMBER [once | simultaneous]         the call alone
 *     carve NAME PLACE SIZE TYPE           a structure somewhere in a buffer, or behind it
 *     queries NAME TYPE COUNT [STATISTICS] a pool of other queries; TYPE and STATISTICS are numbers
 *     write NAME NAME > POOL TYPE FIRST    the properties of two structures; `host write`
 *     transfer PLACE > PLACE SIZE          vkCmdCopyBuffer, of any bytes
 *     unmap NAME
 *     bind pipeline              push OFFSET SIZE          of a pipeline that is none
 *     rendering [FLAGS]          rendering end
 *     measure POOL               measure end POOL          a query that is active
 *     answer yes | no            of the messenger, from here on */
#include "tests/player/play.h"

#include <string.h>

static struct play_object stray; /* the command buffer of @NUMBER */

static struct play_object *recorded(struct play *play, const char *word)
{
    PLAY_REQUIRE(play, word != NULL);
    if (word[0] != '@')
        return play_object(play, word);
    stray.commands = (VkCommandBuffer)(uintptr_t)play_number(play, word + 1);
    return &stray;
}

/* A driver that gives handles out again may have given this one to another object, also of the
 * layer. */
static void make_ghost(struct play *play, struct play_object *object)
{
    const struct play_object before = *object;
    if (object->is_ghost && program_find(play->program, "driver", "recycles"))
        return;
    object->is_ghost = false;
    if (object->name[0] == 'c')
        play->vk.FreeCommandBuffers(play->device, object->pool, 1, &object->commands);
    else if (play_is_buffer(object))
        play->vk.DestroyBuffer(play->device, object->buffer.handle, NULL);
    else
        play_destroy_object(play, object);
    *object = before;
    object->is_ghost = true;
}

/* ---- command buffers */

static void record_to(struct play *play, const char *name)
{
    play->recording = recorded(play, name);
    PLAY_REQUIRE(play, play->recording->commands != NULL);
}

static void call_bare(struct play *play, char **words)
{
    const VkCommandBuffer commands = recorded(play, words[2])->commands;
    const STRUCT(VkCommandBufferBeginInfo, info,
                 .flags = play_is(words[3], "once") ? VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT
                          : play_is(words[3], "simultaneous")
                              ? VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT
                              : 0,
                 .pInheritanceInfo = &MAKE(VkCommandBufferInheritanceInfo));
    PLAY_REQUIRE(play, commands != NULL);
    if (play_is(words[1], "begin"))
        play_note(play, play->vk.BeginCommandBuffer(commands, &info));
    else if (play_is(words[1], "end"))
        play_note(play, play->vk.EndCommandBuffer(commands));
    else
        play_note(play, play->vk.ResetCommandBuffer(commands, 0));
}

/* ---- objects */

static void carve(struct play *play, char **words)
{
    VkDeviceSize offset;
    const VkBuffer buffer = play_place(play, words[2], &offset)->buffer.handle;
    struct play_object *object = play_object(play, words[1]);
    play_destroy_object(play, object);
    play_create_structure(play, object, buffer, offset, play_number(play, words[3]),
                          (VkAccelerationStructureTypeKHR)play_number(play, words[4]));
}

static void make_queries(struct play *play, char **words)
{
    struct play_object *object = play_object(play, words[1]);
    play_destroy_object(play, object);
    object->is_ghost = false;
    const STRUCT(VkQueryPoolCreateInfo, info, .queryType = (VkQueryType)play_number(play, words[2]),
                 .queryCount = (uint32_t)play_number(play, words[3]),
                 .pipelineStatistics =
                     words[4] ? (VkQueryPipelineStatisticFlags)play_number(play, words[4]) : 0);
    GET(play->vk.CreateQueryPool(play->device, &info, NULL, &object->queries));
}

/* write NAME NAME > POOL TYPE FIRST */
static void write_properties(struct play *play, char **words, bool is_host)
{
    const VkAccelerationStructureKHR structures[] = {play_object(play, words[1])->structure,
                                                     play_object(play, words[2])->structure};
    const VkQueryType type = (VkQueryType)play_number(play, words[5]);
    uint64_t values[2];
    if (is_host)
        play_note(play, play->vk.WriteAccelerationStructuresPropertiesKHR(
                            play->device, 2, structures, type, sizeof(values), values,
                            sizeof(values[0])));
    else
        play->vk.CmdWriteAccelerationStructuresPropertiesKHR(
            play_commands(play), 2, structures, type, play_object(play, words[4])->queries,
            (uint32_t)play_number(play, words[6]));
}

static void transfer(struct play *play, char **words)
{
    VkBufferCopy region = {.size = play_number(play, words[4])};
    const VkBuffer src = play_place(play, words[1], &region.srcOffset)->buffer.handle;
    const VkBuffer dst = play_place(play, words[3], &region.dstOffset)->buffer.handle;
    play->vk.CmdCopyBuffer(play_commands(play), src, dst, 1, &region);
}

/* ---- what is bound, and scopes */

static void push(struct play *play, char **words)
{
    static const unsigned char constants[512];
    const uint32_t size = (uint32_t)play_number(play, words[2]);
    PLAY_REQUIRE(play, size <= sizeof(constants));
    play->vk.CmdPushConstants(play_commands(play), (VkPipelineLayout)(uintptr_t)0x123450,
                              VK_SHADER_STAGE_COMPUTE_BIT, (uint32_t)play_number(play, words[1]),
                              size, constants);
}

static void render(struct play *play, const char *word)
{
    if (play_is(word, "end")) {
        play->vk.CmdEndRendering(play_commands(play));
        return;
    }
    const STRUCT(VkRenderingInfo, info,
                 .flags = word ? (VkRenderingFlags)play_number(play, word) : 0, .layerCount = 1);
    play->vk.CmdBeginRendering(play_commands(play), &info);
}

static void measure(struct play *play, char **words)
{
    if (play_is(words[1], "end"))
        play->vk.CmdEndQuery(play_commands(play), play_object(play, words[2])->queries, 0);
    else
        play->vk.CmdBeginQuery(play_commands(play), play_object(play, words[1])->queries, 0, 0);
}

static bool play_wild_command(struct play *play, char **words)
{
    if (play_is(words[0], "write"))
        write_properties(play, words, false);
    else if (play_is(words[0], "host") && play_is(words[1], "write"))
        write_properties(play, words + 1, true);
    else if (play_is(words[0], "transfer"))
        transfer(play, words);
    else if (play_is(words[0], "bind") && play_is(words[1], "pipeline"))
        play->vk.CmdBindPipeline(play_commands(play), VK_PIPELINE_BIND_POINT_COMPUTE,
                                 (VkPipeline)(uintptr_t)0x123460);
    else if (play_is(words[0], "push"))
        push(play, words);
    else if (play_is(words[0], "rendering"))
        render(play, words[1]);
    else if (play_is(words[0], "measure"))
        measure(play, words);
    else
        return false;
    return true;
}

bool play_wild(struct play *play, char **words)
{
    if (play_is(words[0], "ghost"))
        make_ghost(play, play_object(play, words[1]));
    else if (play_is(words[0], "into"))
        record_to(play, words[1]);
    else if (play_is(words[0], "out"))
        play->recording = NULL;
    else if (play_is(words[0], "bare"))
        call_bare(play, words);
    else if (play_is(words[0], "carve"))
        carve(play, words);
    else if (play_is(words[0], "queries"))
        make_queries(play, words);
    else if (play_is(words[0], "unmap"))
        play->vk.UnmapMemory(play->device, play_object(play, words[1])->buffer.memory);
    else if (play_is(words[0], "answer"))
        play->answer = play_is(words[1], "yes");
    else
        return play_wild_command(play, words);
    return true;
}
