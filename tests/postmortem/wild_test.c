/* SPDX-License-Identifier: Apache-2.0 */
/* A wild reference crashes lavapipe in a thread of its own, at an address that the reference leads
 * to: the report names the build and the reference. For scripts/nvidia --hang, with the platform
 * `environment`, this process builds, because a GPU's driver does not work in a child. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>
#include <string.h>
#include <unistd.h>

/* A TLAS. Waits, and ends the process. */
static void build_with_wild_reference(void)
{
    open_at(NULL);
    execute_line("init I0 reference 0x123456789000; build B0; submit; host wait idle");
    execute_line("c0: top T0 instances I0 B0");
    execute_line("submit c0; host wait idle");
    _exit(HANDLED);
}

TEST(test_wild_reference)
{
    if (strcmp(unit_test_arguments[0], "environment") == 0)
        build_with_wild_reference();
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
