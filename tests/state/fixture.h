/* SPDX-License-Identifier: Apache-2.0 */
/* Handles made of numbers, and resources filled and asked in one line each. */
#ifndef ASSAY_TESTS_STATE_FIXTURE_H
#define ASSAY_TESTS_STATE_FIXTURE_H

#include "src/state/resources/resources.h"
#include "tests/state/unit_test.h"

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
void have_sparse_buffer(struct resources *resources, unsigned n, VkDeviceSize size);
void bind_at(struct resources *resources, unsigned n, unsigned memory_n, VkDeviceSize offset);
/* Executed on queue 1. */
extern const struct execution_clock all_of_queue_1;
void bind_sparse(struct resources *resources, unsigned n, VkDeviceSize begin, VkDeviceSize size,
                 unsigned memory_n, VkDeviceSize offset);
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

#endif
