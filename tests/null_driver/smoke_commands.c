/* SPDX-License-Identifier: Apache-2.0 */
/* The null driver's commands, synchronization, counters and failures. */
#include "smoke.h"

#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

DEVICE_TEST(test_build_commands)
{
    const VkCommandPool pool = command_pool_create(&vk, device);
    const VkCommandBuffer commands = make_command_buffer(pool);
    const void *bad = (const void *)(uintptr_t)0x10;
    const VkAccelerationStructureNV none = VK_NULL_HANDLE;
    vk.CmdBuildAccelerationStructuresKHR(commands, UINT32_MAX, bad, bad);
    vk.CmdBuildAccelerationStructuresIndirectKHR(commands, UINT32_MAX, bad, bad, bad, bad);
    vk.CmdBuildAccelerationStructureNV(commands, bad, VK_NULL_HANDLE, 0, VK_FALSE, none, none,
                                       VK_NULL_HANDLE, 0);
    GET(vk.EndCommandBuffer(commands));
    GET(vk.BuildAccelerationStructuresKHR(device, VK_NULL_HANDLE, UINT32_MAX, bad, bad));

    const VkFence fence = fence_create(&vk, device);
    assert_int_equal(vk.GetFenceStatus(device, fence), VK_NOT_READY);
    GET(commands_submit(&vk, queue, commands, fence));
    GET(vk.WaitForFences(device, 1, &fence, VK_TRUE, UINT64_MAX));

    vk.FreeCommandBuffers(device, pool, 1, &commands);
    vk.CmdBuildAccelerationStructuresKHR(commands, 1, bad, bad);
    const VkCommandBuffer other = make_command_buffer(pool);
    assert_ptr_not_equal(other, commands);
    vk.DestroyCommandPool(device, pool, NULL);
    vk.CmdBuildAccelerationStructuresKHR(other, 1, bad, bad);
    vk.FreeCommandBuffers(device, pool, 1, &other);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructuresKHR"), 3);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructuresIndirectKHR"), 1);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructureNV"), 1);
    assert_int_equal(driver.calls("vkBuildAccelerationStructuresKHR"), 1);
}

/* ---- what else may be around a build */

DEVICE_TEST(test_scopes)
{
    const VkCommandPool pool = command_pool_create(&vk, device);
    const VkCommandBuffer commands = make_command_buffer(pool),
                          secondary = make_command_buffer(pool);
    VkRenderPass pass;
    GET(vk.CreateRenderPass(device, &MAKE(VkRenderPassCreateInfo), NULL, &pass));
    VkFramebuffer framebuffer;
    GET(vk.CreateFramebuffer(device, &MAKE(VkFramebufferCreateInfo, .renderPass = pass), NULL,
                             &framebuffer));
    const STRUCT(VkRenderPassBeginInfo, pass_begin, .renderPass = pass, .framebuffer = framebuffer);
    vk.CmdBeginRenderPass(commands, &pass_begin, VK_SUBPASS_CONTENTS_INLINE);
    vk.CmdNextSubpass(commands, VK_SUBPASS_CONTENTS_INLINE);
    vk.CmdEndRenderPass(commands);
    vk.CmdBeginRendering(commands, &MAKE(VkRenderingInfo, .flags = VK_RENDERING_SUSPENDING_BIT));
    vk.CmdEndRendering(commands);
    vk.CmdExecuteCommands(commands, 1, &secondary);
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = "label");
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, name, .objectType = VK_OBJECT_TYPE_RENDER_PASS,
                 .objectHandle = (uint64_t)(uintptr_t)pass, .pObjectName = "pass");
    vk.CmdBeginDebugUtilsLabelEXT(commands, &label);
    vk.CmdEndDebugUtilsLabelEXT(commands);
    vk.QueueBeginDebugUtilsLabelEXT(queue, &label);
    vk.QueueEndDebugUtilsLabelEXT(queue);
    GET(vk.SetDebugUtilsObjectNameEXT(device, &name));
    vk.CmdBeginVideoCodingKHR(commands, NULL);
    vk.CmdEndVideoCodingKHR(commands, NULL);
    GET(vk.EndCommandBuffer(commands));
    assert_int_equal(driver.calls("vkCmdBeginRenderingKHR"), 1); /* counts with its core name */
    assert_int_equal(driver.calls("vkCmdExecuteCommands"), 1);
    assert_int_equal(driver.calls("vkCmdBeginDebugUtilsLabelEXT"), 1);
    assert_int_equal(driver.calls("vkSetDebugUtilsObjectNameEXT"), 1);
    assert_int_equal(driver.calls("vkCmdEndVideoCodingKHR"), 1);
}

static void *record(void *unused)
{
    const VkCommandPool pool = command_pool_create(&vk, device);
    for (int i = 0; i < 200; i++) {
        const VkCommandBuffer commands = make_command_buffer(pool);
        const VkBuffer buffer = make_buffer(0, 4096);
        const VkDeviceMemory memory = make_memory(1, 4096);
        GET(vk.BindBufferMemory(device, buffer, memory, 0));
        assert_int_not_equal(address_of(buffer), 0);
        vk.CmdBuildAccelerationStructuresKHR(commands, 0, NULL, NULL);
        vk.DestroyBuffer(device, buffer, NULL);
        vk.FreeMemory(device, memory, NULL);
        vk.FreeCommandBuffers(device, pool, 1, &commands);
    }
    vk.DestroyCommandPool(device, pool, NULL);
    return NULL;
}

DEVICE_TEST(test_threads)
{
    enum { THREADS = 4 };
    unit_test_run_threads(THREADS, record, NULL, 0);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructuresKHR"), 200 * THREADS);
}

/* ---- what a test asks the driver for */

DEVICE_TEST(test_failures)
{
    const STRUCT(VkFenceCreateInfo, info);
    VkFence fence;
    driver.fail_next("vkCreateFence", VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(vk.CreateFence(device, &info, NULL, &fence), VK_ERROR_OUT_OF_HOST_MEMORY);
    GET(vk.CreateFence(device, &info, NULL, &fence));
    assert_int_equal(driver.calls("vkCreateFence"), 2);
    assert_true(driver.calls("vkNoSuchCommand") == UINT64_MAX);

    driver.set_device_lost(true);
    assert_int_equal(vk.QueueSubmit(queue, 0, NULL, fence), VK_ERROR_DEVICE_LOST);
    assert_int_equal(vk.WaitForFences(device, 1, &fence, VK_TRUE, UINT64_MAX),
                     VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
    assert_int_equal(vk.WaitForFences(device, 1, &fence, VK_TRUE, 1000), VK_TIMEOUT);
    GET(vk.QueueSubmit(queue, 0, NULL, fence));
    GET(vk.GetFenceStatus(device, fence));
}

DEVICE_TEST(test_timeline)
{
    const STRUCT(VkSemaphoreTypeCreateInfo, type, .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE,
                 .initialValue = 5);
    const STRUCT(VkSemaphoreCreateInfo, info, .pNext = &type);
    VkSemaphore semaphore;
    GET(vk.CreateSemaphore(device, &info, NULL, &semaphore));
    const STRUCT(VkSubmitInfo2, submit, .signalSemaphoreInfoCount = 1,
                 .pSignalSemaphoreInfos =
                     &MAKE(VkSemaphoreSubmitInfo, .semaphore = semaphore, .value = 9));
    uint64_t value;
    GET(vk.GetSemaphoreCounterValue(device, semaphore, &value));
    assert_int_equal(value, 5);
    GET(vk.QueueSubmit2(queue, 1, &submit, VK_NULL_HANDLE));
    GET(vk.GetSemaphoreCounterValue(device, semaphore, &value));
    assert_int_equal(value, 9);
    const uint64_t ten = 10;
    const STRUCT(VkSemaphoreWaitInfo, wait, .semaphoreCount = 1, .pSemaphores = &semaphore,
                 .pValues = &ten);
    assert_int_equal(vk.WaitSemaphores(device, &wait, 1000), VK_TIMEOUT);
}

/* Two builds, each behind a fill and an update, and a fill at the end. */
struct fault_program {
    VkCommandBuffer commands;
    VkFence fence;
    const uint32_t *words;
};

static struct fault_program make_fault_program(void)
{
    struct fault_program program;
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info);
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = NULL;
    VkBuffer buffer = make_bound_buffer(64, 1, (void **)&program.words);
    program.fence = fence_create(&vk, device);
    program.commands = make_command_buffer(command_pool_create(&vk, device));
    for (uint32_t i = 0; i < 2; i++) {
        vk.CmdFillBuffer(program.commands, buffer, 8 * i, 4, 1);
        vk.CmdUpdateBuffer(program.commands, buffer, 8 * i + 4, 4, &(uint32_t){1});
        vk.CmdBuildAccelerationStructuresKHR(program.commands, 1, &info, &ranges);
    }
    vk.CmdFillBuffer(program.commands, buffer, 16, 4, 1);
    GET(vk.EndCommandBuffer(program.commands));
    return program;
}

static VkResult submit(const struct fault_program *program)
{
    return commands_submit(&vk, queue, program->commands, program->fence);
}

static void expect_words(const struct fault_program *program, const uint32_t words[5])
{
    assert_memory_equal(program->words, words, 5 * sizeof(*words));
}

DEVICE_TEST(test_planned_loss)
{
    driver.plan_fault(&(struct null_driver_fault){
        .kind = NULL_DRIVER_LOSE, .at = NULL_DRIVER_AT_BUILD, .number = 2, .skips_copies = true});
    const struct fault_program program = make_fault_program();
    GET(submit(&program));
    expect_words(&program, (const uint32_t[]){1, 1, 1, 0, 0});
    assert_int_equal(vk.DeviceWaitIdle(device), VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
    driver.plan_fault(&(struct null_driver_fault){.at = NULL_DRIVER_AT_SUBMIT, .number = 2});
    GET(submit(&program));
    assert_int_equal(submit(&program), VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
    driver.plan_fault(&(struct null_driver_fault){.at = NULL_DRIVER_AT_WAIT, .number = 2});
    GET(vk.DeviceWaitIdle(device));
    assert_int_equal(vk.WaitForFences(device, 1, &program.fence, VK_TRUE, 1), VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
}

DEVICE_TEST(test_planned_hang)
{
    driver.plan_fault(
        &(struct null_driver_fault){.kind = NULL_DRIVER_HANG, .at = NULL_DRIVER_AT_BUILD});
    const struct fault_program program = make_fault_program();
    GET(submit(&program));
    expect_words(&program, (const uint32_t[]){1, 1, 0, 0, 0});
    assert_int_equal(vk.WaitForFences(device, 1, &program.fence, VK_TRUE, 1), VK_TIMEOUT);
    driver.end_hang();
    GET(vk.WaitForFences(device, 1, &program.fence, VK_TRUE, UINT64_MAX));
    GET(vk.DeviceWaitIdle(device));
    expect_words(&program, (const uint32_t[]){1, 1, 1, 1, 1});
}

DEVICE_TEST(test_planned_crash)
{
    const struct {
        int signal, expected;
        bool in_thread;
    } rows[] = {{0, SIGSEGV, false}, {0, SIGSEGV, true}, {SIGABRT, SIGABRT, true}};
    for (size_t i = 0; i < ARRAY_COUNT(rows); i++) {
        driver.plan_fault(&(struct null_driver_fault){.kind = NULL_DRIVER_CRASH,
                                                      .at = NULL_DRIVER_AT_BUILD,
                                                      .signal = rows[i].signal,
                                                      .in_thread = rows[i].in_thread});
        const struct fault_program program = make_fault_program();
        const pid_t child = fork();
        if (child == 0) {
            signal(SIGSEGV, SIG_DFL);
            signal(SIGABRT, SIG_DFL);
            setrlimit(RLIMIT_CORE, &(struct rlimit){0});
            submit(&program);
            _exit(0);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == rows[i].expected);
    }
    driver.plan_fault(NULL);
}
