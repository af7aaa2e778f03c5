/* SPDX-License-Identifier: Apache-2.0 */
/* What findings say of the submission: its number, and the labels that were open in its queue. */
#include "tests/snapshots/scene.h"

static void open_scene(void)
{
    scene_open(
        &(struct scene_setup){.boxes_size = sizeof(VkAabbPositionsKHR), .structure_size = 1 << 20});
}

static void begin_label(const char *name)
{
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = name);
    fixture.vk.QueueBeginDebugUtilsLabelEXT(fixture.queue, &label);
}

static void end_label(void)
{
    fixture.vk.QueueEndDebugUtilsLabelEXT(fixture.queue);
}

/* An update of what was built without allowing it, which is found when it is submitted. */
static void submit_update(void)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    const struct fixture_build build = {
        .geometry = boxes_geometry(scene.boxes.address, sizeof(VkAabbPositionsKHR)),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR,
                 .srcAccelerationStructure = scene.blas,
                 .dstAccelerationStructure = scene.blas,
                 .scratchData.deviceAddress = scene.scratch_address},
        .range.primitiveCount = 1,
    };
    fixture_build(&fixture, commands, &build);
    scene_submit(commands);
}

/* If the box is upside down, that is found when the submission is complete. */
static void submit_box(void)
{
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    scene_submit(commands);
}

TEST_BETWEEN(test_a_finding_at_submission, open_scene, scene_wait_and_close)
{
    submit_box();
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    begin_label("frame \"7\"\n");
    begin_label("updates");
    submit_update();
    end_label();
    end_label();
    expect_messages(1, ", submission 2, queue labels \"frame \\\"7\\\"\\n\" > \"updates\".");
    fixture.vk.QueueInsertDebugUtilsLabelEXT(fixture.queue,
                                             &MAKE(VkDebugUtilsLabelEXT, .pLabelName = "here"));
    submit_update();
    expect_messages(1, ", submission 3, queue labels \"here\".");
    end_label(); /* of nothing; ends what was inserted */
    submit_update();
    expect_messages(1, ", submission 4.");
}

/* The labels are those of the submission, whatever is open when the finding is made. */
TEST_BETWEEN(test_a_finding_at_completion, open_scene, scene_wait_and_close)
{
    scene_invalidate_box(0);
    begin_label("first");
    submit_box();
    end_label();
    begin_label("second");
    submit_box();
    end_label();
    begin_label("third");
    fixture.instance.messages.answer = VK_FALSE;
    GET(fixture.vk.DeviceWaitIdle(fixture.device));
    end_label();
    const struct messages *messages = &fixture.instance.messages;
    assert_int_equal(messages->count, 2);
    assert_has(messages->items[0].text, ", submission 1, queue labels \"first\".");
    assert_has(messages->items[1].text, ", submission 2, queue labels \"second\".");
    messages_clear(&fixture.instance.messages);
}
