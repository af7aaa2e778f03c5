/* SPDX-License-Identifier: Apache-2.0 */
/* The hazard check keeps nothing of objects that are destroyed. */
#include "tests/fixture/batches.h"
#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"

#include <malloc.h>

static struct platform platform;
static struct instance_fixture instance;
static VkDevice device;
static VkuDeviceDispatchTable vk;
static VkQueue queue;
static VkCommandPool pool;

const char *unit_test_open(const char *argument)
{
    return platform_open(&platform, argument ? argument : "null");
}

static void open_device(void)
{
    instance_fixture_create(&instance, &platform,
                            &(struct instance_settings){.level = "execution", .hazards = "true"});
    GET(instance_fixture_create_device(&instance, NULL, NULL, 0, &device, &vk));
    vk.GetDeviceQueue(device, 0, 0, &queue);
    pool = command_pool_create(&vk, device);
}

static void close_device(void)
{
    messages_expect_none(&instance.messages);
    vk.DestroyCommandPool(device, pool, NULL);
    vk.DestroyDevice(device, NULL);
    instance_fixture_close(&instance);
}

/* One batch writes memory, sets an event and signals a semaphore, all of which end with it. */
static void use_objects(void)
{
    const struct device_buffer buffer =
        buffer_create(&vk, device, instance_fixture_memory_type(&instance),
                      &MAKE(VkBufferCreateInfo, .size = 256,
                            .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT));
    VkSemaphore semaphore = timeline_create(&vk, device);
    VkEvent event;
    GET(vk.CreateEvent(device, &MAKE(VkEventCreateInfo), NULL, &event));
    VkCommandBuffer commands =
        commands_begin(&vk, device, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    vk.CmdFillBuffer(commands, buffer.handle, 0, 256, 1);
    vk.CmdSetEvent(commands, event, VK_PIPELINE_STAGE_TRANSFER_BIT);
    GET(vk.EndCommandBuffer(commands));
    struct batch batch = {
        .signals = {MAKE(VkSemaphoreSubmitInfo, .semaphore = semaphore, .value = 1)},
        .signal_count = 1};
    batch_add_commands(&batch, commands);
    GET(batches_submit(&vk, queue, 1, &batch, VK_NULL_HANDLE));
    GET(vk.QueueWaitIdle(queue));
    vk.FreeCommandBuffers(device, pool, 1, &commands);
    vk.DestroyEvent(device, event, NULL);
    vk.DestroySemaphore(device, semaphore, NULL);
    buffer_destroy(&vk, device, &buffer);
}

static size_t used_after(unsigned times)
{
    for (unsigned i = 0; i < times; i++)
        use_objects();
    return mallinfo2().uordblks;
}

/* A record of each of the three takes at least 100 bytes. */
TEST_BETWEEN(destroyed_objects_take_no_memory, open_device, close_device)
{
    const size_t before = used_after(1000);
    assert_in_range(used_after(1000), 0, before + 32 * 1024);
}
