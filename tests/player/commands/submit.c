/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions:
 *
 *     batch COMMANDS SEMAPHORES                    a batch of the next submission
 *     submit [QUEUE] COMMANDS SEMAPHORES [fence]   submits it by vkQueueSubmit2; `submit1`: by
 *                                                  vkQueueSubmit; `submit2KHR`: by its older name
 *     again [QUEUE]           submits the last batch's command buffers once more
 *     bind QUEUE [NAME page NUMBER [NUMBER] | NAME nothing] SEMAPHORES [fence]
 *                             vkQueueBindSparse of the sparse buffer of a structure, or without
 *                             bindings; the second page is that of a long buffer
 *
 * COMMANDS: names of command buffers, in front of those that were recorded without a name. In a
 * group of devices, `mask NUMBER` says which ones execute them; all if there is none.
 * SEMAPHORES: wait NAME[=VALUE][@STAGES] and signal NAME[=VALUE][@STAGES]; all stages if none are
 * named. The queue is q0 if none is named. What is left at the end is submitted to q0. */
#include "tests/player/play.h"

#include <stdlib.h>
#include <string.h>

/* ---- submissions */

void play_read_semaphore(struct play *play, const char *word, VkSemaphoreSubmitInfo *to)
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

static void set_mask(struct batch *batch, uint32_t mask)
{
    for (uint32_t i = 0; i < batch->command_count; i++)
        batch->commands[i].deviceMask = mask;
}

/* Makes a batch of the command buffers that have ended. */
static void add_batch(struct play *play, char **words)
{
    play_end_unnamed(play);
    PLAY_REQUIRE(play, play->batch_count < BATCHES_MAX);
    struct batch *batch = &play->batches[play->batch_count++];
    *batch = (struct batch){.command_count = 0};
    for (char **word = words; *word; word++)
        if ((*word)[0] == 'c') {
            PLAY_REQUIRE(play, play_object(play, *word)->commands);
            batch_add_commands(batch, play_object(play, *word)->commands);
        }
    for (uint32_t i = 0; i < play->ended_count; i++)
        batch_add_commands(batch, play->ended[i]);
    play->ended_count = 0;
    for (; *words; words++) {
        if (play_is(*words, "wait"))
            play_read_semaphore(play, *++words, &batch->waits[batch->wait_count++]);
        else if (play_is(*words, "signal"))
            play_read_semaphore(play, *++words, &batch->signals[batch->signal_count++]);
        else if (play_is(*words, "mask"))
            set_mask(batch, (uint32_t)atoi(*++words));
        else
            PLAY_REQUIRE(play, **words == 'q' || **words == 'c' || play_is(*words, "fence"));
    }
}

static void submit_batches(struct play *play, VkQueue queue, const char *command, VkFence fence)
{
    PLAY_REQUIRE(play, queue != NULL);
    for (uint32_t i = 0; i < play->batch_count; i++)
        batch_set_stages(&play->batches[i]);
    play_lend(play, play->batches, play->batch_count * sizeof(play->batches[0]));
    if (play_is(command, "submit1"))
        play_note(play, batches_submit(&play->vk, queue, play->batch_count, play->batches, fence));
    else
        play_note(play, batches_submit_2(play_is(command, "submit") ? play->vk.QueueSubmit2
                                                                    : play->vk.QueueSubmit2KHR,
                                         queue, play->batch_count, play->batches, fence));
    play_expect_unmodified(play);
    play->batches[0] = play->batches[play->batch_count - 1]; /* for `again` */
    play->batch_count = 0;
}

static void submit(struct play *play, char **words)
{
    VkFence fence = VK_NULL_HANDLE;
    unsigned queue = 0;
    for (char **word = words + 1; *word; word++) {
        if ((*word)[0] == 'q')
            queue = play_queue_of(play, *word);
        if (play_is(*word, "fence"))
            fence = play->fence;
    }
    add_batch(play, words + 1);
    submit_batches(play, play->queues[queue], words[0], fence);
}

/* bind QUEUE [NAME page NUMBER [NUMBER] | NAME nothing] SEMAPHORES [fence] */
static void bind(struct play *play, char **words)
{
    VkSparseMemoryBind binds[] = {{.size = PLAY_PAGE_SIZE},
                                  {.resourceOffset = PLAY_PAGE_SIZE, .size = PLAY_PAGE_SIZE}};
    VkSparseBufferMemoryBindInfo info = {.bindCount = 1, .pBinds = binds};
    const VkQueue queue = play->queues[play_queue_of(play, words[1])];
    char **rest = words + 2;
    if (*rest && **rest == 'B') {
        info.buffer = play_object(play, *rest)->buffer.handle;
        const bool has_pages = play_is(rest[1], "page");
        uint32_t count = 0;
        for (rest += 2; has_pages && *rest && **rest >= '0' && **rest <= '9'; rest++) {
            PLAY_REQUIRE(play, count < ARRAY_COUNT(binds));
            binds[count].memory = play->pages;
            binds[count++].memoryOffset = (VkDeviceSize)atoi(*rest) * PLAY_PAGE_SIZE;
        }
        info.bindCount = has_pages ? count : 1;
    }
    add_batch(play, rest);
    const struct batch *batch = &play->batches[--play->batch_count];
    PLAY_REQUIRE(play, !batch->command_count);
    bool has_fence = false;
    for (; *rest; rest++)
        has_fence |= play_is(*rest, "fence");
    play_note(play, batch_bind(&play->vk, queue, batch, info.buffer ? &info : NULL,
                               has_fence ? play->fence : VK_NULL_HANDLE));
}

static void submit_again(struct play *play, char **words)
{
    struct batch *batch = &play->batches[0];
    PLAY_REQUIRE(play, !play->batch_count && !play->primary);
    batch->wait_count = batch->signal_count = 0;
    play->batch_count = 1;
    submit_batches(play, play->queues[words[1] ? play_queue_of(play, words[1]) : 0], "submit",
                   VK_NULL_HANDLE);
}

bool play_submit(struct play *play, char **words)
{
    if (play_is(words[0], "batch"))
        add_batch(play, words + 1);
    else if (strncmp(words[0], "submit", 6) == 0)
        submit(play, words);
    else if (play_is(words[0], "bind"))
        bind(play, words);
    else if (play_is(words[0], "again"))
        submit_again(play, words);
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
