/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about copies of structures and micromaps. */
#include "src/rules/predicates.h"

bool copy_mode_is_compact_or_clone(const struct copy_view *copy, struct finding *finding)
{
    return copy->mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR ||
           copy->mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR ||
           violated(finding, "mode", "{} is neither compact nor clone", copy->given_mode);
}
