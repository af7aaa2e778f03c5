/* SPDX-License-Identifier: Apache-2.0 */
/* One call of a case, recorded and submitted in a scene of its own; and such submissions. */
#include <string.h>

#include "tests/rules/submitted/variant.h"

/* What the host does to the data of this call. */
static enum change change_of(const struct play *play, const struct call *call)
{
    return call->is_mutation ? play->variant->change : CHANGE_NOTHING;
}

/* ---- submissions ---- */

SCENE_CREATES(create_fence, Fence, VkFence, VkFenceCreateInfo)
SCENE_CREATES(create_semaphore, Semaphore, VkSemaphore, VkSemaphoreCreateInfo)

static void create_fence_and_timeline(struct scene *scene)
{
    const STRUCT(VkFenceCreateInfo, fence_info);
    const STRUCT(VkSemaphoreTypeCreateInfo, type, .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE);
    const STRUCT(VkSemaphoreCreateInfo, create_info, .pNext = &type);
    scene->fence = create_fence(scene, &fence_info);
    scene->timeline = create_semaphore(scene, &create_info);
}

static VkQueue queue_of(const struct scene *scene)
{
    return scene_queue(scene, scene_family(scene));
}

/* Ends the command buffer of the call; a secondary one gets a primary one around it. */
static void submission_prepare(struct scene *scene)
{
    const VkCommandBuffer recorded = scene->command_buffer;
    scene_end(scene, recorded);
    if (scene->fixture->records_secondary) {
        scene->command_buffer = scene_begin_own(scene);
        scene->vk->CmdExecuteCommands(scene->command_buffer, 1, &recorded);
        scene_end(scene, scene->command_buffer);
    }
    if (scene->fence == VK_NULL_HANDLE)
        create_fence_and_timeline(scene);
}

/* Submits it, behind what the scene submitted before; with a fence. May be done again when it is
 * complete. */
static void submission_begin(struct scene *scene)
{
    static const VkPipelineStageFlags stages[SCENE_SEMAPHORES_MAX] = {
        [0 ... SCENE_SEMAPHORES_MAX - 1] = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT};
    const uint64_t value = ++scene->timeline_value;
    const uint64_t no_values[SCENE_SEMAPHORES_MAX] = {0};
    const STRUCT(VkTimelineSemaphoreSubmitInfo, values,
                 .waitSemaphoreValueCount = scene->inputs.semaphore_count,
                 .pWaitSemaphoreValues = no_values, .signalSemaphoreValueCount = 1,
                 .pSignalSemaphoreValues = &value);
    const STRUCT(VkSubmitInfo, submit_info, .pNext = &values, .signalSemaphoreCount = 1,
                 .pSignalSemaphores = &scene->timeline,
                 .waitSemaphoreCount = scene->inputs.semaphore_count,
                 .pWaitSemaphores = scene->inputs.semaphores, .pWaitDstStageMask = stages,
                 .commandBufferCount = 1, .pCommandBuffers = &scene->command_buffer);

    GET(scene->vk->ResetFences(scene->fixture->device, 1, &scene->fence));
    GET(scene->vk->QueueSubmit(queue_of(scene), 1, &submit_info, scene->fence));
    scene->inputs.semaphore_count = 0;
}

static void poll(const struct scene *scene)
{
    VkResult result;
    do
        result = scene->vk->GetFenceStatus(scene->fixture->device, scene->fence);
    while (result == VK_NOT_READY);
    GET(result);
}

static void wait_for_timeline(const struct scene *scene)
{
    const STRUCT(VkSemaphoreWaitInfo, info, .semaphoreCount = 1, .pSemaphores = &scene->timeline,
                 .pValues = &scene->timeline_value);
    GET(scene->vk->WaitSemaphores(scene->fixture->device, &info, UINT64_MAX));
}

static void submission_wait(struct scene *scene, enum waiting waiting)
{
    const VkDevice device = scene->fixture->device;

    switch (waiting) {
    case WAIT_FENCE:
        GET(scene->vk->WaitForFences(device, 1, &scene->fence, VK_TRUE, UINT64_MAX));
        break;
    case WAIT_FENCE_STATUS:
        poll(scene);
        break;
    case WAIT_TIMELINE:
        wait_for_timeline(scene);
        break;
    case WAIT_QUEUE:
        GET(scene->vk->QueueWaitIdle(queue_of(scene)));
        break;
    case WAIT_DEVICE:
        GET(scene->vk->DeviceWaitIdle(device));
        break;
    }
}

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

static struct scene *open_scene(const struct play *play, struct fixture *fixture,
                                const struct call *call)
{
    const struct variant *variant = play->variant;
    struct parameters parameters;

    fixture->inputs = variant->inputs;
    fixture->uses_two_queues = variant->uses_two_queues;
    fixture->records_secondary = variant->in_secondary;
    struct scene *scene = scene_open(fixture, variant->command);
    if (call->prepare != NULL)
        call->prepare(scene);
    memcpy(parameters.infos, scene->infos, sizeof(parameters.infos));
    memcpy(parameters.geometries, scene->geometries, sizeof(parameters.geometries));
    memcpy(parameters.ranges, scene->ranges, sizeof(parameters.ranges));
    scene_inputs_remember(scene);
    scene->is_edited = true;
    if (call->mutate != NULL)
        call->mutate(scene);
    if (change_of(play, call) != CHANGE_NOTHING &&
        (have_changed(scene, &parameters) || !scene_inputs_differ(scene)))
        scene_skip(scene, "not the data of the scene alone is what is bad");
    if (variant->geometry_pointers)
        scene_use_geometry_pointers(scene);
    if (variant->instance_pointers)
        use_instance_pointers(scene);
    if (!fixture->instance.platform->is_null && !fixture->instance.platform->is_cpu &&
        has_null_pointers(scene))
        scene_skip(scene, "a driver may read behind null pointers");
    return scene;
}

/* ---- the call ---- */

/* A command that refuses the kind of build says so at the call. */
static bool expect_refusal_alone(const struct play *play, const struct fixture *fixture,
                                 const struct call *call, const char *when, struct report *report)
{
    const struct refusal *refusal = play->test_case->refusal;
    if (!judge_is_refused(play) || call->prepare == NULL ||
        messages_count(&fixture->instance.messages, rule_id(refusal->rule, refusal->command),
                       NULL) != fixture->instance.messages.count)
        return report_expect_none(report, &fixture->instance.messages, call->what, when);
    return true;
}

static bool submit(const struct play *play, struct fixture *fixture, struct scene *scene,
                   const struct call *call, struct report *report)
{
    scene_inputs_upload(scene);
    submission_begin(scene);
    const bool good =
        expect_refusal_alone(play, fixture, call, "before the submission was waited for", report);
    submission_wait(scene, play->variant->waiting);
    return good;
}

/* The better one of the two kinds of data is submitted first, or is there during recording. */
static bool record_and_submit(const struct play *play, struct fixture *fixture, struct scene *scene,
                              const struct call *call, struct report *report)
{
    bool good = true;

    if (change_of(play, call) == CHANGE_FOR_THE_WORSE ||
        change_of(play, call) == CHANGE_AND_RESUBMIT)
        scene_inputs_exchange(scene);
    scene_call(scene);
    if (call->then != NULL)
        call->then(scene);
    submission_prepare(scene);
    if (change_of(play, call) == CHANGE_AND_RESUBMIT)
        good = submit(play, fixture, scene, call, report) &&
               expect_refusal_alone(play, fixture, call, "at the first submission", report);
    if (change_of(play, call) != CHANGE_NOTHING)
        scene_inputs_exchange(scene);
    return submit(play, fixture, scene, call, report) && good;
}

/* Nothing is said twice, or when objects go. */
static bool close_scene(struct fixture *fixture, struct scene *scene, const struct call *call,
                        struct report *report)
{
    const uint32_t count = fixture->instance.messages.count;
    GET(scene->vk->QueueWaitIdle(queue_of(scene))); /* a semaphore is signaled before a fence */
    scene_close(scene);
    return fixture->instance.messages.count == count ||
           report_expect_none(report, &fixture->instance.messages, call->what, "after the wait");
}

bool content_call(const struct play *play, struct fixture *fixture, const struct call *call,
                  struct report *report)
{
    messages_clear(&fixture->instance.messages);
    fixture->instance.messages.answer = VK_FALSE;
    struct scene *scene = open_scene(play, fixture, call);
    bool good = false;
    if (scene->skip != NULL) {
        report->outcome = OUTCOME_SKIPPED;
        report_say(report, "%s", scene->skip);
    } else if (report_expect_none(report, &fixture->instance.messages, call->what,
                                  "before the call")) {
        good = record_and_submit(play, fixture, scene, call, report);
    }
    return close_scene(fixture, scene, call, report) && good;
}
