/* SPDX-License-Identifier: Apache-2.0 */
/* Command pools and command buffers with handles made of numbers. */
#ifndef ASSAY_TESTS_STATE_COMMAND_FIXTURE_H
#define ASSAY_TESTS_STATE_COMMAND_FIXTURE_H

#include "src/state/commands/command_buffers.h"
#include "tests/unit/unit_test.h"

/* The n-th handle; 0 is none. */
static inline VkCommandPool pool(unsigned n)
{
    return (VkCommandPool)(uintptr_t)(n ? 0x1000 + n : 0);
}

static inline VkCommandBuffer handle(unsigned n)
{
    return (VkCommandBuffer)(uintptr_t)(n ? 0x2000 + n : 0);
}

/* Pool 1 of a graphics and compute family, with primary 1 and 2 and secondary 3. */
struct command_buffers *some_command_buffers(void);

/* A test of `all` those command buffers. */
#define COMMAND_BUFFERS_TEST(name)                                                                 \
    TEST_WITH(name, struct command_buffers *all, some_command_buffers, command_buffers_destroy)

/* A primary command buffer more, and one less. */
void add(struct command_buffers *all, unsigned pool_n, unsigned n);
void take_away(struct command_buffers *all, unsigned n);

struct command_buffer_facts facts_of(struct command_buffers *all, unsigned n);

void begin_with(struct command_buffers *all, unsigned n, VkCommandBufferUsageFlags flags,
                VkResult result);
struct command_buffer *begin(struct command_buffers *all, unsigned n);

#endif
