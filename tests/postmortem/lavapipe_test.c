/* SPDX-License-Identifier: Apache-2.0 */
/* A wild reference crashes lavapipe in a thread of its own, at an address that the reference leads
 * to: the report names the build and the reference. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>
#include <string.h>
#include <unistd.h>

enum { SIZE = 1 << 16 };

static const uint64_t wild = 0x123456789000;

static void build_with_wild_reference(void)
{
    scene_open(&(struct scene_setup){.boxes_size = SIZE, .structure_size = SIZE, .has_tlas = true});
    fixture.instance.vk.DestroyDebugUtilsMessengerEXT(fixture.instance.instance,
                                                      fixture.instance.messenger, NULL);
    struct device_buffer instances = scene_input(SIZE);
    scene_write_instance(&instances, true);
    ((VkAccelerationStructureInstanceKHR *)instances.bytes)->accelerationStructureReference = wild;
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    scene_build_instance(commands, instances.address, false);
    scene_submit(commands);
    fixture.vk.DeviceWaitIdle(fixture.device);
    _exit(HANDLED);
}

TEST(test_wild_reference)
{
    run(build_with_wild_reference, NULL, NULL);
    expect_output("is not the address of an acceleration structure of this device");
    expect_output("0x123456789000");
    print_message("%s\n", WIFSIGNALED(status) ? "lavapipe crashes" : "lavapipe does not crash");
    if (WIFEXITED(status) && WEXITSTATUS(status) == HANDLED)
        return; /* another release of lavapipe than those that crash */
    expect_signal(SIGSEGV);
    expect_output("ASSAY-crash");
    expect_output("1. build of VkAccelerationStructureKHR 0x");
    expect_output(": its inputs had been copied, and it had not finished.");
    expect_output("read when the process crashed");
}
