/* SPDX-License-Identifier: Apache-2.0 */
/* A wild reference crashes lavapipe in a thread of its own, at an address that the reference leads
 * to: the report names the build and the reference. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>

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
