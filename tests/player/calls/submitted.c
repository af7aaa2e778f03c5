/* SPDX-License-Identifier: Apache-2.0 */
/* programs_test --submitted: the data of builds by command buffers, which command buffers copy to
 * device-local memory just before each build. What is wrong is found when the submission is
 * complete, and not before. tests/programs/snapshots has the other ways in which data gets to the
 * place where it is read. */
#include <string.h>

#include "tests/player/calls/judge.h"

const struct variant variants[] = {
    {"copied", COMMAND_DEVICE},
    {"copied+ppGeometries", COMMAND_DEVICE, .geometry_pointers = true},
    {"copied_pointers", COMMAND_DEVICE, .instance_pointers = true},
    {"indirect_copied", COMMAND_INDIRECT},
    {"nv_copied", COMMAND_NV},
};
const uint32_t variant_count = sizeof(variants) / sizeof(variants[0]);

/* ---- which cases a variant is for ---- */

/* Cases that are for the host alone are for command buffers here. */
static uint32_t commands_for(enum build_command command)
{
    switch (command) {
    case COMMAND_NV:
        return 1 << COMMAND_NV;
    case COMMAND_INDIRECT:
        return 1 << COMMAND_HOST | 1 << COMMAND_INDIRECT;
    default:
        return 1 << COMMAND_HOST | 1 << COMMAND_DEVICE;
    }
}

/* use_instance_pointers() writes no pointers to instances with motion. */
static bool has_plain_instances(const struct test_case *test_case)
{
    return strstr(test_case->name, "instance") != NULL && strstr(test_case->name, "motion") == NULL;
}

static bool is_for_command(const struct test_case *test_case, enum build_command command)
{
    return (test_case->commands & commands_for(command)) != 0 ||
           (test_case->refused & UINT64_C(1) << command) != 0;
}

bool variant_fits(const struct call_play *play)
{
    const struct variant *variant = play->variant;
    const struct platform *platform = play->platform;
    const struct test_case *test_case = play->test_case;
    enum rule rules[2 * CASE_RULES];
    const uint32_t count = judge_rules(play, rules);
    if (!is_for_command(test_case, variant->command) ||
        (variant->instance_pointers && !has_plain_instances(test_case)))
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (rule_id(rules[i], variant->command) == NULL)
            return false;
    if (platform->is_guarded && test_case->guard_warns)
        return false;
    return !test_case->is_wild || platform->is_null || platform->is_cpu ||
           (platform->is_guarded && test_case->guard_protects);
}

/* ---- the scene ---- */

/* Pointers to the instances where they are, in the second half of their buffer. */
static void use_instance_pointers(struct scene *scene)
{
    VkAccelerationStructureGeometryInstancesDataKHR *instances =
        &scene->geometries[TLAS][0].geometry.instances;
    VkAccelerationStructureBuildRangeInfoKHR *range = &scene->ranges[TLAS][0];
    const VkDeviceSize half = SCENE_BUFFER_SIZE / 2;
    uint64_t *pointers = (uint64_t *)(void *)(scene->instances.bytes + half);

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
        if (*(const uint64_t *)(const void *)(scene->instances.bytes + at) == 0)
            return true;
    return false;
}

static struct scene *open_scene(const struct call_play *play, struct fixture *fixture)
{
    const struct platform *platform = play->platform;
    fixture->copies_inputs = true;
    struct scene *scene = judge_open_scene(play, fixture);
    if (play->geometry_pointers)
        scene_use_geometry_pointers(scene);
    if (play->variant->instance_pointers)
        use_instance_pointers(scene);
    if (!platform->is_null && !platform->is_cpu && has_null_pointers(scene))
        scene_skip(scene, "a driver may read behind null pointers");
    return scene;
}

/* ---- the call ---- */

/* A command that refuses the kind of build says so at the call. */
static bool expect_refusal_alone(const struct call_play *play, const struct fixture *fixture,
                                 struct report *report)
{
    const struct messages *messages = &fixture->instance.messages;
    const char *refusal = rule_id(play->test_case->refusal, play->command);
    return (judge_is_refused(play) && !play->is_repaired &&
            messages_count(messages, refusal, NULL) == messages->count) ||
           report_expect_none(report, messages, "the call", "before the submission was waited for");
}

static bool record_and_submit(const struct call_play *play, struct fixture *fixture,
                              struct scene *scene, struct report *report)
{
    const VkQueue queue = scene_queue(scene, scene_family(scene));
    scene_call(scene);
    scene_end(scene, scene->command_buffer);
    GET(commands_submit(scene->vk, queue, scene->command_buffer, VK_NULL_HANDLE));
    const bool good = expect_refusal_alone(play, fixture, report);
    GET(scene->vk->QueueWaitIdle(queue));
    return good;
}

bool content_call(const struct call_play *play, struct fixture *fixture, struct report *report)
{
    const struct messages *messages = &fixture->instance.messages;
    messages_clear(&fixture->instance.messages);
    fixture->instance.messages.answer = VK_FALSE;
    struct scene *scene = open_scene(play, fixture);
    bool good = false;
    if (scene->skip != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        report_say(report, "%s", scene->skip);
    } else if (report_expect_none(report, messages, "the call", "before it")) {
        good = record_and_submit(play, fixture, scene, report);
    }
    const uint32_t count = messages->count;
    scene_close(scene); /* nothing is said twice, or when objects go */
    return (messages->count == count ||
            report_expect_none(report, messages, "the call", "after the wait")) &&
           good;
}
