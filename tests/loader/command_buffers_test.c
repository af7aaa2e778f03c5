/* SPDX-License-Identifier: Apache-2.0 */
/* Handles that are no command buffers, given to each command that the layer intercepts: the layer
 * skips the command, and reports the handle if the command builds. */
#define _GNU_SOURCE /* MAP_ANONYMOUS, dladdr */
#include <dlfcn.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include <cmocka.h>

#include "layer/cpu/commands.h"
#include "layer/intercepts/intercepts.h"
#include "layer/snapshots/commands.h"
#include "tests/rules/fixture.h"

#define WARNING_ID "ASSAY-warning"

enum { EXTENSIONS_MAX = 512, PAGE = 4096, COMMANDS_AT_LEAST = 50 };

/* ---- the commands: the lists of the layer, so that a command that is added there is tested */

static const char *const intercepted[] = {
#define NAME(name) "vk" #name,
#define NAME_SUPPLIED(extension, name) "vk" #name,
    ASSAY_DEVICE_INTERCEPTS(NAME) SNAPSHOTS_COMMANDS(NAME) CPU_COMMANDS(NAME_SUPPLIED)
        CPU_REPLACED_COMMANDS(NAME)
#undef NAME
#undef NAME_SUPPLIED
};

static bool is_recorded(const char *name)
{
    return strncmp(name, "vkCmd", 5) == 0 || strcmp(name, "vkBeginCommandBuffer") == 0 ||
           strcmp(name, "vkEndCommandBuffer") == 0 || strcmp(name, "vkResetCommandBuffer") == 0;
}

/* The id that reports the handle, if the command builds. */
static const char *id_of(const char *name)
{
    static const char *const ids[][2] = {
        {"vkCmdBuildAccelerationStructuresKHR",
         "VUID-vkCmdBuildAccelerationStructuresKHR-commandBuffer-parameter"},
        {"vkCmdBuildAccelerationStructuresIndirectKHR",
         "VUID-vkCmdBuildAccelerationStructuresIndirectKHR-commandBuffer-parameter"},
        {"vkCmdBuildAccelerationStructureNV",
         "VUID-vkCmdBuildAccelerationStructureNV-commandBuffer-parameter"},
    };
    for (size_t i = 0; i < sizeof(ids) / sizeof(ids[0]); i++)
        if (strcmp(name, ids[i][0]) == 0)
            return ids[i][1];
    return NULL;
}

/* The handle comes first in each command, and all that follows is integers and pointers: with the
 * calling conventions of all platforms that Assay is built for, a command finds zeros there. A
 * command that reads through one of them before it has looked at its handle crashes. */
typedef VkResult(VKAPI_PTR *any_command)(const void *handle, uint64_t, uint64_t, uint64_t, uint64_t,
                                         uint64_t, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t,
                                         uint64_t, uint64_t, uint64_t, uint64_t);

/* ---- a device with all extensions that are offered, so that it has all commands */

struct command_fixture {
    struct fixture fixture;
    VkDevice device, destroyed;
    VkuDeviceDispatchTable vk;
    const char *level;
    const void *unreadable, *garbage, *zeros;
    uint32_t called; /* commands, by the last call_all() */
};

static VkDevice create_device(const struct fixture *fixture)
{
    static VkExtensionProperties offered[EXTENSIONS_MAX];
    static const char *names[EXTENSIONS_MAX];
    uint32_t count = EXTENSIONS_MAX;
    expect_success(fixture->vki.EnumerateDeviceExtensionProperties(fixture->physical_device, NULL,
                                                                   &count, offered),
                   "vkEnumerateDeviceExtensionProperties");
    for (uint32_t i = 0; i < count; i++)
        names[i] = offered[i].extensionName;
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueCount = 1,
        .pQueuePriorities = &priority,
    };
    const VkDeviceCreateInfo create_info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue,
        .enabledExtensionCount = count,
        .ppEnabledExtensionNames = names,
    };
    VkDevice device;
    expect_success(fixture->create_device(fixture->physical_device, &create_info, NULL, &device),
                   "vkCreateDevice");
    return device;
}

static VkCommandPool create_pool(VkDevice device, const VkuDeviceDispatchTable *vk)
{
    const VkCommandPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    VkCommandPool pool;
    expect_success(vk->CreateCommandPool(device, &info, NULL, &pool), "vkCreateCommandPool");
    return pool;
}

/* A command buffer that something has been recorded in, so that the layer knows it well. */
static VkCommandBuffer allocate(VkDevice device, const VkuDeviceDispatchTable *vk,
                                VkCommandPool pool)
{
    const VkCommandBufferAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = pool,
        .commandBufferCount = 1,
    };
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    VkCommandBuffer command_buffer;
    expect_success(vk->AllocateCommandBuffers(device, &info, &command_buffer),
                   "vkAllocateCommandBuffers");
    expect_success(vk->BeginCommandBuffer(command_buffer, &begin), "vkBeginCommandBuffer");
    return command_buffer;
}

static void *map_page(int protection, int byte)
{
    void *page = mmap(NULL, PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(page, MAP_FAILED);
    memset(page, byte, PAGE);
    assert_int_equal(mprotect(page, PAGE, protection), 0);
    return page;
}

/* ---- the tests */

/* Below that level the layer says nothing of an invalid handle, and passes down what it can. */
static bool knows_command_buffers(const struct command_fixture *command_fixture)
{
    return strcmp(command_fixture->level, "parameters") != 0;
}

static uint32_t findings(const struct messages *messages)
{
    return messages->count - messages_count(messages, WARNING_ID, NULL);
}

/* The layer's own: overlays cover some commands at some levels only, and the driver's may read
 * through any handle. */
static bool is_of_layer(any_command command)
{
    Dl_info info;
    return command != NULL && dladdr((void *)(uintptr_t)command, &info) &&
           strstr(info.dli_fname, "VkLayer_assay") != NULL;
}

static void call_all(struct command_fixture *command_fixture, const void *handle, const char *what)
{
    const struct messages *messages = &command_fixture->fixture.messages;
    command_fixture->called = 0;
    for (size_t i = 0; i < sizeof(intercepted) / sizeof(intercepted[0]); i++) {
        const char *name = intercepted[i], *id = id_of(name);
        const any_command command =
            is_recorded(name) ? (any_command)command_fixture->fixture.get_device_proc_addr(
                                    command_fixture->device, name)
                              : NULL;
        if (!is_of_layer(command))
            continue;
        command_fixture->called++;
        messages_clear(&command_fixture->fixture.messages);
        const VkResult result = command(handle, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
        if (strncmp(name, "vkCmd", 5) != 0)
            assert_int_equal(result, VK_ERROR_VALIDATION_FAILED_EXT);
        const bool is_reported = id && knows_command_buffers(command_fixture);
        if (findings(messages) != (is_reported ? 1 : 0) ||
            (is_reported && messages_count(messages, id, NULL) != 1))
            fail_msg("%s(%s) at level %s: %u messages, the first of %s", name, what,
                     command_fixture->level, messages->count, messages->items[0].id);
    }
}

static void test_null(void **state)
{
    const struct command_fixture *command_fixture = *state;
    call_all(*state, NULL, "NULL");
    assert_true(command_fixture->called >= COMMANDS_AT_LEAST);
    print_message("%u commands\n", command_fixture->called);
}

static void test_freed(void **state)
{
    struct command_fixture *command_fixture = *state;
    if (!knows_command_buffers(command_fixture))
        skip(); /* what was freed may still lead to the device */
    const VkCommandPool pool = create_pool(command_fixture->device, &command_fixture->vk);
    const VkCommandBuffer handle = allocate(command_fixture->device, &command_fixture->vk, pool);
    command_fixture->vk.FreeCommandBuffers(command_fixture->device, pool, 1, &handle);
    call_all(command_fixture, handle, "freed");
    command_fixture->vk.DestroyCommandPool(command_fixture->device, pool, NULL);
}

static void test_freed_with_its_pool(void **state)
{
    struct command_fixture *command_fixture = *state;
    if (!knows_command_buffers(command_fixture))
        skip();
    const VkCommandPool pool = create_pool(command_fixture->device, &command_fixture->vk);
    const VkCommandBuffer handle = allocate(command_fixture->device, &command_fixture->vk, pool);
    command_fixture->vk.DestroyCommandPool(command_fixture->device, pool, NULL);
    call_all(command_fixture, handle, "freed with its pool");
}

static void test_freed_with_its_device(void **state)
{
    struct command_fixture *command_fixture = *state;
    VkuDeviceDispatchTable vk;
    const VkDevice device = create_device(&command_fixture->fixture);
    vkuInitDeviceDispatchTable(device, &vk, command_fixture->fixture.get_device_proc_addr);
    const VkCommandPool pool = create_pool(device, &vk);
    const VkCommandBuffer handle = allocate(device, &vk, pool);
    vk.DestroyDevice(device, NULL);
    call_all(command_fixture, handle, "freed with its device");
}

static void test_unreadable(void **state)
{
    const struct command_fixture *command_fixture = *state;
    call_all(*state, command_fixture->unreadable, "unreadable");
    call_all(*state, (const void *)(uintptr_t)0x13, "near 0");
    call_all(*state, (const void *)(uintptr_t)0xdead00000000beef, "not canonical");
    call_all(*state, (const char *)command_fixture->unreadable - 4, "half readable");
}

static void test_readable_garbage(void **state)
{
    const struct command_fixture *command_fixture = *state;
    call_all(*state, command_fixture->garbage, "garbage");
    call_all(*state, command_fixture->zeros, "zeros");
    call_all(*state, (const char *)command_fixture->garbage + 3, "misaligned garbage");
}

/* Their first words lead to the device. */
static void test_other_objects(void **state)
{
    struct command_fixture *command_fixture = *state;
    if (!knows_command_buffers(command_fixture))
        skip();
    VkQueue queue;
    command_fixture->vk.GetDeviceQueue(command_fixture->device, 0, 0, &queue);
    call_all(command_fixture, queue, "a queue");
    call_all(command_fixture, command_fixture->device, "the device");
}

/* Beside a command buffer that lives, one byte on. */
static void test_misaligned(void **state)
{
    struct command_fixture *command_fixture = *state;
    const VkCommandPool pool = create_pool(command_fixture->device, &command_fixture->vk);
    const VkCommandBuffer handle = allocate(command_fixture->device, &command_fixture->vk, pool);
    for (int i = 1; i < 8; i++)
        call_all(command_fixture, (const char *)handle + i, "misaligned");
    assert_int_equal(command_fixture->vk.EndCommandBuffer(handle), VK_SUCCESS);
    command_fixture->vk.DestroyCommandPool(command_fixture->device, pool, NULL);
}

/* The handle that was freed is good again once it is allocated again. */
static void test_allocated_again(void **state)
{
    struct command_fixture *command_fixture = *state;
    if (!knows_command_buffers(command_fixture))
        skip();
    const VkCommandPool pool = create_pool(command_fixture->device, &command_fixture->vk);
    for (int i = 0; i < 100; i++) {
        const VkCommandBuffer handle =
            allocate(command_fixture->device, &command_fixture->vk, pool);
        assert_int_equal(command_fixture->vk.EndCommandBuffer(handle), VK_SUCCESS);
        command_fixture->vk.FreeCommandBuffers(command_fixture->device, pool, 1, &handle);
        assert_int_equal(command_fixture->vk.EndCommandBuffer(handle),
                         VK_ERROR_VALIDATION_FAILED_EXT);
    }
    command_fixture->vk.DestroyCommandPool(command_fixture->device, pool, NULL);
}

/* Commands that don't build are skipped with a warning, once a device. */
static void test_one_warning(void **state)
{
    struct command_fixture *command_fixture = *state;
    if (!knows_command_buffers(command_fixture))
        skip();
    struct messages *messages = &command_fixture->fixture.messages;
    VkuDeviceDispatchTable vk;
    VkQueue queue;
    const VkDevice device = create_device(&command_fixture->fixture);
    vkuInitDeviceDispatchTable(device, &vk, command_fixture->fixture.get_device_proc_addr);
    vk.GetDeviceQueue(device, 0, 0, &queue);
    messages_clear(messages);
    vk.EndCommandBuffer((VkCommandBuffer)queue);
    assert_int_equal(messages_count(messages, WARNING_ID, "is not a command buffer"), 1);
    vk.EndCommandBuffer((VkCommandBuffer)queue);
    vk.CmdEndRenderPass((VkCommandBuffer)queue);
    assert_int_equal(messages->count, 1);
    vk.DestroyDevice(device, NULL);
}

/* More devices than the layer finds without a lock; each finds its own command buffers. */
static void test_many_devices(void **state)
{
    enum { DEVICES = 12 };
    struct command_fixture *command_fixture = *state;
    VkDevice devices[DEVICES];
    VkCommandBuffer handles[DEVICES];
    VkuDeviceDispatchTable vk;
    for (int i = 0; i < DEVICES; i++) {
        devices[i] = create_device(&command_fixture->fixture);
        vkuInitDeviceDispatchTable(devices[i], &vk, command_fixture->fixture.get_device_proc_addr);
        handles[i] = allocate(devices[i], &vk, create_pool(devices[i], &vk));
    }
    for (int i = 0; i < DEVICES; i++)
        assert_int_equal(vk.EndCommandBuffer(handles[i]), VK_SUCCESS);
    for (int i = 0; i < DEVICES; i++) {
        vkuInitDeviceDispatchTable(devices[i], &vk, command_fixture->fixture.get_device_proc_addr);
        vk.DestroyDevice(devices[i], NULL);
        assert_int_equal(vk.EndCommandBuffer(handles[i]), VK_ERROR_VALIDATION_FAILED_EXT);
    }
}

int main(int argc, char **argv)
{
    static struct platform platform;
    static struct command_fixture command_fixture;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_null),
        cmocka_unit_test(test_freed),
        cmocka_unit_test(test_freed_with_its_pool),
        cmocka_unit_test(test_freed_with_its_device),
        cmocka_unit_test(test_unreadable),
        cmocka_unit_test(test_readable_garbage),
        cmocka_unit_test(test_other_objects),
        cmocka_unit_test(test_misaligned),
        cmocka_unit_test(test_allocated_again),
        cmocka_unit_test(test_one_warning),
        cmocka_unit_test(test_many_devices),
    };
    if (argc != 3) {
        fprintf(stderr, "usage: %s " PLATFORM_NAMES " LEVEL\n", argv[0]);
        return 2;
    }
    const char *missing = platform_open(&platform, argv[1]);
    struct setup setup = {.level = argv[2]};
    if (missing == NULL)
        missing = fixture_open(&command_fixture.fixture, &platform, &setup);
    if (missing != NULL) {
        fprintf(stderr, "%s\n", missing);
        return 77;
    }
    struct CMUnitTest with_fixture[sizeof(tests) / sizeof(tests[0])];
    memcpy(with_fixture, tests, sizeof(tests));
    for (size_t i = 0; i < sizeof(tests) / sizeof(tests[0]); i++)
        with_fixture[i].initial_state = &command_fixture;
    command_fixture.level = argv[2];
    command_fixture.device = create_device(&command_fixture.fixture);
    vkuInitDeviceDispatchTable(command_fixture.device, &command_fixture.vk,
                               command_fixture.fixture.get_device_proc_addr);
    command_fixture.unreadable = map_page(PROT_NONE, 0);
    command_fixture.garbage = map_page(PROT_READ, 0xab);
    command_fixture.zeros = map_page(PROT_READ, 0);
    const int result = cmocka_run_group_tests(with_fixture, NULL, NULL);
    command_fixture.vk.DestroyDevice(command_fixture.device, NULL);
    fixture_close(&command_fixture.fixture);
    return result;
}
