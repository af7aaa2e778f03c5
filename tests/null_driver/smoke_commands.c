/* SPDX-License-Identifier: Apache-2.0 */
/* The null driver's commands, synchronization, counters and failures. */
#include "smoke.h"

#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static void test_build_commands(void **state)
{
    struct fixture *f = *state;
    const VkCommandPool pool = make_pool(f);
    const VkCommandBuffer commands = make_command_buffer(f, pool);
    const VkCommandBufferBeginInfo begin = MAKE(VkCommandBufferBeginInfo);
    const void *bad = (const void *)(uintptr_t)0x10;
    const VkAccelerationStructureNV none = VK_NULL_HANDLE;
    CHECK(f->vk.BeginCommandBuffer(commands, &begin));
    f->vk.CmdBuildAccelerationStructuresKHR(commands, UINT32_MAX, bad, bad);
    f->vk.CmdBuildAccelerationStructuresIndirectKHR(commands, UINT32_MAX, bad, bad, bad, bad);
    f->vk.CmdBuildAccelerationStructureNV(commands, bad, VK_NULL_HANDLE, 0, VK_FALSE, none, none,
                                          VK_NULL_HANDLE, 0);
    CHECK(f->vk.EndCommandBuffer(commands));
    CHECK(f->vk.BuildAccelerationStructuresKHR(f->device, VK_NULL_HANDLE, UINT32_MAX, bad, bad));

    VkFence fence;
    CHECK(f->vk.CreateFence(f->device, &MAKE(VkFenceCreateInfo), NULL, &fence));
    assert_int_equal(f->vk.GetFenceStatus(f->device, fence), VK_NOT_READY);
    const VkSubmitInfo submit =
        MAKE(VkSubmitInfo, .commandBufferCount = 1, .pCommandBuffers = &commands);
    CHECK(f->vk.QueueSubmit(f->queue, 1, &submit, fence));
    CHECK(f->vk.WaitForFences(f->device, 1, &fence, VK_TRUE, UINT64_MAX));

    f->vk.FreeCommandBuffers(f->device, pool, 1, &commands);
    f->vk.CmdBuildAccelerationStructuresKHR(commands, 1, bad, bad);
    const VkCommandBuffer other = make_command_buffer(f, pool);
    assert_ptr_not_equal(other, commands);
    f->vk.DestroyCommandPool(f->device, pool, NULL);
    f->vk.CmdBuildAccelerationStructuresKHR(other, 1, bad, bad);
    f->vk.FreeCommandBuffers(f->device, pool, 1, &other);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructuresKHR"), 3);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructuresIndirectKHR"), 1);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructureNV"), 1);
    assert_int_equal(driver.calls("vkBuildAccelerationStructuresKHR"), 1);
}

/* ---- what else may be around a build */

static void test_scopes(void **state)
{
    struct fixture *f = *state;
    const VkuDeviceDispatchTable *t = &f->vk;
    const VkCommandPool pool = make_pool(f);
    const VkCommandBuffer commands = make_command_buffer(f, pool),
                          secondary = make_command_buffer(f, pool);
    CHECK(t->BeginCommandBuffer(commands, &MAKE(VkCommandBufferBeginInfo)));
    VkRenderPass pass;
    CHECK(t->CreateRenderPass(f->device, &MAKE(VkRenderPassCreateInfo), NULL, &pass));
    VkFramebuffer framebuffer;
    CHECK(t->CreateFramebuffer(f->device, &MAKE(VkFramebufferCreateInfo, .renderPass = pass), NULL,
                               &framebuffer));
    const VkRenderPassBeginInfo pass_begin =
        MAKE(VkRenderPassBeginInfo, .renderPass = pass, .framebuffer = framebuffer);
    t->CmdBeginRenderPass(commands, &pass_begin, VK_SUBPASS_CONTENTS_INLINE);
    t->CmdNextSubpass(commands, VK_SUBPASS_CONTENTS_INLINE);
    t->CmdEndRenderPass(commands);
    t->CmdBeginRendering(commands, &MAKE(VkRenderingInfo, .flags = VK_RENDERING_SUSPENDING_BIT));
    t->CmdEndRendering(commands);
    t->CmdExecuteCommands(commands, 1, &secondary);
    const VkDebugUtilsLabelEXT label = MAKE(VkDebugUtilsLabelEXT, .pLabelName = "label");
    const VkDebugUtilsObjectNameInfoEXT name =
        MAKE(VkDebugUtilsObjectNameInfoEXT, .objectType = VK_OBJECT_TYPE_RENDER_PASS,
             .objectHandle = (uint64_t)(uintptr_t)pass, .pObjectName = "pass");
    t->CmdBeginDebugUtilsLabelEXT(commands, &label);
    t->CmdEndDebugUtilsLabelEXT(commands);
    t->QueueBeginDebugUtilsLabelEXT(f->queue, &label);
    t->QueueEndDebugUtilsLabelEXT(f->queue);
    CHECK(t->SetDebugUtilsObjectNameEXT(f->device, &name));
    t->CmdBeginVideoCodingKHR(commands, NULL);
    t->CmdEndVideoCodingKHR(commands, NULL);
    CHECK(t->EndCommandBuffer(commands));
    assert_int_equal(driver.calls("vkCmdBeginRenderingKHR"), 1); /* counts with its core name */
    assert_int_equal(driver.calls("vkCmdExecuteCommands"), 1);
    assert_int_equal(driver.calls("vkCmdBeginDebugUtilsLabelEXT"), 1);
    assert_int_equal(driver.calls("vkSetDebugUtilsObjectNameEXT"), 1);
    assert_int_equal(driver.calls("vkCmdEndVideoCodingKHR"), 1);
}

static void *record(void *data)
{
    struct fixture *f = data;
    const VkCommandPool pool = make_pool(f);
    for (int i = 0; i < 200; i++) {
        const VkCommandBuffer commands = make_command_buffer(f, pool);
        const VkBuffer buffer = make_buffer(f, 0, 4096);
        const VkDeviceMemory memory = make_memory(f, 1, 4096);
        CHECK(f->vk.BindBufferMemory(f->device, buffer, memory, 0));
        assert_int_not_equal(address_of(f, buffer), 0);
        f->vk.CmdBuildAccelerationStructuresKHR(commands, 0, NULL, NULL);
        f->vk.DestroyBuffer(f->device, buffer, NULL);
        f->vk.FreeMemory(f->device, memory, NULL);
        f->vk.FreeCommandBuffers(f->device, pool, 1, &commands);
    }
    f->vk.DestroyCommandPool(f->device, pool, NULL);
    return NULL;
}

static void test_threads(void **state)
{
    pthread_t threads[4];
    for (size_t i = 0; i < COUNT_OF(threads); i++)
        assert_int_equal(pthread_create(&threads[i], NULL, record, *state), 0);
    for (size_t i = 0; i < COUNT_OF(threads); i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(driver.calls("vkCmdBuildAccelerationStructuresKHR"), 200 * COUNT_OF(threads));
}

/* ---- what a test asks the driver for */

static void test_failures(void **state)
{
    struct fixture *f = *state;
    const VkFenceCreateInfo info = MAKE(VkFenceCreateInfo);
    VkFence fence;
    driver.fail_next("vkCreateFence", VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(f->vk.CreateFence(f->device, &info, NULL, &fence),
                     VK_ERROR_OUT_OF_HOST_MEMORY);
    CHECK(f->vk.CreateFence(f->device, &info, NULL, &fence));
    assert_int_equal(driver.calls("vkCreateFence"), 2);
    assert_true(driver.calls("vkNoSuchCommand") == UINT64_MAX);

    driver.set_device_lost(true);
    assert_int_equal(f->vk.QueueSubmit(f->queue, 0, NULL, fence), VK_ERROR_DEVICE_LOST);
    assert_int_equal(f->vk.WaitForFences(f->device, 1, &fence, VK_TRUE, UINT64_MAX),
                     VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
    assert_int_equal(f->vk.WaitForFences(f->device, 1, &fence, VK_TRUE, 1000), VK_TIMEOUT);
    CHECK(f->vk.QueueSubmit(f->queue, 0, NULL, fence));
    CHECK(f->vk.GetFenceStatus(f->device, fence));
}

static void test_timeline(void **state)
{
    struct fixture *f = *state;
    const VkSemaphoreTypeCreateInfo type = MAKE(
        VkSemaphoreTypeCreateInfo, .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE, .initialValue = 5);
    const VkSemaphoreCreateInfo info = MAKE(VkSemaphoreCreateInfo, .pNext = &type);
    VkSemaphore semaphore;
    CHECK(f->vk.CreateSemaphore(f->device, &info, NULL, &semaphore));
    const VkSubmitInfo2 submit = MAKE(
        VkSubmitInfo2, .signalSemaphoreInfoCount = 1,
        .pSignalSemaphoreInfos = &MAKE(VkSemaphoreSubmitInfo, .semaphore = semaphore, .value = 9));
    uint64_t value;
    CHECK(f->vk.GetSemaphoreCounterValue(f->device, semaphore, &value));
    assert_int_equal(value, 5);
    CHECK(f->vk.QueueSubmit2(f->queue, 1, &submit, VK_NULL_HANDLE));
    CHECK(f->vk.GetSemaphoreCounterValue(f->device, semaphore, &value));
    assert_int_equal(value, 9);
    const uint64_t ten = 10;
    const VkSemaphoreWaitInfo wait =
        MAKE(VkSemaphoreWaitInfo, .semaphoreCount = 1, .pSemaphores = &semaphore, .pValues = &ten);
    assert_int_equal(f->vk.WaitSemaphores(f->device, &wait, 1000), VK_TIMEOUT);
}

/* Two builds, each behind a fill and an update, and a fill at the end. */
struct fault_program {
    VkCommandBuffer commands;
    VkFence fence;
    const uint32_t *words;
};

static struct fault_program make_fault_program(struct fixture *f)
{
    struct fault_program program;
    const VkCommandBufferBeginInfo begin = MAKE(VkCommandBufferBeginInfo);
    const VkFenceCreateInfo fence = MAKE(VkFenceCreateInfo);
    const VkAccelerationStructureBuildGeometryInfoKHR info =
        MAKE(VkAccelerationStructureBuildGeometryInfoKHR);
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = NULL;
    VkBuffer buffer = make_buffer(f, 0, 64);
    VkDeviceMemory memory = make_memory(f, 1, 64);
    CHECK(f->vk.BindBufferMemory(f->device, buffer, memory, 0));
    CHECK(f->vk.MapMemory(f->device, memory, 0, 64, 0, (void **)&program.words));
    CHECK(f->vk.CreateFence(f->device, &fence, NULL, &program.fence));
    program.commands = make_command_buffer(f, make_pool(f));
    CHECK(f->vk.BeginCommandBuffer(program.commands, &begin));
    for (uint32_t i = 0; i < 2; i++) {
        f->vk.CmdFillBuffer(program.commands, buffer, 8 * i, 4, 1);
        f->vk.CmdUpdateBuffer(program.commands, buffer, 8 * i + 4, 4, &(uint32_t){1});
        f->vk.CmdBuildAccelerationStructuresKHR(program.commands, 1, &info, &ranges);
    }
    f->vk.CmdFillBuffer(program.commands, buffer, 16, 4, 1);
    CHECK(f->vk.EndCommandBuffer(program.commands));
    return program;
}

static VkResult submit(struct fixture *f, const struct fault_program *program)
{
    const VkSubmitInfo info =
        MAKE(VkSubmitInfo, .commandBufferCount = 1, .pCommandBuffers = &program->commands);
    return f->vk.QueueSubmit(f->queue, 1, &info, program->fence);
}

static void expect_words(const struct fault_program *program, const uint32_t words[5])
{
    assert_memory_equal(program->words, words, 5 * sizeof(*words));
}

static void test_planned_loss(void **state)
{
    struct fixture *f = *state;
    driver.plan_fault(&(struct null_driver_fault){
        .kind = NULL_DRIVER_LOSE, .at = NULL_DRIVER_AT_BUILD, .number = 2, .skips_copies = true});
    const struct fault_program program = make_fault_program(f);
    CHECK(submit(f, &program));
    expect_words(&program, (const uint32_t[]){1, 1, 1, 0, 0});
    assert_int_equal(f->vk.DeviceWaitIdle(f->device), VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
    driver.plan_fault(&(struct null_driver_fault){.at = NULL_DRIVER_AT_SUBMIT, .number = 2});
    CHECK(submit(f, &program));
    assert_int_equal(submit(f, &program), VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
    driver.plan_fault(&(struct null_driver_fault){.at = NULL_DRIVER_AT_WAIT, .number = 2});
    CHECK(f->vk.DeviceWaitIdle(f->device));
    assert_int_equal(f->vk.WaitForFences(f->device, 1, &program.fence, VK_TRUE, 1),
                     VK_ERROR_DEVICE_LOST);
    driver.set_device_lost(false);
}

static void test_planned_hang(void **state)
{
    struct fixture *f = *state;
    driver.plan_fault(
        &(struct null_driver_fault){.kind = NULL_DRIVER_HANG, .at = NULL_DRIVER_AT_BUILD});
    const struct fault_program program = make_fault_program(f);
    CHECK(submit(f, &program));
    expect_words(&program, (const uint32_t[]){1, 1, 0, 0, 0});
    assert_int_equal(f->vk.WaitForFences(f->device, 1, &program.fence, VK_TRUE, 1), VK_TIMEOUT);
    driver.end_hang();
    CHECK(f->vk.WaitForFences(f->device, 1, &program.fence, VK_TRUE, UINT64_MAX));
    CHECK(f->vk.DeviceWaitIdle(f->device));
    expect_words(&program, (const uint32_t[]){1, 1, 1, 1, 1});
}

static void test_planned_crash(void **state)
{
    struct fixture *f = *state;
    const struct {
        int signal, expected;
        bool in_thread;
    } rows[] = {{0, SIGSEGV, false}, {0, SIGSEGV, true}, {SIGABRT, SIGABRT, true}};
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        driver.plan_fault(&(struct null_driver_fault){.kind = NULL_DRIVER_CRASH,
                                                      .at = NULL_DRIVER_AT_BUILD,
                                                      .signal = rows[i].signal,
                                                      .in_thread = rows[i].in_thread});
        const struct fault_program program = make_fault_program(f);
        const pid_t child = fork();
        if (child == 0) {
            signal(SIGSEGV, SIG_DFL);
            signal(SIGABRT, SIG_DFL);
            setrlimit(RLIMIT_CORE, &(struct rlimit){0});
            submit(f, &program);
            _exit(0);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == rows[i].expected);
    }
    driver.plan_fault(NULL);
}

int run_command_tests(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_build_commands, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_failures, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_timeline, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_planned_loss, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_planned_hang, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_planned_crash, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_scopes, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_threads, set_up_device, tear_down),
    };
    return cmocka_run_group_tests_name("null_driver commands", tests, NULL, NULL);
}
