/* SPDX-License-Identifier: Apache-2.0 */
/* Advice about what a command traces. */
#include "src/rules/advice.h"

bool top_level_is_newer_than_its_bottom_levels(const struct traced_view *traced,
                                               struct finding *finding, uint64_t *weight)
{
    *weight = 1;
    return !traced->changed ||
           violated(
               finding, "",
               "was traced though {}, to which an instance of it refers, was built, updated or "
               "copied to since its last build",
               object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, traced->changed));
}
