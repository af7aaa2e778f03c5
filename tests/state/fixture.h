/* SPDX-License-Identifier: Apache-2.0 */
/* Handles made of numbers; resources, filled and asked in one line each; and command buffers. */
#ifndef ASSAY_TESTS_STATE_FIXTURE_H
#define ASSAY_TESTS_STATE_FIXTURE_H

#include "src/state/commands/command_buffers.h"
#include "src/state/resources/resources.h"
#include "tests/unit/unit_test.h"

/* The n-th handle of a type; 0 is none. */
static inline VkDeviceMemory memory(unsigned n)
{
    return (VkDeviceMemory)(uintptr_t)(n ? 0x100 + n : 0);
}

static inline VkBuffer buffer(unsigned n)
{
    return (VkBuffer)(uintptr_t)(n ? 0x200 + n : 0);
}

static inline VkAccelerationStructureKHR accel(unsigned n)
{
    return (VkAccelerationStructureKHR)(uintptr_t)(n ? 0x300 + n : 0);
}

/* Resources without anything in them; fails the test if there are none. */
struct resources *no_resources(void);

/* A test of `resources` without anything in them. */
#define RESOURCES_TEST(name)                                                                       \
    TEST_WITH(name, struct resources *resources, no_resources, resources_destroy)

/* The others take numbers of handles. A buffer of `usage` 0 has VK_BUFFER_USAGE_STORAGE_BUFFER_BIT.
 */
void have_memory(struct resources *resources, unsigned n);
void have_buffer(struct resources *resources, unsigned n, VkDeviceSize size,
                 VkBufferUsageFlags usage);
void have_bound_buffer(struct resources *resources, unsigned n, VkDeviceSize size,
                       VkBufferUsageFlags usage, unsigned memory_n, VkDeviceSize offset);
void have_sparse_buffer(struct resources *resources, unsigned n, VkDeviceSize size);
void bind_at(struct resources *resources, unsigned n, unsigned memory_n, VkDeviceSize offset);
/* Executed on queue 1. */
extern const struct execution_clock all_of_queue_1;
void bind_sparse(struct resources *resources, unsigned n, VkDeviceSize begin, VkDeviceSize size,
                 unsigned memory_n, VkDeviceSize offset);
/* More values than are remembered when their structures are destroyed. */
enum { MANY_REFERENCES = 1100 };
void have_accel(struct resources *resources, unsigned n, unsigned buffer_n, VkDeviceSize offset,
                VkDeviceSize size);
void have_accel_at(struct resources *resources, unsigned n, VkDeviceAddress address,
                   VkDeviceSize size);

struct accel_facts accel_facts(struct resources *resources, unsigned n);
/* Found in every way there is, with and without a guess to begin with. */
struct address_facts address_facts(struct resources *resources, VkDeviceAddress address);

/* Where they lie. */
struct memory_span accel_span(const struct accel_facts *facts);
struct memory_span address_span(const struct address_facts *facts);
void assert_span(struct memory_span span, unsigned memory_n, VkDeviceSize begin, VkDeviceSize end);

/* ---- sparse buffers */

enum { PAGE = 0x100, PAGES = 48, MEMORIES = 4 };

/* Pieces as they are visited. */
struct pieces {
    struct memory_span spans[64];
    unsigned count;
};

/* Adds one; `user` is struct pieces. */
void note_piece(void *user, const struct memory_span *piece);

/* The pieces of memory that bytes of buffer n lie in. */
struct pieces pieces_of(struct resources *resources, unsigned n, VkDeviceSize begin,
                        VkDeviceSize end);

/* Expects pieces, each a memory and a range of it: EXPECT_PIECES(pieces, {memory(1), 0, 16}). */
void expect_pieces(struct pieces pieces, const struct memory_span *spans, unsigned count);
#define EXPECT_PIECES(pieces, ...)                                                                 \
    expect_pieces(pieces, (const struct memory_span[]){__VA_ARGS__},                               \
                  sizeof((const struct memory_span[]){__VA_ARGS__}) / sizeof(struct memory_span))

/* A sparse buffer 1 with structure 1 over its pages 1 to 6, and memories. */
struct resources *a_structure_in_pages(void);

/* A test of those `resources`. */
#define PAGES_TEST(name)                                                                           \
    TEST_WITH(name, struct resources *resources, a_structure_in_pages, resources_destroy)

/* Whether structure 1 lies in memory for work that follows the clock. */
enum tristate backed_for(struct resources *resources, const struct execution_clock *clock);
/* Whether structure 1 lies in memory for work that follows all earlier work. */
enum tristate backed(struct resources *resources);

/* ---- command pools and command buffers */

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
