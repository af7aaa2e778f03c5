/* SPDX-License-Identifier: Apache-2.0 */
/* What the smoke test's files share: an instance and a device of the null driver. */
#ifndef SMOKE_H
#define SMOKE_H

#include "null_driver.h"
#include "tests/fixture/make.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>
#include <vulkan/utility/vk_dispatch_table.h>

#define CHECK(call) assert_int_equal(call, VK_SUCCESS)
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

extern struct null_driver_api driver;

struct fixture {
    VkuInstanceDispatchTable vki;
    VkuDeviceDispatchTable vk;
    VkInstance instance;
    VkPhysicalDevice physical[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
    VkDevice device;
    VkQueue queue;
};

void make_instance(struct fixture *f);
VkResult make_device(struct fixture *f, const void *pNext);
int set_up(void **state);
int set_up_device(void **state);
int tear_down(void **state);
VkBuffer make_buffer(struct fixture *f, VkBufferCreateFlags flags, VkDeviceSize size);
VkDeviceMemory make_memory(struct fixture *f, uint32_t type, VkDeviceSize size);
VkDeviceAddress address_of(struct fixture *f, VkBuffer buffer);
VkCommandPool make_pool(struct fixture *f);
VkCommandBuffer make_command_buffer(struct fixture *f, VkCommandPool pool);

/* The tests of commands, synchronization and failures. */
int run_command_tests(void);
/* What submitted commands do to the bytes of buffers. */
int run_transfer_tests(void);

#endif
