/* SPDX-License-Identifier: Apache-2.0 */
/* One call of a case. */
#include <stdlib.h>
#include <string.h>

#include "tests/player/calls/judge.h"

/* Whether the driver below has seen the call when it should, and only then. */
static bool check_forwarding(const struct call *call, uint64_t seen, struct report *report)
{
    const uint64_t wanted = call->is_skipped ? 0 : 1;
    if (seen == wanted)
        return true;
    report_say(report, "the driver got the call %u times instead of %u\n", (unsigned)seen,
               (unsigned)wanted);
    return false;
}

/* A host build that the callback skips fails in the application's eyes. */
static bool check_result(const struct call_play *play, const struct call *call, VkResult result,
                         struct report *report)
{
    const bool is_host = command_returns_result(play->command);
    const bool skipped = is_host && call->is_skipped;
    const bool may_fail = is_host && call->may_fail_on_cpu && play->platform->is_cpu;
    if ((skipped ? result == VK_ERROR_VALIDATION_FAILED_EXT : result >= VK_SUCCESS) ||
        (may_fail && result == VK_ERROR_VALIDATION_FAILED_EXT))
        return true;
    report_say(report, "the call returned %d\n", result);
    return false;
}

/* The commands that open and close a scene lack the features that are off, too: forgets their
 * messages. The twin has these features and shows that the scene is otherwise valid. */
static void forget_scene(const struct call_play *play, const struct call *call,
                         struct fixture *fixture, uint32_t since)
{
    if (call->breaks && judge_lacks_features(play))
        fixture->instance.messages.count = since;
}

static bool is_refusal(const struct message *message)
{
    return strcmp(message->id, "ASSAY-warning") == 0 &&
           strstr(message->text, "backend = cpu refuses ") != NULL;
}

/* The case says that backend cpu may refuse its calls, and so does a warning then. */
static void forget_refusals(const struct call_play *play, struct messages *messages)
{
    uint32_t others = 0;
    if (!play->platform->is_cpu || !play->test_case->may_fail_on_cpu)
        return;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        if (!is_refusal(&messages->items[i]))
            messages->items[others++] = messages->items[i];
    messages->count = others;
}

/* A query of sizes is about the build that the case is about, if the scene has it already. */
static void choose_build(const struct call_play *play, struct scene *scene)
{
    static const char array[] = "pInfos[";
    const char *path = play->test_case->path != NULL ? play->test_case->path : "";
    const char *index = strstr(path, array);
    if (play->command != COMMAND_GetAccelerationStructureBuildSizesKHR || index == NULL)
        return;
    const uint32_t build = (uint32_t)strtoul(index + strlen(array), NULL, 10);
    if (build < scene->info_count)
        scene_ask_sizes_of(scene, build);
}

bool play_call(const struct call_play *play, struct fixture *fixture, const struct call *call,
               struct report *report)
{
    const struct null_driver_api *driver = &play->platform->null_driver;
    const char *name = build_command_name(play->command);
    bool good = true;

    messages_clear(&fixture->instance.messages);
    fixture->instance.messages.answer = VK_FALSE;
    struct scene *scene = judge_open_scene(play, fixture);
    choose_build(play, scene);
    if (play->geometry_pointers)
        scene_use_geometry_pointers(scene);
    forget_scene(play, call, fixture, 0);
    forget_refusals(play, &fixture->instance.messages);
    if (scene->skip != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        report_say(report, "%s", scene->skip);
        good = false;
    } else if (report_expect_none(report, &fixture->instance.messages, "the call", "before it")) {
        fixture->instance.messages.answer =
            call->is_skipped && !fixture->fails ? VK_TRUE : VK_FALSE;
        const bool reaches_driver = play->platform->is_null && !play->platform->is_cpu;
        const uint64_t before = reaches_driver ? driver->calls(name) : 0;
        /* A call on an unknown device cannot go down, with or without a message. */
        const bool can_fail =
            !command_is_recorded(play->command) && scene->device != fixture->device;
        const VkResult result = scene_call(scene);
        good = (can_fail && !call->breaks) || check_result(play, call, result, report);
        if (reaches_driver && (!can_fail || call->breaks))
            good = check_forwarding(call, driver->calls(name) - before, report) && good;
        fixture->instance.messages.answer = VK_FALSE;
    }
    const uint32_t count = fixture->instance.messages.count;
    scene_close(scene);
    forget_scene(play, call, fixture, count);
    forget_refusals(play, &fixture->instance.messages);
    return good;
}
