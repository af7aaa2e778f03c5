/* SPDX-License-Identifier: Apache-2.0 */
/* What submitted commands do to the bytes of the null driver's buffers. */
#include "smoke.h"

enum { SIZE = 256 };

/* A buffer of host-visible memory (type 1), its bytes, and one of device-local memory (type 0). */
static VkBuffer seen, hidden;
static unsigned char *bytes;
static VkCommandPool pool;
static VkCommandBuffer commands; /* in the recording state */

static void open_bytes(void)
{
    set_up_device();
    seen = make_bound_buffer(SIZE, 1, (void **)&bytes);
    hidden = make_bound_buffer(SIZE, 0, NULL);
    pool = command_pool_create(&vk, device);
    commands = make_command_buffer(pool);
}

#define TRANSFER_TEST(name) TEST_BETWEEN(name, open_bytes, tear_down)

static void submit(void)
{
    GET(commands_submit(&vk, queue, commands, VK_NULL_HANDLE));
}

/* Nothing happens before the submission, and everything again at the next one. */
TRANSFER_TEST(test_through_hidden_memory)
{
    vk.CmdCopyBuffer(commands, seen, hidden, 1, &(VkBufferCopy){0, 16, 8});
    const STRUCT(VkCopyBufferInfo2, info, .srcBuffer = hidden, .dstBuffer = seen, .regionCount = 1,
                 .pRegions = &MAKE(VkBufferCopy2, .srcOffset = 16, .dstOffset = 32, .size = 8));
    vk.CmdCopyBuffer2(commands, &info);
    GET(vk.EndCommandBuffer(commands));
    memcpy(bytes, "abcdefgh", 8);
    assert_int_equal(bytes[32], 0);
    submit();
    assert_memory_equal(bytes + 32, "abcdefgh", 8);
    memcpy(bytes, "ABCDEFGH", 8);
    submit();
    assert_memory_equal(bytes + 32, "ABCDEFGH", 8);
}

TRANSFER_TEST(test_updates_and_fills)
{
    char data[4] = {'d', 'a', 't', 'a'};
    vk.CmdFillBuffer(commands, seen, 4, VK_WHOLE_SIZE, 0x01020304);
    vk.CmdUpdateBuffer(commands, seen, 8, sizeof(data), data);
    memset(data, 0, sizeof(data)); /* it was copied when it was recorded */
    submit();
    assert_memory_equal(bytes, "\0\0\0\0\4\3\2\1data\4\3\2\1", 16);
    assert_memory_equal(bytes + SIZE - 4, "\4\3\2\1", 4);
    GET(vk.BeginCommandBuffer(commands, &MAKE(VkCommandBufferBeginInfo)));
    memset(bytes, 0, 16);
    submit();
    assert_int_equal(bytes[4], 0);
}

TRANSFER_TEST(test_secondaries)
{
    const VkCommandBuffer secondary = make_command_buffer(pool);
    vk.CmdCopyBuffer(secondary, seen, seen, 1, &(VkBufferCopy){0, 4, 4});
    vk.CmdFillBuffer(commands, seen, 0, 4, 1);
    vk.CmdExecuteCommands(commands, 1, &secondary);
    vk.CmdFillBuffer(commands, seen, 0, 4, 2);
    submit();
    assert_memory_equal(bytes, "\2\0\0\0\1\0\0\0", 8);
    GET(vk.ResetCommandPool(device, pool, 0));
    memset(bytes, 0, 8);
    submit();
    assert_int_equal(bytes[4], 0);
}

/* Of two bindings the later one counts, where it is; bytes without memory stay what they are. */
TRANSFER_TEST(test_sparse)
{
    const VkBuffer sparse = make_buffer(VK_BUFFER_CREATE_SPARSE_BINDING_BIT, SIZE);
    const VkDeviceMemory memory = make_memory(1, SIZE);
    const VkSparseMemoryBind binds[] = {{0, 128, memory, 0, 0}, {16, 16, memory, 128, 0}};
    const VkSparseBufferMemoryBindInfo buffer_binds = {sparse, ARRAY_COUNT(binds), binds};
    const STRUCT(VkBindSparseInfo, info, .bufferBindCount = 1, .pBufferBinds = &buffer_binds);
    GET(vk.QueueBindSparse(queue, 1, &info, VK_NULL_HANDLE));
    unsigned char *at;
    GET(vk.MapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, (void **)&at));
    for (int i = 0; i < SIZE; i++)
        at[i] = (unsigned char)i;
    memset(bytes, 0xff, SIZE);
    vk.CmdCopyBuffer(commands, sparse, seen, 1, &(VkBufferCopy){0, 0, SIZE});
    submit();
    assert_int_equal(bytes[15], 15);
    assert_int_equal(bytes[16], 128);
    assert_int_equal(bytes[31], 143);
    assert_int_equal(bytes[32], 32);
    assert_int_equal(bytes[127], 127);
    assert_int_equal(bytes[128], 0xff);
}
