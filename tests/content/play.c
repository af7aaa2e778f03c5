/* SPDX-License-Identifier: Apache-2.0 */
/* The valid call, the twin and the mutation, each recorded and submitted in a scene of its own. */
#include "play.h"

#include <string.h>

#include "submission.h"

/* One of the calls of a case. */
struct call {
    const char *what;
    const struct test_case *prepared_for; /* NULL: the call is as the scene opens */
    void (*mutate)(struct scene *scene);
    const struct edit *edits;
    void (*then)(struct scene *scene);
    enum change change;
    bool breaks;
};

/* ---- the scene ---- */

/* What the base builds say, without their data. */
struct parameters {
    VkAccelerationStructureBuildGeometryInfoKHR infos[SCENE_BASE_BUILDS];
    VkAccelerationStructureGeometryKHR geometries[SCENE_BASE_BUILDS][SCENE_GEOMETRIES];
    VkAccelerationStructureBuildRangeInfoKHR ranges[SCENE_BASE_BUILDS][SCENE_GEOMETRIES];
};

static bool have_changed(const struct scene *scene, const struct parameters *parameters)
{
    // NOLINTBEGIN(bugprone-suspicious-memory-comparison): they are copies, padding and all
    return memcmp(parameters->infos, scene->infos, sizeof(parameters->infos)) != 0 ||
           memcmp(parameters->geometries, scene->geometries, sizeof(parameters->geometries)) != 0 ||
           memcmp(parameters->ranges, scene->ranges, sizeof(parameters->ranges)) != 0;
    // NOLINTEND(bugprone-suspicious-memory-comparison)
}

/* Pointers to the instances where they are, in the second half of their buffer. */
static void use_instance_pointers(struct scene *scene)
{
    VkAccelerationStructureGeometryInstancesDataKHR *instances =
        &scene->geometries[TLAS][0].geometry.instances;
    VkAccelerationStructureBuildRangeInfoKHR *range = &scene->ranges[TLAS][0];
    const VkDeviceSize half = SCENE_BUFFER_SIZE / 2;
    uint64_t *pointers = (uint64_t *)(void *)(scene->instances.host + half);

    if (instances->arrayOfPointers)
        return;
    for (uint32_t i = 0; i < range->primitiveCount; i++)
        pointers[i] = instances->data.deviceAddress + range->primitiveOffset +
                      i * sizeof(VkAccelerationStructureInstanceKHR);
    instances->arrayOfPointers = VK_TRUE;
    instances->data.deviceAddress = scene_address(scene, &scene->instances, half);
    range->primitiveOffset = 0;
}

/* Whether a pointer to an instance leads nowhere, where a driver that trusts it would read. */
static bool has_null_pointers(const struct scene *scene)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        &scene->geometries[TLAS][0].geometry.instances;
    const VkAccelerationStructureBuildRangeInfoKHR *range = &scene->ranges[TLAS][0];
    const uint64_t offset =
        instances->data.deviceAddress - scene->instances.address + range->primitiveOffset;
    const uint64_t end = offset + range->primitiveCount * sizeof(uint64_t);

    if (!instances->arrayOfPointers || end > SCENE_BUFFER_SIZE)
        return false;
    for (uint64_t at = offset; at < end; at += sizeof(uint64_t))
        if (*(const uint64_t *)(const void *)(scene->instances.host + at) == 0)
            return true;
    return false;
}

static struct scene *open_scene(const struct content_play *play, struct fixture *fixture,
                                const struct call *call)
{
    const struct variant *variant = play->variant;
    struct parameters parameters;

    fixture->inputs = variant->inputs;
    fixture->uses_two_queues = variant->uses_two_queues;
    fixture->records_secondary = variant->in_secondary;
    struct scene *scene = scene_open(fixture, variant->command);
    if (call->prepared_for != NULL)
        judge_prepare(scene, call->prepared_for);
    memcpy(parameters.infos, scene->infos, sizeof(parameters.infos));
    memcpy(parameters.geometries, scene->geometries, sizeof(parameters.geometries));
    memcpy(parameters.ranges, scene->ranges, sizeof(parameters.ranges));
    scene_inputs_remember(scene);
    if (call->mutate != NULL)
        call->mutate(scene);
    judge_apply(scene, call->edits);
    if (call->change != CHANGE_NOTHING &&
        (have_changed(scene, &parameters) || !scene_inputs_differ(scene)))
        scene_skip(scene, "not the data of the scene alone is what is bad");
    if (variant->geometry_pointers)
        scene_use_geometry_pointers(scene);
    if (variant->instance_pointers)
        use_instance_pointers(scene);
    if (!fixture->platform->is_null && !fixture->platform->is_cpu && has_null_pointers(scene))
        scene_skip(scene, "a driver may read behind null pointers");
    return scene;
}

/* ---- the call ---- */

static bool expect_none(const struct fixture *fixture, const struct call *call, const char *when,
                        struct report *report)
{
    if (fixture->messages.count == 0)
        return true;
    judge_say(report, "%s: %u messages %s\n", call->what, fixture->messages.count, when);
    judge_say_messages(fixture, report);
    return false;
}

/* A command that refuses the kind of build says so at the call. */
static bool expect_refusal_alone(const struct content_play *play, const struct fixture *fixture,
                                 const struct call *call, const char *when, struct report *report)
{
    const struct refusal *refusal = play->play.test_case->refusal;
    if (!judge_is_refused(&play->play) || call->prepared_for == NULL ||
        call->prepared_for->prepare == NULL ||
        messages_count(&fixture->messages, rule_id(refusal->rule, refusal->command), NULL) !=
            fixture->messages.count)
        return expect_none(fixture, call, when, report);
    return true;
}

static bool submit(const struct content_play *play, struct fixture *fixture, struct scene *scene,
                   const struct call *call, struct report *report)
{
    scene_inputs_upload(scene);
    submission_begin(scene);
    const bool good =
        expect_refusal_alone(play, fixture, call, "before the submission was waited for", report);
    submission_wait(scene, play->variant->waiting);
    return good;
}

/* Of the two kinds of data, the better one is submitted first, or is what is recorded with. */
static bool record_and_submit(const struct content_play *play, struct fixture *fixture,
                              struct scene *scene, const struct call *call, struct report *report)
{
    bool good = true;

    if (call->change == CHANGE_FOR_THE_WORSE || call->change == CHANGE_AND_RESUBMIT)
        scene_inputs_exchange(scene);
    scene_call(scene);
    if (call->then != NULL)
        call->then(scene);
    submission_prepare(scene);
    if (call->change == CHANGE_AND_RESUBMIT)
        good = submit(play, fixture, scene, call, report) &&
               expect_refusal_alone(play, fixture, call, "at the first submission", report);
    if (call->change != CHANGE_NOTHING)
        scene_inputs_exchange(scene);
    return submit(play, fixture, scene, call, report) && good;
}

/* Nothing is said twice, or when objects go. */
static bool close_scene(struct fixture *fixture, struct scene *scene, const struct call *call,
                        struct report *report)
{
    const uint32_t count = fixture->messages.count;
    submission_finish(scene);
    scene_close(scene);
    if (fixture->messages.count == count)
        return true;
    judge_say(report, "%s: messages after the wait\n", call->what);
    judge_say_messages(fixture, report);
    return false;
}

/* Its messages are in the world afterwards. False where it can't be judged. */
static bool make_call(const struct content_play *play, struct fixture *fixture,
                      const struct call *call, struct report *report)
{
    messages_clear(&fixture->messages);
    fixture->messages.answer = VK_FALSE;
    struct scene *scene = open_scene(play, fixture, call);
    bool good = false;
    if (scene->skip != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        judge_say(report, "%s", scene->skip);
    } else if (expect_none(fixture, call, "before the call", report)) {
        good = record_and_submit(play, fixture, scene, call, report);
    }
    return close_scene(fixture, scene, call, report) && good;
}

static bool expect_silence(const struct content_play *play, struct fixture *fixture,
                           const struct call *call, struct report *report)
{
    return make_call(play, fixture, call, report) &&
           expect_none(fixture, call, "instead of silence", report);
}

/* ---- the case ---- */

static void play_twin(const struct content_play *play, struct fixture *fixture,
                      struct report *report)
{
    const struct test_case *test_case = play->play.test_case;
    const struct call base = {.what = "valid call"};
    const struct call twin = {.what = "twin",
                              .prepared_for = test_case,
                              .mutate = test_case->mutate_twin,
                              .edits = test_case->twin_edits,
                              .then = test_case->twin_then};

    report->stayed_silent =
        (play->base_is_known || expect_silence(play, fixture, &base, report)) &&
        (!judge_has_twin(&play->play) || expect_silence(play, fixture, &twin, report));
}

static void play_mutation(const struct content_play *play, struct fixture *fixture,
                          struct report *report)
{
    const struct test_case *test_case = play->play.test_case;
    const bool breaks = !test_case->silent && play->variant->change != CHANGE_FOR_THE_BETTER;
    const struct call call = {.what = breaks ? "mutation" : "valid mutation",
                              .prepared_for = test_case,
                              .mutate = test_case->mutate,
                              .edits = test_case->edits,
                              .then = test_case->then,
                              .change = play->variant->change,
                              .breaks = breaks};
    if (!breaks)
        report->fired = expect_silence(play, fixture, &call, report);
    else
        report->fired =
            make_call(play, fixture, &call, report) && judge_messages(&play->play, fixture, report);
}

/* The guard warns of what no rule is about: references of moving instances, structures that were
 * never built, and pointers to no memory. */
static const char *guard_warns_of(const struct test_case *test_case)
{
    static const char *const names[] = {"pointer_to_instance_misaligned", "flat_motion_instance",
                                        "flat_packed_motion_instance",
                                        "motion_instance_without_memory"};
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++)
        if (strcmp(test_case->name, names[i]) == 0)
            return "the guard warns of more";
    return NULL;
}

void play_content(const struct content_play *play, struct fixture *fixture, struct report *report)
{
    const struct test_case *test_case = play->play.test_case;
    const struct setup *setup = judge_setup(test_case->setup);
    const struct setup *twin_setup = test_case->twin_setup != NULL ? test_case->twin_setup : setup;
    const char *missing = judge_enter_fixture(&play->play, fixture, twin_setup);

    *report = (struct report){.outcome = OUTCOME_FAILED};
    if (missing == NULL)
        missing = judge_cannot_play(&play->play, fixture);
    if (missing == NULL && fixture->platform->is_guarded)
        missing = guard_warns_of(test_case);
    if (missing == NULL) {
        play_twin(play, fixture, report);
        if (report->outcome != OUTCOME_SKIPPED)
            missing = judge_enter_fixture(&play->play, fixture, setup);
    }
    if (missing != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        judge_say(report, "%s", missing);
    }
    if (report->outcome == OUTCOME_SKIPPED)
        return;
    play_mutation(play, fixture, report);
    if (report->outcome != OUTCOME_SKIPPED && report->fired && report->stayed_silent)
        report->outcome = OUTCOME_PASSED;
}
