/* SPDX-License-Identifier: Apache-2.0 */
/* The levels by the names that the layer's setting has for them. */
#ifndef RULES_LEVELS_H
#define RULES_LEVELS_H

#include "vuid-tables/rules.h"

/* LEVEL_COUNT where there is none of that name. */
enum level level_named(const char *name);

#endif
