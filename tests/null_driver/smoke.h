/* SPDX-License-Identifier: Apache-2.0 */
/* What the smoke test's files share: an instance and a device of the null driver. */
#ifndef SMOKE_H
#define SMOKE_H

#include "null_driver.h"
#include "tests/fixture/make.h"
#include "tests/fixture/objects.h"
#include "tests/state/unit_test.h"

#include <string.h>

extern struct null_driver_api driver;

/* Of the test that runs. */
extern VkuInstanceDispatchTable vki;
extern VkuDeviceDispatchTable vk;
extern VkPhysicalDevice physical[NULL_DRIVER_MAX_PHYSICAL_DEVICES];
extern VkInstance instance;
extern VkDevice device;
extern VkQueue queue;

/* A test that makes its instance and device, and one with those of the default configuration. */
#define INSTANCE_TEST(name) TEST_BETWEEN(name, set_up, tear_down)
#define DEVICE_TEST(name) TEST_BETWEEN(name, set_up_device, tear_down)
void set_up(void);
void set_up_device(void);
void tear_down(void);

void make_instance(void);
VkResult make_device(const void *pNext);
VkBuffer make_buffer(VkBufferCreateFlags flags, VkDeviceSize size);
VkDeviceMemory make_memory(uint32_t type, VkDeviceSize size);
/* With memory of that type, which is mapped if `mapped` is not NULL. */
VkBuffer make_bound_buffer(VkDeviceSize size, uint32_t type, void **mapped);
VkDeviceAddress address_of(VkBuffer buffer);
VkCommandBuffer make_command_buffer(VkCommandPool pool); /* in the recording state */

#endif
