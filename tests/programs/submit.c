/* SPDX-License-Identifier: Apache-2.0 */
/* Submissions and host waits:
 *
 *     batch COMMANDS SEMAPHORES                    a batch of the next submission
 *     submit [QUEUE] COMMANDS SEMAPHORES [fence]   submits it by vkQueueSubmit2; `submit1`: by
 *                                                  vkQueueSubmit; `submit2KHR`: by its older name
 *     again [QUEUE]           submits the last batch's command buffers once more
 *     bind QUEUE [NAME page NUMBER | NAME nothing] SEMAPHORES [fence]     vkQueueBindSparse of the
 *                                            sparse buffer of a structure, or without bindings
 *     host wait fence | idle | QUEUE | TIMELINE=VALUE
 *     host wait any TIMELINE=VALUE TIMELINE=VALUE         for one of them
 *     host poll fence | TIMELINE=VALUE       the same by asking again and again
 *     host signal TIMELINE=VALUE
 *     timeline NAME VALUE     begins with the value
 *     exported fence | TIMELINE                           others may signal it
 *
 * COMMANDS: names of command buffers, in front of those that were recorded without a name.
 * SEMAPHORES: wait NAME[=VALUE][@STAGES] and signal NAME[=VALUE][@STAGES]; all stages if none are
 * named. The queue is q0 if none is named. What is left at the end is submitted to q0. */
#include "play.h"

#include <stdlib.h>
#include <string.h>

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
    play_end_unnamed(play);
    PLAY_REQUIRE(play, play->batch_count < BATCHES_MAX);
    struct batch *batch = &play->batches[play->batch_count++];
    *batch = (struct batch){.command_count = 0};
    for (char **word = words; *word; word++)
        if ((*word)[0] == 'c')
            batch_add_commands(batch, play_object(play, *word)->commands);
    for (uint32_t i = 0; i < play->ended_count; i++)
        batch_add_commands(batch, play->ended[i]);
    play->ended_count = 0;
    for (; *words; words++) {
        if (play_is(*words, "wait"))
            add_semaphore(play, *++words, &batch->waits[batch->wait_count++]);
        else if (play_is(*words, "signal"))
            add_semaphore(play, *++words, &batch->signals[batch->signal_count++]);
        else
            PLAY_REQUIRE(play, **words == 'q' || **words == 'c' || play_is(*words, "fence"));
    }
}

static void submit_batches(struct play *play, VkQueue queue, const char *command, VkFence fence)
{
    PLAY_REQUIRE(play, queue != NULL);
    if (play_is(command, "submit1"))
        play_note(play, batches_submit(&play->vk, queue, play->batch_count, play->batches, fence));
    else
        play_note(play, batches_submit_2(play_is(command, "submit") ? play->vk.QueueSubmit2
                                                                    : play->vk.QueueSubmit2KHR,
                                         queue, play->batch_count, play->batches, fence));
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

/* bind QUEUE [NAME page NUMBER | NAME nothing] SEMAPHORES [fence] */
static void bind(struct play *play, char **words)
{
    VkSparseMemoryBind bind = {.size = PLAY_PAGE_SIZE};
    VkSparseBufferMemoryBindInfo info = {.bindCount = 1, .pBinds = &bind};
    const VkQueue queue = play->queues[play_queue_of(play, words[1])];
    char **rest = words + 2;
    if (*rest && **rest == 'B') {
        info.buffer = play_object(play, *rest)->buffer.handle;
        if (play_is(rest[1], "page")) {
            bind.memory = play->pages;
            bind.memoryOffset = (VkDeviceSize)atoi(rest[2]) * PLAY_PAGE_SIZE;
        }
        rest += bind.memory ? 3 : 2;
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
        GET(play->vk.QueueWaitIdle(play->queues[play_queue_of(play, what)]));
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
    play_note(play, play->vk.SignalSemaphore(play->device, &info));
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
    if (play_is(words[0], "batch"))
        add_batch(play, words + 1);
    else if (strncmp(words[0], "submit", 6) == 0)
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
