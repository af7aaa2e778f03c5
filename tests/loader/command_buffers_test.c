/* SPDX-License-Identifier: Apache-2.0 */
/* Handles that are no command buffers, given to each command that the layer intercepts: the layer
 * skips the command, and reports the handle if it validates the command. */
#define _GNU_SOURCE /* MAP_ANONYMOUS, dladdr */
#include <dlfcn.h>
#include <sys/mman.h>

#include "intercepted.h"
#include "loader_test.h"
#include "vuid-tables/rules.h"

#define WARNING_ID "ASSAY-warning"

enum { EXTENSIONS_MAX = 512, PAGE = 4096, COMMANDS_AT_LEAST = 35 };

/* ---- the commands: the rows of the layer, so that a command that is added there is tested */

static const char *const intercepted[] = {
#define NAME(name) "vk" #name,
    INTERCEPTED_COMMANDS(NAME)
#undef NAME
};

static bool is_recorded(const char *name)
{
    return strncmp(name, "vkCmd", 5) == 0 || strcmp(name, "vkBeginCommandBuffer") == 0 ||
           strcmp(name, "vkEndCommandBuffer") == 0 || strcmp(name, "vkResetCommandBuffer") == 0;
}

/* The id that reports the handle, if the layer validates the command. */
static const char *id_of(const char *name)
{
    const struct rule_info *rule = &rule_infos[RULE_command_buffer_is_valid];
    for (enum build_command command = COMMAND_DEVICE; command < COMMAND_COUNT; command++)
        if (strcmp(name, build_command_name(command)) == 0 && rule->vuid[command] != VUID_NONE)
            return vuid_texts[rule->vuid[command]].id;
    return NULL;
}

/* The handle comes first in each command, and all that follows is integers and pointers: with the
 * calling conventions of all platforms that Assay is built for, a command finds zeros there. A
 * command that reads through one of them before it has looked at its handle crashes. */
typedef VkResult(VKAPI_PTR *any_command)(const void *handle, uint64_t, uint64_t, uint64_t, uint64_t,
                                         uint64_t, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t,
                                         uint64_t, uint64_t, uint64_t, uint64_t);

/* ---- a device with all extensions that are offered, so that it has all commands */

static struct fixture fixture;
static VkDevice device;
static VkuDeviceDispatchTable vk;
static const char *level;
static const void *unreadable, *garbage, *zeros;
static uint32_t called; /* commands, by the last call_all() */

static VkDevice create_device(void)
{
    static VkExtensionProperties offered[EXTENSIONS_MAX];
    static const char *names[EXTENSIONS_MAX];
    uint32_t count = EXTENSIONS_MAX;
    GET(fixture.instance.vk.EnumerateDeviceExtensionProperties(fixture.instance.physical, NULL,
                                                               &count, offered));
    for (uint32_t i = 0; i < count; i++)
        names[i] = offered[i].extensionName;
    const float priority = 1.0f;
    const STRUCT(VkDeviceQueueCreateInfo, queue, .queueCount = 1, .pQueuePriorities = &priority);
    const STRUCT(VkDeviceCreateInfo, create_info, .queueCreateInfoCount = 1,
                 .pQueueCreateInfos = &queue, .enabledExtensionCount = count,
                 .ppEnabledExtensionNames = names);
    VkDevice created;
    GET(fixture.instance.vk.CreateDevice(fixture.instance.physical, &create_info, NULL, &created));
    return created;
}

/* A command buffer that something has been recorded in, so that the layer knows it well. */
static VkCommandBuffer allocate(VkDevice owner, VkCommandPool pool)
{
    return commands_begin(&vk, owner, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
}

static void *map_page(int protection, int byte)
{
    void *page = mmap(NULL, PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(page, MAP_FAILED);
    memset(page, byte, PAGE);
    assert_int_equal(mprotect(page, PAGE, protection), 0);
    return page;
}

const char *loader_test_open(void)
{
    level = unit_test_arguments[1];
    const struct setup setup = {.level = level};
    const char *missing = fixture_open(&fixture, &platform, &setup);
    if (missing)
        return missing;
    device = create_device();
    vkuInitDeviceDispatchTable(device, &vk, fixture.instance.get_device_proc_addr);
    unreadable = map_page(PROT_NONE, 0);
    garbage = map_page(PROT_READ, 0xab);
    zeros = map_page(PROT_READ, 0);
    return NULL;
}

void unit_test_close(void)
{
    vk.DestroyDevice(device, NULL);
    fixture_close(&fixture);
}

/* ---- the tests */

/* Below that level the layer says nothing of an invalid handle, and passes down what it can. */
static bool knows_command_buffers(void)
{
    return strcmp(level, "parameters") != 0;
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

static void call_all(const void *handle, const char *what)
{
    const struct messages *messages = &fixture.instance.messages;
    called = 0;
    for (size_t i = 0; i < LENGTH(intercepted); i++) {
        const char *name = intercepted[i], *id = id_of(name);
        const any_command command =
            is_recorded(name) ? (any_command)fixture.instance.get_device_proc_addr(device, name)
                              : NULL;
        if (!is_of_layer(command))
            continue;
        called++;
        messages_clear(&fixture.instance.messages);
        const VkResult result = command(handle, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
        if (strncmp(name, "vkCmd", 5) != 0)
            assert_int_equal(result, VK_ERROR_VALIDATION_FAILED_EXT);
        const bool is_reported = id && knows_command_buffers();
        if (findings(messages) != (is_reported ? 1 : 0) ||
            (is_reported && messages_count(messages, id, NULL) != 1))
            fail_msg("%s(%s) at level %s: %u messages, the first of %s", name, what, level,
                     messages->count, messages->items[0].id);
    }
}

TEST(test_null)
{
    call_all(NULL, "NULL");
    assert_true(called >= COMMANDS_AT_LEAST);
    print_message("%u commands\n", called);
}

/* What was freed may still lead to the device: below level state, the layer may pass it down. */
TEST_IF(test_freed, knows_command_buffers())
{
    const VkCommandPool pool = command_pool_create(&vk, device);
    const VkCommandBuffer first = allocate(device, pool), second = allocate(device, pool);
    vk.FreeCommandBuffers(device, pool, 1, &first);
    call_all(first, "freed");
    vk.DestroyCommandPool(device, pool, NULL);
    call_all(second, "freed with its pool");
}

TEST(test_freed_with_its_device)
{
    VkuDeviceDispatchTable table;
    const VkDevice other = create_device();
    vkuInitDeviceDispatchTable(other, &table, fixture.instance.get_device_proc_addr);
    const VkCommandPool pool = command_pool_create(&vk, other);
    const VkCommandBuffer handle = allocate(other, pool);
    table.DestroyDevice(other, NULL);
    call_all(handle, "freed with its device");
}

TEST(test_no_objects)
{
    call_all(unreadable, "unreadable");
    call_all((const void *)(uintptr_t)0x13, "near 0");
    call_all((const void *)(uintptr_t)0xdead00000000beef, "not canonical");
    call_all((const char *)unreadable - 4, "half readable");
    call_all(garbage, "garbage");
    call_all(zeros, "zeros");
    call_all((const char *)garbage + 3, "misaligned garbage");
}

/* Their first words lead to the device. */
TEST_IF(test_other_objects, knows_command_buffers())
{
    VkQueue queue;
    vk.GetDeviceQueue(device, 0, 0, &queue);
    call_all(queue, "a queue");
    call_all(device, "the device");
}

/* Beside a command buffer that lives, one byte on. */
TEST(test_misaligned)
{
    const VkCommandPool pool = command_pool_create(&vk, device);
    const VkCommandBuffer handle = allocate(device, pool);
    for (int i = 1; i < 8; i++)
        call_all((const char *)handle + i, "misaligned");
    assert_int_equal(vk.EndCommandBuffer(handle), VK_SUCCESS);
    vk.DestroyCommandPool(device, pool, NULL);
}

/* The handle that was freed is good again once it is allocated again. */
TEST_IF(test_allocated_again, knows_command_buffers())
{
    const VkCommandPool pool = command_pool_create(&vk, device);
    for (int i = 0; i < 100; i++) {
        const VkCommandBuffer handle = allocate(device, pool);
        assert_int_equal(vk.EndCommandBuffer(handle), VK_SUCCESS);
        vk.FreeCommandBuffers(device, pool, 1, &handle);
        assert_int_equal(vk.EndCommandBuffer(handle), VK_ERROR_VALIDATION_FAILED_EXT);
    }
    vk.DestroyCommandPool(device, pool, NULL);
}

/* Commands that don't build are skipped with a warning, once a device. */
TEST_IF(test_one_warning, knows_command_buffers())
{
    struct messages *messages = &fixture.instance.messages;
    VkuDeviceDispatchTable table;
    VkQueue queue;
    const VkDevice other = create_device();
    vkuInitDeviceDispatchTable(other, &table, fixture.instance.get_device_proc_addr);
    table.GetDeviceQueue(other, 0, 0, &queue);
    messages_clear(messages);
    table.EndCommandBuffer((VkCommandBuffer)queue);
    assert_int_equal(messages_count(messages, WARNING_ID, "is not a command buffer"), 1);
    table.EndCommandBuffer((VkCommandBuffer)queue);
    table.CmdEndRenderPass((VkCommandBuffer)queue);
    assert_int_equal(messages->count, 1);
    table.DestroyDevice(other, NULL);
}

/* More devices than the layer finds without a lock; each finds its own command buffers. */
TEST(test_many_devices)
{
    enum { DEVICES = 12 };
    VkDevice devices[DEVICES];
    VkCommandBuffer handles[DEVICES];
    VkuDeviceDispatchTable table;
    for (int i = 0; i < DEVICES; i++) {
        devices[i] = create_device();
        vkuInitDeviceDispatchTable(devices[i], &table, fixture.instance.get_device_proc_addr);
        handles[i] = allocate(devices[i], command_pool_create(&vk, devices[i]));
    }
    for (int i = 0; i < DEVICES; i++)
        assert_int_equal(table.EndCommandBuffer(handles[i]), VK_SUCCESS);
    for (int i = 0; i < DEVICES; i++) {
        vkuInitDeviceDispatchTable(devices[i], &table, fixture.instance.get_device_proc_addr);
        table.DestroyDevice(devices[i], NULL);
        assert_int_equal(table.EndCommandBuffer(handles[i]), VK_ERROR_VALIDATION_FAILED_EXT);
    }
}
