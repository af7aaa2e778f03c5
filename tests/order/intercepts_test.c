/* SPDX-License-Identifier: Apache-2.0 */
/* What the intercepts of layer/intercepts/queues.c tell the order of submissions, and that they
 * forward. */
#include "fake_device.h"

DEVICE_TEST(submits_are_observed_and_forwarded)
{
    create_semaphore(S, VK_SEMAPHORE_TYPE_BINARY, NULL);
    create_semaphore(T, VK_SEMAPHORE_TYPE_TIMELINE, NULL);
    PLAIN(.queue = 1, .name = 10, .signal = S);
    assert_string_equal(reached, "QueueSubmit");
    PLAIN(.queue = 2, .name = 20, .wait = S, .signal = T, .signal_value = 7);
    PLAIN(.queue = 3, .name = 30, .wait = T, .wait_value = 7);
    assert_true(follows(p, 20, 10) && follows(p, 30, 20));

    SECOND(.queue = 4, .name = 40, .wait = T, .wait_value = 8,
           .wait_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    assert_string_equal(reached, "QueueSubmit2");
    assert_null(find_run(p, 40));
    submit_second(&(struct batch){.queue = 3,
                                  .name = 31,
                                  .signal = T,
                                  .signal_value = 9,
                                  .signal_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
                  entry_QueueSubmit2KHR);
    assert_string_equal(reached, "QueueSubmit2KHR");
    assert_true(follows(p, 40, 31));
}

TEST(stages_of_waits_count)
{
    const struct {
        VkPipelineStageFlags stages;
        bool orders;
    } cases[] = {
        {VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, true},
        {VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, true},
        {VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, false},
        {VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, false},
        {VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, true},
        {VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR |
             VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR,
         true},
    };
    for (uint32_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct program p;
        fake_device_start(&p);
        create_semaphore(S, VK_SEMAPHORE_TYPE_TIMELINE, NULL);
        PLAIN(.queue = 1, .name = 10, .signal = S, .signal_value = 1);
        PLAIN(.queue = 2, .name = 20, .wait = S, .wait_value = 1, .wait_stages = cases[i].stages);
        SECOND(.queue = 3, .name = 30, .wait = S, .wait_value = 1, .wait_stages = cases[i].stages);
        assert_int_equal(follows(&p, 20, 10), cases[i].orders);
        assert_int_equal(follows(&p, 30, 10), cases[i].orders);
        program_stop(&p);
    }
}

TEST(stages_of_signals_count)
{
    const struct {
        VkPipelineStageFlags2 stages;
        bool orders;
    } cases[] = {
        {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, true},
        {VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, false},
        {VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, true},
        {VK_PIPELINE_STAGE_2_NONE, false},
        {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, false},
        {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_COPY_BIT_KHR, false},
        {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, true},
    };
    for (uint32_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct program p;
        fake_device_start(&p);
        create_semaphore(S, VK_SEMAPHORE_TYPE_TIMELINE, NULL);
        SECOND(.queue = 1, .name = 10, .signal = S, .signal_value = 1,
               .signal_stages = cases[i].stages);
        PLAIN(.queue = 2, .name = 20, .wait = S, .wait_value = 1);
        assert_int_equal(follows(&p, 20, 10), cases[i].orders);
        program_stop(&p);
    }
}

/* A semaphore of one physical device says nothing of another. */
DEVICE_TEST(batches_on_several_physical_devices_are_not_ordered)
{
    const uint32_t zero = 0, both = 3, first = 1;
    STRUCT(VkDeviceGroupSubmitInfo, group, .waitSemaphoreCount = 1,
           .pWaitSemaphoreDeviceIndices = &zero, .commandBufferCount = 1,
           .pCommandBufferDeviceMasks = &both);
    create_semaphore(S, VK_SEMAPHORE_TYPE_TIMELINE, NULL);
    PLAIN(.queue = 1, .name = 10, .signal = S, .signal_value = 1);
    PLAIN(.queue = 2, .name = 20, .wait = S, .wait_value = 1, .group = &group);
    assert_true(follows(p, 20, 10)); /* there is only one */
    device.physical_device_count = 2;
    PLAIN(.queue = 3, .name = 30, .wait = S, .wait_value = 1, .group = &group);
    assert_false(follows(p, 30, 10));
    group.pCommandBufferDeviceMasks = &first;
    PLAIN(.queue = 4, .name = 40, .wait = S, .wait_value = 1, .group = &group);
    assert_true(follows(p, 40, 10));
    SECOND(.queue = 5, .name = 50, .wait = S, .wait_value = 1,
           .wait_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT); /* mask 0: all */
    SECOND(.queue = 6, .name = 60, .wait = S, .wait_value = 1,
           .wait_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, .device_mask = 1);
    assert_false(follows(p, 50, 10));
    assert_true(follows(p, 60, 10));
}

DEVICE_TEST(a_skipped_call_does_not_go_down)
{
    p->skip_name = 10;
    assert_int_equal(PLAIN(.queue = 1, .name = 10), VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(SECOND(.queue = 1, .name = 10), VK_ERROR_VALIDATION_FAILED_EXT);
    assert_int_equal(calls, 0);
    assert_int_equal(p->run_count, 0);
    p->skip_name = 0;
    next_result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    assert_int_equal(PLAIN(.queue = 1, .name = 11), VK_ERROR_OUT_OF_DEVICE_MEMORY);
    next_result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    assert_int_equal(SECOND(.queue = 1, .name = 12), VK_ERROR_OUT_OF_DEVICE_MEMORY);
    assert_int_equal(p->run_count, 0);
    assert_int_equal(p->losses, 0);
}

DEVICE_TEST(bindings_are_observed)
{
    VkSemaphore wait = SEMAPHORE(S), signal = SEMAPHORE(T);
    const STRUCT(VkBindSparseInfo, info, .waitSemaphoreCount = 1, .pWaitSemaphores = &wait,
                 .signalSemaphoreCount = 1, .pSignalSemaphores = &signal);
    create_semaphore(S, VK_SEMAPHORE_TYPE_BINARY, NULL);
    create_semaphore(T, VK_SEMAPHORE_TYPE_BINARY, NULL);
    create_fence(F, NULL);
    PLAIN(.queue = 1, .name = 10, .signal = S);
    assert_int_equal(entry_QueueBindSparse(QUEUE(2), 1, &info, FENCE(F)), VK_SUCCESS);
    assert_string_equal(reached, "QueueBindSparse");
    PLAIN(.queue = 3, .name = 30, .wait = T);
    assert_true(follows(p, 30, 10));
    assert_int_equal(entry_GetFenceStatus(NULL, FENCE(F)), VK_SUCCESS);
    PLAIN(.queue = 4, .name = 40);
    assert_true(follows(p, 40, 10));
}
