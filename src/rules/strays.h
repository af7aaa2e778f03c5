/* SPDX-License-Identifier: Apache-2.0 */
/* Structures in a pNext chain whose sType is invalid there. */
#ifndef ASSAY_RULES_STRAYS_H
#define ASSAY_RULES_STRAYS_H

#include "vuid-tables/rules.h"

struct geometry_view;

/* Returns the rule that takes the invalid structure in a chain for a structure with a wrong sType.
 * Returns RULE_COUNT if there is none. The message of that rule names the id about the chain. */
enum rule rule_of_stray(const struct geometry_view *geometry);
enum rule rule_of_triangles_stray(const struct geometry_view *geometry);

#endif
