/* SPDX-License-Identifier: Apache-2.0 */
/* A wild reference crashes lavapipe in a thread of its own, at an address that the reference leads
 * to: the report names the build and the reference. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>

TEST(test_wild_reference)
{
    run(build_with_wild_reference, NULL, NULL);
    assert_has(output, "is not the address of an acceleration structure of this device");
    assert_has(output, "0x123456789000");
    print_message("%s\n", WIFSIGNALED(status) ? "lavapipe crashes" : "lavapipe does not crash");
    if (WIFEXITED(status) && WEXITSTATUS(status) == HANDLED)
        return; /* another release of lavapipe than those that crash */
    EXPECT_ENDING(SIGSEGV,
                  "ASSAY-crash...1. build of VkAccelerationStructureKHR 0x...: its inputs had been "
                  "copied, and it had "
                  "not finished...read when the process crashed");
}
