/* SPDX-License-Identifier: Apache-2.0 */
/* The device that the tests of a program share. */
#include "tests/cpu_backend/device_program.h"

struct device_fixture device;
struct fixture *const fixture = &device.fixture;

const char *unit_test_open(const char *platform)
{
    return device_fixture_open(&device, platform);
}

void unit_test_close(void)
{
    device_fixture_close(&device);
}
