/* SPDX-License-Identifier: Apache-2.0 */
/* Semaphores and fences that others signal:
 *
 *     present SEMAPHORE          vkQueuePresentKHR on q0 waits for it
 *     acquire SEMAPHORE          vkAcquireNextImageKHR signals it
 *     acquire2 SEMAPHORE         vkAcquireNextImage2KHR signals it
 *     sleep SEMAPHORE            vkLatencySleepNV signals it
 *     import SEMAPHORE | fence   its payload comes from a file descriptor
 *     exported fence | TIMELINE  its handle can be exported
 *     renew fence                destroys the fence and creates another one
 *     timeline NAME VALUE        begins with the value
 *
 * No swapchain is behind the first four: the null driver needs none. */
#include "tests/player/play.h"

#include <stdlib.h>

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

static void replace_fence(struct play *play, const void *chain)
{
    play->vk.DestroyFence(play->device, play->fence, NULL);
    GET(play->vk.CreateFence(play->device, &MAKE(VkFenceCreateInfo, .pNext = chain), NULL,
                             &play->fence));
}

static void replace_by_exported(struct play *play, const char *name)
{
    const STRUCT(VkExportFenceCreateInfo, fence,
                 .handleTypes = VK_EXTERNAL_FENCE_HANDLE_TYPE_OPAQUE_FD_BIT);
    const STRUCT(VkExportSemaphoreCreateInfo, semaphore,
                 .handleTypes = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT);
    if (play_is(name, "fence"))
        replace_fence(play, &fence);
    else
        replace_semaphore(play, name, &semaphore, 0);
}

static void acquire(struct play *play, const char *command, VkSemaphore semaphore)
{
    const STRUCT(VkAcquireNextImageInfoKHR, info, .semaphore = semaphore, .deviceMask = 1);
    uint32_t image;
    play_note(play, play_is(command, "acquire")
                        ? play->vk.AcquireNextImageKHR(play->device, VK_NULL_HANDLE, 0, semaphore,
                                                       VK_NULL_HANDLE, &image)
                        : play->vk.AcquireNextImage2KHR(play->device, &info, &image));
}

static void import(struct play *play, const char *name)
{
    if (play_is(name, "fence"))
        play_note(play, play->vk.ImportFenceFdKHR(
                            play->device, &MAKE(VkImportFenceFdInfoKHR, .fence = play->fence)));
    else
        play_note(play, play->vk.ImportSemaphoreFdKHR(
                            play->device, &MAKE(VkImportSemaphoreFdInfoKHR,
                                                .semaphore = play_object(play, name)->semaphore)));
}

static void present(struct play *play, VkSemaphore semaphore)
{
    play_note(play, play->vk.QueuePresentKHR(play->queues[0],
                                             &MAKE(VkPresentInfoKHR, .waitSemaphoreCount = 1,
                                                   .pWaitSemaphores = &semaphore)));
}

static void sleep_until(struct play *play, VkSemaphore semaphore)
{
    play_note(play,
              play->vk.LatencySleepNV(play->device, VK_NULL_HANDLE,
                                      &MAKE(VkLatencySleepInfoNV, .signalSemaphore = semaphore)));
}

bool play_foreign(struct play *play, char **words)
{
    if (play_is(words[0], "present"))
        present(play, play_object(play, words[1])->semaphore);
    else if (play_is(words[0], "acquire") || play_is(words[0], "acquire2"))
        acquire(play, words[0], play_object(play, words[1])->semaphore);
    else if (play_is(words[0], "sleep"))
        sleep_until(play, play_object(play, words[1])->semaphore);
    else if (play_is(words[0], "import"))
        import(play, words[1]);
    else if (play_is(words[0], "exported"))
        replace_by_exported(play, words[1]);
    else if (play_is(words[0], "renew") && play_is(words[1], "fence"))
        replace_fence(play, NULL);
    else if (play_is(words[0], "timeline"))
        replace_semaphore(play, words[1], NULL, strtoull(words[2], NULL, 0));
    else
        return false;
    return true;
}
