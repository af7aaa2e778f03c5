/* SPDX-License-Identifier: Apache-2.0 */
/* What the host waits for, asks, and signals:
 *
 *     host wait fence | idle | QUEUE | TIMELINE=VALUE     `host wait fence` resets the fence
 *     host wait any TIMELINE=VALUE TIMELINE=VALUE         for one of them; `host wait all`
 *     host wait any fence     for the fence or another one
 *     host wait all fence     for the fence, named twice
 *     host wait all fences    for the fence behind 15 others, which are not signaled
 *     host wait ... within MILLISECONDS      of fences and timelines; a TIMEOUT takes that long
 *     host poll fence | EVENT | TIMELINE=VALUE       the same by asking again and again
 *     host get fence | TIMELINE | EVENT | QUERIES         asks once
 *     host map NAME           maps the memory of a buffer
 *     host reset fence
 *     host signal TIMELINE=VALUE
 *     host waitKHR ..., host getKHR ..., host signalKHR ...     timelines by their older names
 */
#include "tests/player/play.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- waits */

enum { OTHER_FENCES = 15 };

static uint64_t nanoseconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

/* Notes the result of a wait. One that timed out has taken the time. */
static void note_wait(struct play *play, VkResult result, uint64_t begin, uint64_t timeout)
{
    play_note_result(play, result);
    if (result != VK_TIMEOUT || timeout == UINT64_MAX || nanoseconds_now() - begin >= timeout)
        return;
    report_say(&play->report, "the wait took less than %llu ns\n", (unsigned long long)timeout);
    play->report.outcome = OUTCOME_FAILED;
}

/* Resets the fence if the wait was successful. */
static void wait_for_fences(struct play *play, uint32_t count, const VkFence *fences,
                            VkBool32 is_all, uint64_t timeout)
{
    const uint64_t begin = nanoseconds_now();
    const VkResult result =
        play_call(play, play->vk.WaitForFences(play->device, count, fences, is_all, timeout));
    note_wait(play, result, begin, timeout);
    if (result == VK_SUCCESS)
        GET(play->vk.ResetFences(play->device, 1, &play->fence));
}

/* Waits for the fence behind others, which are not signaled; with 0 others, it is named twice. */
static void wait_with_others(struct play *play, uint32_t others, bool is_any, uint64_t timeout)
{
    VkFence fences[OTHER_FENCES + 1] = {play->fence};
    for (uint32_t i = 0; i < others; i++)
        fences[i] = fence_create(&play->vk, play->device);
    fences[others ? others : 1] = play->fence;
    wait_for_fences(play, (others ? others : 1) + 1, fences, !is_any, timeout);
    for (uint32_t i = 0; i < others; i++)
        play->vk.DestroyFence(play->device, fences[i], NULL);
}

static void wait_for_timelines(struct play *play, const char *command, char **words,
                               VkSemaphoreWaitFlags flags, uint64_t timeout)
{
    VkSemaphore handles[PLAY_ITEMS];
    uint64_t values[PLAY_ITEMS];
    const uint64_t begin = nanoseconds_now();
    STRUCT(VkSemaphoreWaitInfo, info, .flags = flags, .pSemaphores = handles, .pValues = values);
    for (; *words && !play_is(*words, "within"); words++) {
        VkSemaphoreSubmitInfo semaphore;
        PLAY_REQUIRE(play, info.semaphoreCount < PLAY_ITEMS);
        play_read_semaphore(play, *words, &semaphore);
        handles[info.semaphoreCount] = semaphore.semaphore;
        values[info.semaphoreCount++] = semaphore.value;
    }
    const PFN_vkWaitSemaphores wait =
        play_is(command, "wait") ? play->vk.WaitSemaphores : play->vk.WaitSemaphoresKHR;
    note_wait(play, play_call(play, wait(play->device, &info, timeout)), begin, timeout);
}

/* within MILLISECONDS */
static uint64_t timeout_of(const struct play *play, char **words)
{
    while (*words && !play_is(*words, "within"))
        words++;
    if (!*words)
        return UINT64_MAX;
    PLAY_REQUIRE(play, words[1] != NULL);
    return strtoull(words[1], NULL, 0) * 1000000;
}

/* host wait ..., host waitKHR ... */
static void wait_on_host(struct play *play, char **words)
{
    const char *what = words[1];
    const bool is_any = play_is(what, "any");
    const uint64_t timeout = timeout_of(play, words);
    PLAY_REQUIRE(play, what != NULL);
    if (play_is(what, "idle"))
        play_note(play, play->vk.DeviceWaitIdle(play->device));
    else if (play_is(what, "fence"))
        wait_for_fences(play, 1, &play->fence, VK_TRUE, timeout);
    else if (what[0] == 'q')
        play_note(play, play->vk.QueueWaitIdle(play->queues[play_queue_of(play, what)]));
    else if (!is_any && !play_is(what, "all"))
        wait_for_timelines(play, words[0], words + 1, 0, timeout);
    else if (play_is(words[2], "fence") || play_is(words[2], "fences"))
        wait_with_others(play,
                         play_is(words[2], "fences") == is_any ? 0
                         : is_any                              ? 1
                                                               : OTHER_FENCES,
                         is_any, timeout);
    else
        wait_for_timelines(play, words[0], words + 2, is_any ? VK_SEMAPHORE_WAIT_ANY_BIT : 0,
                           timeout);
}

/* ---- questions and signals */

static void get_on_host(struct play *play, const char *command, const char *what)
{
    uint64_t value;
    const PFN_vkGetSemaphoreCounterValue get = play_is(command, "get")
                                                   ? play->vk.GetSemaphoreCounterValue
                                                   : play->vk.GetSemaphoreCounterValueKHR;
    PLAY_REQUIRE(play, what != NULL);
    if (play_is(what, "fence"))
        play_note(play, play->vk.GetFenceStatus(play->device, play->fence));
    else if (what[0] == 'E')
        play_note(play, play->vk.GetEventStatus(play->device, play_object(play, what)->event));
    else if (what[0] == 'P')
        play_note(play, play->vk.GetQueryPoolResults(play->device, play_object(play, what)->queries,
                                                     0, 1, sizeof(value), &value, sizeof(value),
                                                     VK_QUERY_RESULT_64_BIT));
    else
        play_note(play, get(play->device, play_object(play, what)->semaphore, &value));
}

static void poll_on_host(struct play *play, const char *what)
{
    VkSemaphoreSubmitInfo semaphore;
    uint64_t value = 0;
    if (play_is(what, "fence")) {
        while (play_call(play, play->vk.GetFenceStatus(play->device, play->fence)) == VK_NOT_READY)
            continue;
        return;
    }
    if (what && what[0] == 'E') {
        while (play->vk.GetEventStatus(play->device, play_object(play, what)->event) !=
               VK_EVENT_SET)
            continue;
        return;
    }
    play_read_semaphore(play, what, &semaphore);
    while (value < semaphore.value)
        GET(play->vk.GetSemaphoreCounterValue(play->device, semaphore.semaphore, &value));
}

static void signal_from_host(struct play *play, const char *command, const char *what)
{
    VkSemaphoreSubmitInfo semaphore;
    play_read_semaphore(play, what, &semaphore);
    const STRUCT(VkSemaphoreSignalInfo, info, .semaphore = semaphore.semaphore,
                 .value = semaphore.value);
    const PFN_vkSignalSemaphore signal =
        play_is(command, "signal") ? play->vk.SignalSemaphore : play->vk.SignalSemaphoreKHR;
    play_note(play, signal(play->device, &info));
}

static void map(struct play *play, const char *name)
{
    void *bytes;
    play_note(play, play->vk.MapMemory(play->device, play_object(play, name)->buffer.memory, 0,
                                       VK_WHOLE_SIZE, 0, &bytes));
}

/* Whether it is the command, by its name or its older one. */
static bool is_command(const char *word, const char *name)
{
    const size_t length = strlen(name);
    return word && strncmp(word, name, length) == 0 &&
           (!word[length] || play_is(word + length, "KHR"));
}

bool play_host(struct play *play, char **words)
{
    if (!play_is(words[0], "host"))
        return false;
    if (is_command(words[1], "wait"))
        wait_on_host(play, words + 1);
    else if (is_command(words[1], "get"))
        get_on_host(play, words[1], words[2]);
    else if (play_is(words[1], "poll"))
        poll_on_host(play, words[2]);
    else if (is_command(words[1], "signal"))
        signal_from_host(play, words[1], words[2]);
    else if (play_is(words[1], "map"))
        map(play, words[2]);
    else if (play_is(words[1], "reset") && play_is(words[2], "fence"))
        GET(play->vk.ResetFences(play->device, 1, &play->fence));
    else
        return false;
    return true;
}
