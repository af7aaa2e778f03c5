/* SPDX-License-Identifier: Apache-2.0 */
/* The device that the tests of a program share. */
#ifndef ASSAY_TESTS_CPU_BACKEND_DEVICE_PROGRAM_H
#define ASSAY_TESTS_CPU_BACKEND_DEVICE_PROGRAM_H

#include "tests/cpu_backend/device_fixture.h"
#include "tests/state/unit_test.h"

extern struct device_fixture device;
extern struct fixture *const fixture; /* of the device */

static const VkCommandBufferLevel PRIMARY = VK_COMMAND_BUFFER_LEVEL_PRIMARY;

#endif
