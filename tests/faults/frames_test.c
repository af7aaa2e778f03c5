/* SPDX-License-Identifier: Apache-2.0 */
/* The memory that the layer takes for an application's frames, without a loader and below settings
 * of the environment. */
#include <stdlib.h>

#include "tests/fixture/objects.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/fuzz/calls/calls.h"
#include "tests/state/unit_test.h"

/* The first byte of calls_open(). */
enum {
    AT_EXECUTION = 1,
    AT_CONTENT = 2,
    ON_CPU = 4,
    RECYCLES_HANDLES = 8,
    RECYCLES_ADDRESSES = 16
};

static struct calls calls;

static void open_calls(uint8_t options)
{
    static uint8_t first;
    first = options;
    calls = (struct calls){.at = &first, .end = &first + 1};
    assert_true(calls_open(&calls));
}

/* ---- bindings and push constants without builds */

static void record_bindings(VkCommandBuffer commands)
{
    static const uint32_t constants[4] = {1, 2, 3, 4};
    const STRUCT(VkCommandBufferBeginInfo, begin);
    GET(calls.vk.BeginCommandBuffer(commands, &begin));
    calls.vk.CmdPushConstants(commands, (VkPipelineLayout)(uintptr_t)1, VK_SHADER_STAGE_COMPUTE_BIT,
                              0, sizeof(constants), constants);
    calls.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, (VkPipeline)(uintptr_t)1);
    GET(calls.vk.EndCommandBuffer(commands));
}

TEST(bindings_without_builds_allocate_nothing)
{
    open_calls(AT_CONTENT);
    VkCommandPool pool = command_pool_create(&calls.vk, calls.device);
    VkCommandBuffer commands =
        commands_begin(&calls.vk, calls.device, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    record_bindings(commands);
    ALLOCATES_NOTHING(record_bindings(commands));
    GET(calls.vk.ResetCommandBuffer(commands, VK_COMMAND_BUFFER_RESET_RELEASE_RESOURCES_BIT));
    WITHOUT_MEMORY(record_bindings(commands));
    calls.vk.DestroyCommandPool(calls.device, pool, NULL);
    calls_close(&calls);
}
