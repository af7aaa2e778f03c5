/* SPDX-License-Identifier: Apache-2.0 */
/* Making them, and asking. */
#include "tests/state/command_fixture.h"
#include "tests/fixture/make.h"

struct command_buffers *some_command_buffers(void)
{
    const VkCommandBuffer primaries[] = {handle(1), handle(2)}, secondary = handle(3);
    struct command_buffers *all = NULL;
    assert_int_equal(command_buffers_create(&all), VK_SUCCESS);
    command_buffers_add_pool(all, pool(1), 0, VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT, false);
    command_buffers_add(all, pool(1), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 2, primaries);
    command_buffers_add(all, pool(1), VK_COMMAND_BUFFER_LEVEL_SECONDARY, 1, &secondary);
    return all;
}

void add(struct command_buffers *all, unsigned pool_n, unsigned n)
{
    const VkCommandBuffer added = handle(n);
    command_buffers_add(all, pool(pool_n), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1, &added);
}

void take_away(struct command_buffers *all, unsigned n)
{
    const VkCommandBuffer removed = handle(n);
    command_buffers_remove(all, 1, &removed);
}

struct command_buffer_facts facts_of(struct command_buffers *all, unsigned n)
{
    struct command_buffer_facts facts;
    command_buffers_facts(all, command_buffers_find(all, handle(n)), handle(n), &facts);
    return facts;
}

void begin_with(struct command_buffers *all, unsigned n, VkCommandBufferUsageFlags flags,
                VkResult result)
{
    command_buffer_begin(command_buffers_find(all, handle(n)),
                         &MAKE(VkCommandBufferBeginInfo, .flags = flags), 0, result);
}

struct command_buffer *begin(struct command_buffers *all, unsigned n)
{
    begin_with(all, n, 0, VK_SUCCESS);
    return command_buffers_find(all, handle(n));
}
