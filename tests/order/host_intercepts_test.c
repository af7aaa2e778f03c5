/* SPDX-License-Identifier: Apache-2.0 */
/* What the intercepts of layer/intercepts/sync.c, and those of presentation, tell the order of
 * others' signals and of what the host sees. */
#include "fake_device.h"

CALL_AS(present,
        entry_QueuePresentKHR(QUEUE(1), &MAKE(VkPresentInfoKHR, .waitSemaphoreCount = 1,
                                              .pWaitSemaphores = &(VkSemaphore){SEMAPHORE(S)})))
CALL_AS(acquire, entry_AcquireNextImageKHR(NULL, VK_NULL_HANDLE, 0, SEMAPHORE(S), VK_NULL_HANDLE,
                                           &(uint32_t){0}))
CALL_AS(acquire_2,
        entry_AcquireNextImage2KHR(NULL,
                                   &MAKE(VkAcquireNextImageInfoKHR, .semaphore = SEMAPHORE(S)),
                                   &(uint32_t){0}))
CALL_AS(import_semaphore, entry_ImportSemaphoreFdKHR(NULL, &MAKE(VkImportSemaphoreFdInfoKHR,
                                                                 .semaphore = SEMAPHORE(S))))

CALL_AS(sleep, entry_LatencySleepNV(NULL, VK_NULL_HANDLE,
                                    &MAKE(VkLatencySleepInfoNV, .signalSemaphore = SEMAPHORE(S))))

static VkResult (*const others_signal[])(void) = {present, acquire, acquire_2, import_semaphore,
                                                  sleep};

TEST(what_others_signal_brings_no_order)
{
    for (uint32_t i = 0; i < sizeof(others_signal) / sizeof(others_signal[0]); i++) {
        struct program p;
        fake_device_start(&p);
        create_semaphore(S, VK_SEMAPHORE_TYPE_BINARY, NULL);
        PLAIN(.queue = 1, .name = 10, .signal = S);
        others_signal[i]();
        PLAIN(.queue = 2, .name = 20, .wait = S);
        assert_false(follows(&p, 20, 10));
        program_stop(&p);
    }
}

DEVICE_TEST(shared_semaphores_and_fences_bring_no_order)
{
    const STRUCT(VkExportSemaphoreCreateInfo, semaphore,
                 .handleTypes = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT);
    const STRUCT(VkExportFenceCreateInfo, fence,
                 .handleTypes = VK_EXTERNAL_FENCE_HANDLE_TYPE_OPAQUE_FD_BIT);
    const STRUCT(VkImportFenceFdInfoKHR, import, .fence = FENCE(F + 1));
    create_semaphore(S, VK_SEMAPHORE_TYPE_TIMELINE, &semaphore);
    create_fence(F, &fence);
    create_fence(F + 1, NULL);
    entry_ImportFenceFdKHR(NULL, &import);
    PLAIN(.queue = 1, .name = 10, .signal = S, .signal_value = 1, .fence = F);
    PLAIN(.queue = 1, .name = 11, .fence = F + 1);
    entry_GetFenceStatus(NULL, FENCE(F));
    entry_GetFenceStatus(NULL, FENCE(F + 1));
    PLAIN(.queue = 2, .name = 20);
    PLAIN(.queue = 3, .name = 30, .wait = S, .wait_value = 1);
    assert_false(follows(p, 20, 10));
    assert_false(follows(p, 30, 10));
    assert_false(find_run(p, 30)->predecessors_known);
}

/* ---- what the host sees */

#define FENCES(...)                                                                                \
    sizeof((VkFence[]){__VA_ARGS__}) / sizeof(VkFence), (VkFence[])                                \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }
CALL_AS(wait_fence, entry_WaitForFences(NULL, FENCES(FENCE(F)), VK_FALSE, 0))
CALL_AS(wait_fences, entry_WaitForFences(NULL, FENCES(FENCE(F), FENCE(F)), VK_TRUE, 0))
CALL_AS(wait_any_fence, entry_WaitForFences(NULL, FENCES(FENCE(F), FENCE(F + 1)), VK_FALSE, 0))
CALL_AS(fence_status, entry_GetFenceStatus(NULL, FENCE(F)))

/* Waits for values of the timeline T. */
static VkResult wait_values(uint32_t count, const uint64_t *values, VkSemaphoreWaitFlags flags,
                            PFN_vkWaitSemaphores wait)
{
    VkSemaphore semaphores[] = {SEMAPHORE(T), SEMAPHORE(T)};
    const STRUCT(VkSemaphoreWaitInfo, info, .flags = flags, .semaphoreCount = count,
                 .pSemaphores = semaphores, .pValues = values);
    return wait(NULL, &info, 0);
}

static const uint64_t zero_and_five[] = {0, 5};
CALL_AS(wait_semaphore,
        wait_values(1, zero_and_five + 1, VK_SEMAPHORE_WAIT_ANY_BIT, entry_WaitSemaphores))
CALL_AS(wait_all_semaphores, wait_values(2, zero_and_five, 0, entry_WaitSemaphoresKHR))
CALL_AS(wait_any_semaphore,
        wait_values(2, zero_and_five, VK_SEMAPHORE_WAIT_ANY_BIT, entry_WaitSemaphores))

static VkResult read_counter(PFN_vkGetSemaphoreCounterValue read)
{
    uint64_t value;
    counter = 5;
    return read(NULL, SEMAPHORE(T), &value);
}

CALL_AS(semaphore_counter, read_counter(entry_GetSemaphoreCounterValue))
CALL_AS(semaphore_counter_khr, read_counter(entry_GetSemaphoreCounterValueKHR))
CALL_AS(queue_idle, entry_QueueWaitIdle(QUEUE(1)))
CALL_AS(other_queue_idle, entry_QueueWaitIdle(QUEUE(2)))
CALL_AS(device_idle, entry_DeviceWaitIdle(NULL))

static const struct {
    VkResult (*look)(void);
    bool sees;
} looks[] = {
    {wait_fence, true},          {wait_fences, true},       {wait_any_fence, false},
    {fence_status, true},        {wait_semaphore, true},    {wait_all_semaphores, true},
    {wait_any_semaphore, false}, {semaphore_counter, true}, {semaphore_counter_khr, true},
    {queue_idle, true},          {other_queue_idle, false}, {device_idle, true},
};

static void submit_10(void)
{
    create_fence(F, NULL);
    create_fence(F + 1, NULL);
    create_semaphore(T, VK_SEMAPHORE_TYPE_TIMELINE, NULL);
    PLAIN(.queue = 1, .name = 10, .signal = T, .signal_value = 5, .fence = F);
}

TEST(the_host_sees_what_calls_return)
{
    for (uint32_t i = 0; i < sizeof(looks) / sizeof(looks[0]); i++) {
        struct program p;
        fake_device_start(&p);
        submit_10();
        next_result = VK_NOT_READY; /* or a timeout */
        assert_int_equal(looks[i].look(), VK_NOT_READY);
        PLAIN(.queue = 2, .name = 20);
        assert_int_equal(looks[i].look(), VK_SUCCESS);
        PLAIN(.queue = 3, .name = 30);
        assert_false(follows(&p, 20, 10));
        assert_int_equal(follows(&p, 30, 10), looks[i].sees);

        next_result = VK_ERROR_DEVICE_LOST;
        assert_int_equal(looks[i].look(), VK_ERROR_DEVICE_LOST);
        assert_int_equal(p.losses, 1);
        program_stop(&p);
    }
}

DEVICE_TEST(fences_are_reset)
{
    VkFence fence = FENCE(F);
    submit_10();
    assert_int_equal(entry_ResetFences(NULL, 1, &fence), VK_SUCCESS);
    fence_status();
    PLAIN(.queue = 2, .name = 20);
    assert_false(follows(p, 20, 10));
    PLAIN(.queue = 1, .name = 11, .fence = F);
    entry_DestroyFence(NULL, fence, NULL);
    create_fence(F, NULL);
    fence_status();
    PLAIN(.queue = 2, .name = 21);
    assert_false(follows(p, 21, 11));
}

TEST(the_host_signals)
{
    const STRUCT(VkSemaphoreSignalInfo, info, .semaphore = SEMAPHORE(S), .value = 1);
    const PFN_vkSignalSemaphore signals[] = {entry_SignalSemaphore, entry_SignalSemaphoreKHR};
    for (uint32_t i = 0; i < 2; i++) {
        struct program p;
        fake_device_start(&p);
        create_semaphore(S, VK_SEMAPHORE_TYPE_TIMELINE, NULL);
        PLAIN(.queue = 1, .name = 10, .wait = S, .wait_value = 1);
        next_result = VK_ERROR_OUT_OF_HOST_MEMORY;
        assert_int_equal(signals[i](NULL, &info), VK_ERROR_OUT_OF_HOST_MEMORY);
        assert_int_equal(p.run_count, 0);
        assert_int_equal(signals[i](NULL, &info), VK_SUCCESS);
        assert_int_equal(p.run_count, 1);
        entry_DestroySemaphore(NULL, SEMAPHORE(S), NULL);
        assert_string_equal(reached, "DestroySemaphore");
        program_stop(&p);
    }
}

/* Below level execution there is no order. */
DEVICE_TEST(without_an_order_calls_are_forwarded)
{
    device.order = NULL;
    create_semaphore(S, VK_SEMAPHORE_TYPE_TIMELINE, NULL);
    create_fence(F, NULL);
    assert_int_equal(PLAIN(.queue = 1, .name = 10, .wait = S, .wait_value = 1, .fence = F),
                     VK_SUCCESS);
    assert_int_equal(SECOND(.queue = 1, .name = 10), VK_SUCCESS);
    assert_int_equal(entry_QueueSubmit(QUEUE(1), 0, NULL, FENCE(F)), VK_SUCCESS);
    calls = 0;
    for (uint32_t i = 0; i < sizeof(looks) / sizeof(looks[0]); i++)
        assert_int_equal(looks[i].look(), VK_SUCCESS);
    for (uint32_t i = 0; i < sizeof(others_signal) / sizeof(others_signal[0]); i++)
        others_signal[i]();
    assert_int_equal(calls, sizeof(looks) / sizeof(looks[0]) +
                                sizeof(others_signal) / sizeof(others_signal[0]));
    assert_int_equal(p->run_count, 0);
}
