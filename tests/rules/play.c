/* SPDX-License-Identifier: Apache-2.0 */
/* Playing one case: the valid call, the mutation, the twin, each in a scene of its own. */
#include "judge.h"

/* ---- one call ---- */

/* One of the three calls of a case. */
struct call {
    const char *what;
    void (*prepare)(struct scene *scene); /* these two: NULL: nothing is done */
    void (*mutate)(struct scene *scene);
    bool breaks, forwards, may_fail_on_cpu;
    void (*then)(struct scene *scene);
};

static bool is_submitted(const struct play *play)
{
    return play->test_case->submits && play->command != COMMAND_HOST;
}

/* Whether a callback has the call itself skipped. */
static bool is_skipped(const struct play *play, const struct call *call)
{
    return call->breaks && !call->forwards && !is_submitted(play);
}

/* Whether the driver below has seen the call when it should, and only then. */
static bool check_forwarding(const struct play *play, const struct call *call, uint64_t seen,
                             struct report *report)
{
    const uint64_t wanted = is_skipped(play, call) ? 0 : 1;
    if (seen == wanted)
        return true;
    judge_say(report, "%s: the driver got the call %u times instead of %u\n", call->what,
              (unsigned)seen, (unsigned)wanted);
    return false;
}

/* A host build that the callback skips fails in the application's eyes. */
static bool check_result(const struct play *play, const struct call *call, VkResult result,
                         struct report *report)
{
    const bool is_host = play->command == COMMAND_HOST;
    const bool skipped = is_host && is_skipped(play, call);
    const bool may_fail = is_host && call->may_fail_on_cpu && play->platform->is_cpu;
    if ((skipped ? result == VK_ERROR_VALIDATION_FAILED_EXT : result >= VK_SUCCESS) ||
        (may_fail && result == VK_ERROR_VALIDATION_FAILED_EXT))
        return true;
    judge_say(report, "%s: the call returned %d\n", call->what, result);
    return false;
}

/* Submits what was recorded without a word; a callback has it skipped where it breaks rules. */
static bool submit(struct fixture *fixture, struct scene *scene, const struct call *call,
                   struct report *report)
{
    if (fixture->messages.count != 0) {
        judge_say(report, "%s: messages before the submission\n", call->what);
        return false;
    }
    fixture->messages.answer = call->breaks && !fixture->fails ? VK_TRUE : VK_FALSE;
    const VkResult result = scene_submit_call(scene);
    if (result == (call->breaks ? VK_ERROR_VALIDATION_FAILED_EXT : VK_SUCCESS))
        return true;
    judge_say(report, "%s: the submission returned %d\n", call->what, result);
    return false;
}

/* Makes one call; its messages are in the world afterwards. False where it cannot be judged. */
static bool make_call(const struct play *play, struct fixture *fixture, const struct call *call,
                      struct report *report)
{
    const struct null_driver_api *driver = &play->platform->null_driver;
    const char *name = build_command_name(play->command);
    bool good = true;

    messages_clear(&fixture->messages);
    fixture->messages.answer = VK_FALSE;
    struct scene *scene = scene_open(fixture, play->command);
    if (call->prepare != NULL)
        call->prepare(scene);
    if (call->mutate != NULL)
        call->mutate(scene);
    if (play->geometry_pointers)
        scene_use_geometry_pointers(scene);
    if (scene->skip != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        judge_say(report, "%s", scene->skip);
        good = false;
    } else if (fixture->messages.count != 0) {
        judge_say(report, "%s: messages before the call\n", call->what);
    } else {
        fixture->messages.answer = is_skipped(play, call) && !fixture->fails ? VK_TRUE : VK_FALSE;
        const bool reaches_driver = play->platform->is_null && !play->platform->is_cpu;
        const uint64_t before = reaches_driver ? driver->calls(name) : 0;
        /* A call on a device that nobody knows can go nowhere, told or not. */
        const bool can_fail = play->command == COMMAND_HOST && scene->device != fixture->device;
        const VkResult result = scene_call(scene);
        good = (can_fail && !call->breaks) || check_result(play, call, result, report);
        if (call->then != NULL)
            call->then(scene);
        if (is_submitted(play))
            good = submit(fixture, scene, call, report) && good;
        if (reaches_driver && (!can_fail || call->breaks))
            good = check_forwarding(play, call, driver->calls(name) - before, report) && good;
        fixture->messages.answer = VK_FALSE;
    }
    scene_close(scene);
    return good;
}

static bool expect_silence(const struct play *play, struct fixture *fixture,
                           const struct call *call, struct report *report)
{
    const bool made = make_call(play, fixture, call, report);
    if (report->outcome == OUTCOME_SKIPPED || fixture->messages.count == 0)
        return made;
    judge_say(report, "%s: %u messages instead of silence\n", call->what, fixture->messages.count);
    judge_say_messages(fixture, report);
    return false;
}

/* ---- the mutation ---- */

/* Where a case asks for level execution, its rules may be of a lower one: what that level knows is
 * what breaks them. */
static bool play_mutation(const struct play *play, struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    bool breaks = false;

    for (uint32_t i = 0; i < test_case->rule_count && !test_case->silent; i++)
        breaks = breaks || judge_expects(play, test_case->rules[i]);
    if (judge_is_refused(play))
        breaks = breaks || judge_expects(play, test_case->refusal->rule);
    const struct call call = {breaks ? "mutation" : "valid mutation",
                              test_case->prepare,
                              test_case->wrong,
                              breaks,
                              test_case->forwards,
                              test_case->silent && test_case->may_fail_on_cpu,
                              test_case->then};
    if (!breaks)
        return expect_silence(play, fixture, &call, report);
    const bool made = make_call(play, fixture, &call, report);
    return report->outcome != OUTCOME_SKIPPED && judge_messages(play, fixture, report) && made;
}

/* ---- the case ---- */

static void play_twin(const struct play *play, struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct call base = {.what = "valid call"};
    const struct call twin = {.what = "twin",
                              .prepare = test_case->prepare,
                              .mutate = test_case->right,
                              .may_fail_on_cpu = test_case->may_fail_on_cpu,
                              .then = test_case->right_then};

    report->stayed_silent = expect_silence(play, fixture, &base, report) &&
                            (!judge_has_twin(play) || expect_silence(play, fixture, &twin, report));
}

void play_case(const struct play *play, struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const struct setup *setup = judge_setup(test_case->setup);
    const struct setup *twin_setup =
        test_case->right_setup != NULL ? test_case->right_setup : setup;
    const char *missing = judge_enter_fixture(play, fixture, twin_setup);

    *report = (struct report){.outcome = OUTCOME_FAILED};
    if (missing == NULL)
        missing = judge_cannot_play(play, fixture);
    if (missing == NULL && test_case->forwards && fixture->fails)
        missing = "debug_action = fail lets no such call pass";
    if (missing == NULL && !play->is_mutation_alone) {
        play_twin(play, fixture, report);
        if (report->outcome == OUTCOME_SKIPPED)
            return;
        if (!report->stayed_silent)
            judge_say(report, "(before the mutation)\n");
    }
    if (missing == NULL)
        missing = judge_enter_fixture(play, fixture, setup);
    if (missing != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        judge_say(report, "%s", missing);
        return;
    }
    report->fired = play_mutation(play, fixture, report);
    if (report->outcome == OUTCOME_SKIPPED)
        return;
    if (report->fired && (report->stayed_silent || play->is_mutation_alone))
        report->outcome = OUTCOME_PASSED;
}
