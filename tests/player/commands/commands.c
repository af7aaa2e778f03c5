/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers:
 *
 *     begin NAME [secondary] [once | simultaneous] [for QUEUE] [inherits WHAT] ... end
 *     NAME OPTIONS: COMMAND; COMMAND      the same in one line
 *     execute NAME                        a secondary
 *     reset NAME     reset pool NAME      reallocate NAME      destroy pool NAME
 *
 * What a secondary command buffer inherits: `condition`, or a query of the invocations of shaders,
 * `vertex` or `compute`.
 *
 * Each command buffer with a name has a pool of its own. What is recorded outside of them goes to
 * command buffers without a name, which the next submission has:
 *
 *     next                    ends the command buffer; the next command begins another one
 *     secondary ... end       the commands between go to a secondary, which is executed at `end`
 *     execute                 the same secondary once more */
#include "tests/player/play.h"

#include <string.h>

unsigned play_queue_of(const struct play *play, const char *word)
{
    PLAY_REQUIRE(play, word && word[0] == 'q' && word[1] >= '0' && word[1] < '0' + PLAY_QUEUES);
    return (unsigned)(word[1] - '0');
}

/* ---- without a name */

/* The queue that the next submission names. */
static unsigned next_queue(const struct play *play)
{
    for (unsigned i = play->at; i < play->program->line_count; i++) {
        char *const *word = play->program->lines[i].words;
        while (*word && strncmp(*word, "submit", 6) != 0)
            word++;
        if (!*word)
            continue;
        for (; *word && !play_is(*word, ";"); word++)
            if ((*word)[0] == 'q')
                return play_queue_of(play, *word);
        return 0;
    }
    return 0;
}

static VkCommandBuffer begin_unnamed(const struct play *play, VkCommandBufferLevel level)
{
    return commands_begin(&play->vk, play->device, play->pools[next_queue(play) / 2], level,
                          VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT, NULL);
}

VkCommandBuffer play_commands(struct play *play)
{
    if (play->recording)
        return play->recording->commands;
    if (play->secondary)
        return play->secondary;
    if (!play->primary)
        play->primary = begin_unnamed(play, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    return play->primary;
}

void play_end_unnamed(struct play *play)
{
    if (!play->primary)
        return;
    PLAY_REQUIRE(play, !play->secondary && play->ended_count < PLAY_ITEMS);
    play_end_recording(play, play->primary);
    play->ended[play->ended_count++] = play->primary;
    play->primary = VK_NULL_HANDLE;
}

static void end_secondary(struct play *play)
{
    play_end_recording(play, play->secondary);
    play->executed = play->secondary;
    play->secondary = VK_NULL_HANDLE;
    play->vk.CmdExecuteCommands(play_commands(play), 1, &play->executed);
}

/* ---- with a name */

static void allocate(struct play *play, struct play_object *object)
{
    const STRUCT(VkCommandBufferAllocateInfo, info, .commandPool = object->pool,
                 .level = object->is_secondary ? VK_COMMAND_BUFFER_LEVEL_SECONDARY
                                               : VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                 .commandBufferCount = 1);
    GET(play->vk.AllocateCommandBuffers(play->device, &info, &object->commands));
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, name, .objectType = VK_OBJECT_TYPE_COMMAND_BUFFER,
                 .objectHandle = (uint64_t)(uintptr_t)object->commands,
                 .pObjectName = object->name);
    GET(play->vk.SetDebugUtilsObjectNameEXT(play->device, &name));
}

static void create_pool(struct play *play, struct play_object *object)
{
    const STRUCT(VkCommandPoolCreateInfo, info,
                 .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                 .queueFamilyIndex = object->queue / 2);
    GET(play->vk.CreateCommandPool(play->device, &info, NULL, &object->pool));
    allocate(play, object);
}

static void inherit(struct play *play, const char *what, VkCommandBufferInheritanceInfo *inherited,
                    VkCommandBufferInheritanceConditionalRenderingInfoEXT *condition)
{
    PLAY_REQUIRE(play,
                 play_is(what, "condition") || play_is(what, "vertex") || play_is(what, "compute"));
    if (play_is(what, "condition")) {
        condition->conditionalRenderingEnable = VK_TRUE;
        inherited->pNext = condition;
    } else {
        inherited->pipelineStatistics =
            play_is(what, "vertex") ? VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT
                                    : VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT;
    }
}

static void begin(struct play *play, char **words)
{
    struct play_object *object = play_object(play, words[1]);
    VkCommandBufferUsageFlags flags = 0;
    STRUCT(VkCommandBufferInheritanceConditionalRenderingInfoEXT, condition);
    STRUCT(VkCommandBufferInheritanceInfo, inherited);
    PLAY_REQUIRE(play, words[1][0] == 'c' && !play->recording);
    for (words += 2; *words; words++) {
        if (play_is(*words, "secondary"))
            object->is_secondary = true;
        else if (play_is(*words, "once"))
            flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
        else if (play_is(*words, "simultaneous"))
            flags = VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT;
        else if (play_is(*words, "inherits"))
            inherit(play, *++words, &inherited, &condition);
        else if (play_is(*words, "for"))
            object->queue = play_queue_of(play, *++words);
        else
            play_fail(play, *words);
    }
    if (!object->pool)
        create_pool(play, object);
    const STRUCT(VkCommandBufferBeginInfo, info, .flags = flags, .pInheritanceInfo = &inherited);
    play_note(play, play->vk.BeginCommandBuffer(object->commands, &info));
    play->recording = play->result == VK_SUCCESS ? object : NULL;
}

static void end(struct play *play)
{
    if (!play->recording) {
        end_secondary(play);
        return;
    }
    play_end_recording(play, play->recording->commands);
    play->recording = NULL;
}

static void execute(struct play *play, const char *name)
{
    const VkCommandBuffer executed = name ? play_object(play, name)->commands : play->executed;
    PLAY_REQUIRE(play, executed != NULL);
    play->vk.CmdExecuteCommands(play_commands(play), 1, &executed);
}

/* reset and destroy are commands of other objects, too. */
static bool change(struct play *play, char **words)
{
    const bool is_pool = play_is(words[1], "pool");
    const char *name = words[is_pool ? 2 : 1];
    if (!name || name[0] != 'c' || name[1] < '0' || name[1] > '9')
        return false;
    struct play_object *object = play_object(play, name);
    PLAY_REQUIRE(play, object->commands != NULL);
    if (play_is(words[0], "reset") && is_pool) {
        GET(play->vk.ResetCommandPool(play->device, object->pool, 0));
    } else if (play_is(words[0], "reset")) {
        GET(play->vk.ResetCommandBuffer(object->commands, 0));
    } else if (play_is(words[0], "reallocate")) {
        object->is_ghost = false;
        play->vk.FreeCommandBuffers(play->device, object->pool, 1, &object->commands);
        allocate(play, object);
    } else if (play_is(words[0], "destroy") && is_pool) {
        play->vk.DestroyCommandPool(play->device, object->pool, NULL);
        create_pool(play, object);
    } else {
        return false;
    }
    return true;
}

bool play_command_buffer(struct play *play, char **words)
{
    if (play_is(words[0], "next"))
        play_end_unnamed(play);
    else if (play_is(words[0], "secondary"))
        play->secondary = begin_unnamed(play, VK_COMMAND_BUFFER_LEVEL_SECONDARY);
    else if (play_is(words[0], "begin"))
        begin(play, words);
    else if (play_is(words[0], "end"))
        end(play);
    else if (play_is(words[0], "execute"))
        execute(play, words[1]);
    else
        return change(play, words);
    return true;
}
