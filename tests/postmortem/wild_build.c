/* SPDX-License-Identifier: Apache-2.0 */
/* For scripts/nvidia --hang: builds with a wild reference in this process, because a GPU's driver
 * does not work in a child. */
#include "tests/postmortem/crash_child.h"

TEST(test_wild_reference)
{
    build_with_wild_reference();
}
