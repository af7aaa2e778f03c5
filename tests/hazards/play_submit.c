/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, submissions and host waits of cases:
 *
 *     next                    ends the command buffer; the next command begins another one
 *     secondary ... end       the commands between go to a secondary, which is executed at `end`
 *     execute                 the same secondary once more
 *     batch SEMAPHORES        what was recorded is a batch of the next submission
 *     submit [QUEUE] SEMAPHORES [fence]      submits it by vkQueueSubmit2; `submit1`: by the other
 *     again [QUEUE]           submits the last batch's command buffers once more
 *     bind [QUEUE] SEMAPHORES                vkQueueBindSparse without bindings
 *     host wait fence | idle | QUEUE | TIMELINE=VALUE
 *     host wait any TIMELINE=VALUE TIMELINE=VALUE         for one of them
 *     host poll fence | TIMELINE=VALUE       the same by asking again and again
 *     host signal TIMELINE=VALUE
 *     timeline NAME VALUE     begins with the value
 *     exported fence | TIMELINE                           others may signal it
 *
 * SEMAPHORES: wait NAME[=VALUE][@STAGES] and signal NAME[=VALUE][@STAGES]; all stages if none are
 * named. The queue is q0 if none is named. What is left at the end is submitted to q0. */
#include "play.h"

#include <stdlib.h>
#include <string.h>

/* ---- recording */

static unsigned queue_of(const struct play *play, const char *word)
{
    PLAY_REQUIRE(play, word && word[0] == 'q' && word[1] >= '0' && word[1] < '0' + PLAY_QUEUES);
    return (unsigned)(word[1] - '0');
}

static bool plays_line(const struct play *play, const struct case_line *line)
{
    return line->mark != (play->is_repaired ? '-' : '+');
}

/* The queue that the next submission names. */
static unsigned next_queue(const struct play *play)
{
    for (unsigned i = play->at; i < play->program->line_count; i++) {
        const struct case_line *line = &play->program->lines[i];
        if (!plays_line(play, line) || strncmp(line->words[0], "submit", 6) != 0)
            continue;
        for (char *const *word = line->words + 1; *word; word++)
            if ((*word)[0] == 'q')
                return queue_of(play, *word);
        return 0;
    }
    return 0;
}

static VkCommandBuffer begin(const struct play *play, VkCommandBufferLevel level)
{
    return commands_begin(&play->vk, play->device, play->pools[next_queue(play) / 2], level,
                          VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT, NULL);
}

VkCommandBuffer play_commands(struct play *play)
{
    if (play->secondary)
        return play->secondary;
    if (!play->primary)
        play->primary = begin(play, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    return play->primary;
}

static void end_primary(struct play *play)
{
    if (!play->primary)
        return;
    PLAY_REQUIRE(play, !play->secondary && play->ended_count < PLAY_ITEMS);
    GET(play->vk.EndCommandBuffer(play->primary));
    play->ended[play->ended_count++] = play->primary;
    play->primary = VK_NULL_HANDLE;
}

static void end_secondary(struct play *play)
{
    GET(play->vk.EndCommandBuffer(play->secondary));
    play->executed = play->secondary;
    play->secondary = VK_NULL_HANDLE;
    play->vk.CmdExecuteCommands(play_commands(play), 1, &play->executed);
}

/* ---- submissions */

static void add_semaphore(struct play *play, const char *word, VkSemaphoreSubmitInfo *to)
{
    char name[8];
    size_t length = strcspn(word, "=@");
    const char *value = strchr(word, '='), *stages = strchr(word, '@');
    PLAY_REQUIRE(play, length < sizeof(name));
    memcpy(name, word, length);
    name[length] = '\0';
    *to = MAKE(VkSemaphoreSubmitInfo, .semaphore = play_object(play, name)->semaphore,
               .value = value ? strtoull(value + 1, NULL, 0) : 0,
               .stageMask =
                   stages ? play_stages(play, stages + 1) : VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
}

/* Makes a batch of the command buffers that have ended. */
static void add_batch(struct play *play, char **words)
{
    end_primary(play);
    PLAY_REQUIRE(play, play->batch_count < BATCHES_MAX);
    struct batch *batch = &play->batches[play->batch_count++];
    *batch = (struct batch){.command_count = 0};
    for (uint32_t i = 0; i < play->ended_count; i++)
        batch_add_commands(batch, play->ended[i]);
    play->ended_count = 0;
    for (; *words; words++) {
        if (play_is(*words, "wait"))
            add_semaphore(play, *++words, &batch->waits[batch->wait_count++]);
        else if (play_is(*words, "signal"))
            add_semaphore(play, *++words, &batch->signals[batch->signal_count++]);
        else
            PLAY_REQUIRE(play, **words == 'q' || play_is(*words, "fence"));
    }
}

static void submit_batches(struct play *play, VkQueue queue, bool by_2, VkFence fence)
{
    PLAY_REQUIRE(play, queue != NULL);
    if (by_2)
        GET(batches_submit_2(play->vk.QueueSubmit2, queue, play->batch_count, play->batches,
                             fence));
    else
        GET(batches_submit(&play->vk, queue, play->batch_count, play->batches, fence));
    play->batches[0] = play->batches[play->batch_count - 1]; /* for `again` */
    play->batch_count = 0;
}

static void submit(struct play *play, char **words)
{
    VkFence fence = VK_NULL_HANDLE;
    unsigned queue = 0;
    for (char **word = words + 1; *word; word++) {
        if ((*word)[0] == 'q')
            queue = queue_of(play, *word);
        if (play_is(*word, "fence"))
            fence = play->fence;
    }
    add_batch(play, words + 1);
    submit_batches(play, play->queues[queue], play_is(words[0], "submit"), fence);
}

static void bind(struct play *play, char **words)
{
    add_batch(play, words + 1);
    const struct batch *batch = &play->batches[--play->batch_count];
    PLAY_REQUIRE(play, !batch->command_count);
    GET(batch_bind(&play->vk, play->queues[queue_of(play, words[1])], batch, NULL, VK_NULL_HANDLE));
}

static void submit_again(struct play *play, char **words)
{
    struct batch *batch = &play->batches[0];
    PLAY_REQUIRE(play, !play->batch_count && !play->primary);
    batch->wait_count = batch->signal_count = 0;
    play->batch_count = 1;
    submit_batches(play, play->queues[words[1] ? queue_of(play, words[1]) : 0], true,
                   VK_NULL_HANDLE);
}

/* ---- the host */

static void wait_on_host(struct play *play, const char *what)
{
    VkSemaphoreSubmitInfo semaphore;
    if (play_is(what, "idle")) {
        GET(play->vk.DeviceWaitIdle(play->device));
    } else if (play_is(what, "fence")) {
        GET(play->vk.WaitForFences(play->device, 1, &play->fence, VK_TRUE, UINT64_MAX));
        GET(play->vk.ResetFences(play->device, 1, &play->fence));
    } else if (what && what[0] == 'q') {
        GET(play->vk.QueueWaitIdle(play->queues[queue_of(play, what)]));
    } else {
        add_semaphore(play, what, &semaphore);
        const STRUCT(VkSemaphoreWaitInfo, info, .semaphoreCount = 1,
                     .pSemaphores = &semaphore.semaphore, .pValues = &semaphore.value);
        GET(play->vk.WaitSemaphores(play->device, &info, UINT64_MAX));
    }
}

static void wait_for_any(struct play *play, char **words)
{
    VkSemaphore handles[PLAY_ITEMS];
    uint64_t values[PLAY_ITEMS];
    STRUCT(VkSemaphoreWaitInfo, info, .flags = VK_SEMAPHORE_WAIT_ANY_BIT, .pSemaphores = handles,
           .pValues = values);
    for (; *words && info.semaphoreCount < PLAY_ITEMS; words++) {
        VkSemaphoreSubmitInfo semaphore;
        add_semaphore(play, *words, &semaphore);
        handles[info.semaphoreCount] = semaphore.semaphore;
        values[info.semaphoreCount++] = semaphore.value;
    }
    GET(play->vk.WaitSemaphores(play->device, &info, UINT64_MAX));
}

static void poll_on_host(struct play *play, const char *what)
{
    VkSemaphoreSubmitInfo semaphore;
    uint64_t value = 0;
    if (play_is(what, "fence")) {
        while (play->vk.GetFenceStatus(play->device, play->fence) == VK_NOT_READY)
            continue;
        return;
    }
    add_semaphore(play, what, &semaphore);
    while (value < semaphore.value)
        GET(play->vk.GetSemaphoreCounterValue(play->device, semaphore.semaphore, &value));
}

static void signal_from_host(struct play *play, const char *what)
{
    VkSemaphoreSubmitInfo semaphore;
    add_semaphore(play, what, &semaphore);
    const STRUCT(VkSemaphoreSignalInfo, info, .semaphore = semaphore.semaphore,
                 .value = semaphore.value);
    GET(play->vk.SignalSemaphore(play->device, &info));
}

static bool play_host(struct play *play, char **words)
{
    if (play_is(words[1], "wait") && play_is(words[2], "any"))
        wait_for_any(play, words + 3);
    else if (play_is(words[1], "wait"))
        wait_on_host(play, words[2]);
    else if (play_is(words[1], "poll"))
        poll_on_host(play, words[2]);
    else if (play_is(words[1], "signal"))
        signal_from_host(play, words[2]);
    else
        return false;
    return true;
}

/* ---- synchronization objects that are created otherwise */

static void replace_semaphore(struct play *play, const char *name, const void *chain,
                              uint64_t value)
{
    const STRUCT(VkSemaphoreTypeCreateInfo, type, .pNext = chain,
                 .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE, .initialValue = value);
    struct play_object *object = play_object(play, name);
    play->vk.DestroySemaphore(play->device, object->semaphore, NULL);
    GET(play->vk.CreateSemaphore(play->device, &MAKE(VkSemaphoreCreateInfo, .pNext = &type), NULL,
                                 &object->semaphore));
}

static void replace_by_exported(struct play *play, const char *name)
{
    const STRUCT(VkExportFenceCreateInfo, fence,
                 .handleTypes = VK_EXTERNAL_FENCE_HANDLE_TYPE_OPAQUE_FD_BIT);
    const STRUCT(VkExportSemaphoreCreateInfo, semaphore,
                 .handleTypes = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT);
    if (!play_is(name, "fence")) {
        replace_semaphore(play, name, &semaphore, 0);
        return;
    }
    play->vk.DestroyFence(play->device, play->fence, NULL);
    GET(play->vk.CreateFence(play->device, &MAKE(VkFenceCreateInfo, .pNext = &fence), NULL,
                             &play->fence));
}

bool play_submit(struct play *play, char **words)
{
    if (play_is(words[0], "host"))
        return play_host(play, words);
    if (play_is(words[0], "next"))
        end_primary(play);
    else if (play_is(words[0], "secondary"))
        play->secondary = begin(play, VK_COMMAND_BUFFER_LEVEL_SECONDARY);
    else if (play_is(words[0], "end"))
        end_secondary(play);
    else if (play_is(words[0], "execute"))
        play->vk.CmdExecuteCommands(play_commands(play), 1, &play->executed);
    else if (play_is(words[0], "batch"))
        add_batch(play, words + 1);
    else if (play_is(words[0], "submit") || play_is(words[0], "submit1"))
        submit(play, words);
    else if (play_is(words[0], "bind"))
        bind(play, words);
    else if (play_is(words[0], "again"))
        submit_again(play, words);
    else if (play_is(words[0], "timeline"))
        replace_semaphore(play, words[1], NULL, strtoull(words[2], NULL, 0));
    else if (play_is(words[0], "exported"))
        replace_by_exported(play, words[1]);
    else
        return false;
    return true;
}

void play_finish(struct play *play)
{
    if (play->primary || play->ended_count || play->batch_count)
        submit(play, (char *[]){"submit", NULL});
    GET(play->vk.DeviceWaitIdle(play->device));
}
