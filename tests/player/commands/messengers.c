/* SPDX-License-Identifier: Apache-2.0 */
/* Another messenger, which executes commands:
 *
 *     when ID COMMAND; COMMAND...      at the next message whose id ends so
 *     unregister                       destroys the messenger */
#include "tests/fixture/messenger.h"
#include "tests/player/play.h"

/* The commands go to command buffers of their own. */
MESSENGER_CALLBACK(act)
{
    struct play *play = user;
    char *const *reaction = play->reaction;
    const struct play_object *recording = play->recording;
    const struct batch batch = play->batches[0];
    const uint32_t batch_count = play->batch_count;
    const void *lent = play->lent, *lent_before = play->lent_before;
    const size_t lent_size = play->lent_size;
    if (!play->listener) {
        report_say(&play->report, "a messenger is called that was destroyed\n");
        play->report.outcome = OUTCOME_FAILED;
    }
    if (!reaction || !report_id_ends(data->pMessageIdName, play->awaited))
        return VK_FALSE;
    play->reaction = NULL;
    play->recording = NULL;
    play->batch_count = 0;
    play_words(play, reaction);
    play->recording = recording;
    play->batches[0] = batch; /* which a submission is still reading */
    play->batch_count = batch_count;
    play->lent = lent;
    play->lent_before = lent_before;
    play->lent_size = lent_size;
    return VK_FALSE;
}

void play_await(struct play *play)
{
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, info,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                    VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                                VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
                 .pfnUserCallback = act, .pUserData = play);
    char *const *words = play->program->lines[play->at].words;
    PLAY_REQUIRE(play, play_is(words[0], "when") && words[1] && words[2]);
    if (!play->listener)
        GET(play->fixture.vk.CreateDebugUtilsMessengerEXT(play->fixture.instance, &info, NULL,
                                                          &play->listener));
    play->awaited = words[1];
    play->reaction = words + 2;
}

void play_destroy_messenger(struct play *play)
{
    if (play->listener)
        play->fixture.vk.DestroyDebugUtilsMessengerEXT(play->fixture.instance, play->listener,
                                                       NULL);
    play->listener = VK_NULL_HANDLE;
    play->reaction = NULL;
}

bool play_messenger(struct play *play, char **words)
{
    if (!play_is(words[0], "unregister"))
        return false;
    play_destroy_messenger(play);
    return true;
}
