/* SPDX-License-Identifier: Apache-2.0 */
/* What submitted commands do to the bytes of the null driver's buffers. */
#include "smoke.h"

enum { SIZE = 256 };

/* A buffer of host-visible memory (type 1), its bytes, and one of device-local memory (type 0). */
struct bytes {
    struct fixture *f;
    VkBuffer seen, hidden;
    unsigned char *at;
    VkCommandPool pool;
    VkCommandBuffer commands;
};

static VkBuffer make_bound(struct fixture *f, uint32_t type, void **mapped)
{
    const VkBuffer buffer = make_buffer(f, 0, SIZE);
    const VkDeviceMemory memory = make_memory(f, type, SIZE);
    CHECK(f->vk.BindBufferMemory(f->device, buffer, memory, 0));
    if (mapped != NULL)
        CHECK(f->vk.MapMemory(f->device, memory, 0, VK_WHOLE_SIZE, 0, mapped));
    return buffer;
}

static void begin(struct fixture *f, VkCommandBuffer commands)
{
    CHECK(f->vk.BeginCommandBuffer(commands, &MAKE(VkCommandBufferBeginInfo)));
}

static struct bytes open_bytes(struct fixture *f)
{
    struct bytes bytes = {.f = f};
    bytes.seen = make_bound(f, 1, (void **)&bytes.at);
    bytes.hidden = make_bound(f, 0, NULL);
    bytes.pool = make_pool(f);
    bytes.commands = make_command_buffer(f, bytes.pool);
    begin(f, bytes.commands);
    return bytes;
}

static void submit(const struct bytes *bytes)
{
    const VkSubmitInfo info =
        MAKE(VkSubmitInfo, .commandBufferCount = 1, .pCommandBuffers = &bytes->commands);
    CHECK(bytes->f->vk.QueueSubmit(bytes->f->queue, 1, &info, VK_NULL_HANDLE));
}

/* Nothing happens before the submission, and everything again at the next one. */
static void test_through_hidden_memory(void **state)
{
    struct bytes bytes = open_bytes(*state);
    const VkuDeviceDispatchTable *t = &bytes.f->vk;
    t->CmdCopyBuffer(bytes.commands, bytes.seen, bytes.hidden, 1, &(VkBufferCopy){0, 16, 8});
    const VkCopyBufferInfo2 info = MAKE(
        VkCopyBufferInfo2, .srcBuffer = bytes.hidden, .dstBuffer = bytes.seen, .regionCount = 1,
        .pRegions = &MAKE(VkBufferCopy2, .srcOffset = 16, .dstOffset = 32, .size = 8));
    t->CmdCopyBuffer2(bytes.commands, &info);
    CHECK(t->EndCommandBuffer(bytes.commands));
    memcpy(bytes.at, "abcdefgh", 8);
    assert_int_equal(bytes.at[32], 0);
    submit(&bytes);
    assert_memory_equal(bytes.at + 32, "abcdefgh", 8);
    memcpy(bytes.at, "ABCDEFGH", 8);
    submit(&bytes);
    assert_memory_equal(bytes.at + 32, "ABCDEFGH", 8);
}

static void test_updates_and_fills(void **state)
{
    struct bytes bytes = open_bytes(*state);
    const VkuDeviceDispatchTable *t = &bytes.f->vk;
    char data[4] = {'d', 'a', 't', 'a'};
    t->CmdFillBuffer(bytes.commands, bytes.seen, 4, VK_WHOLE_SIZE, 0x01020304);
    t->CmdUpdateBuffer(bytes.commands, bytes.seen, 8, sizeof(data), data);
    memset(data, 0, sizeof(data)); /* it was copied when it was recorded */
    submit(&bytes);
    assert_memory_equal(bytes.at, "\0\0\0\0\4\3\2\1data\4\3\2\1", 16);
    assert_memory_equal(bytes.at + SIZE - 4, "\4\3\2\1", 4);
    begin(bytes.f, bytes.commands);
    memset(bytes.at, 0, 16);
    submit(&bytes);
    assert_int_equal(bytes.at[4], 0);
}

static void test_secondaries(void **state)
{
    struct bytes bytes = open_bytes(*state);
    const VkuDeviceDispatchTable *t = &bytes.f->vk;
    const VkCommandBuffer secondary = make_command_buffer(bytes.f, bytes.pool);
    begin(bytes.f, secondary);
    t->CmdCopyBuffer(secondary, bytes.seen, bytes.seen, 1, &(VkBufferCopy){0, 4, 4});
    t->CmdFillBuffer(bytes.commands, bytes.seen, 0, 4, 1);
    t->CmdExecuteCommands(bytes.commands, 1, &secondary);
    t->CmdFillBuffer(bytes.commands, bytes.seen, 0, 4, 2);
    submit(&bytes);
    assert_memory_equal(bytes.at, "\2\0\0\0\1\0\0\0", 8);
    CHECK(t->ResetCommandPool(bytes.f->device, bytes.pool, 0));
    memset(bytes.at, 0, 8);
    submit(&bytes);
    assert_int_equal(bytes.at[4], 0);
}

/* Of two bindings the later one counts, where it is; bytes without memory stay what they are. */
static void test_sparse(void **state)
{
    struct bytes bytes = open_bytes(*state);
    const VkuDeviceDispatchTable *t = &bytes.f->vk;
    const VkBuffer sparse = make_buffer(bytes.f, VK_BUFFER_CREATE_SPARSE_BINDING_BIT, SIZE);
    const VkDeviceMemory memory = make_memory(bytes.f, 1, SIZE);
    const VkSparseMemoryBind binds[] = {{0, 128, memory, 0, 0}, {16, 16, memory, 128, 0}};
    const VkSparseBufferMemoryBindInfo buffer_binds = {sparse, COUNT_OF(binds), binds};
    const VkBindSparseInfo info =
        MAKE(VkBindSparseInfo, .bufferBindCount = 1, .pBufferBinds = &buffer_binds);
    CHECK(t->QueueBindSparse(bytes.f->queue, 1, &info, VK_NULL_HANDLE));
    unsigned char *at;
    CHECK(t->MapMemory(bytes.f->device, memory, 0, VK_WHOLE_SIZE, 0, (void **)&at));
    for (int i = 0; i < SIZE; i++)
        at[i] = (unsigned char)i;
    memset(bytes.at, 0xff, SIZE);
    t->CmdCopyBuffer(bytes.commands, sparse, bytes.seen, 1, &(VkBufferCopy){0, 0, SIZE});
    submit(&bytes);
    assert_int_equal(bytes.at[15], 15);
    assert_int_equal(bytes.at[16], 128);
    assert_int_equal(bytes.at[31], 143);
    assert_int_equal(bytes.at[32], 32);
    assert_int_equal(bytes.at[127], 127);
    assert_int_equal(bytes.at[128], 0xff);
}

int run_transfer_tests(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_through_hidden_memory, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_updates_and_fills, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_secondaries, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_sparse, set_up_device, tear_down),
    };
    return cmocka_run_group_tests_name("null_driver transfers", tests, NULL, NULL);
}
