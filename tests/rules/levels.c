/* SPDX-License-Identifier: Apache-2.0 */
/* Levels by name. */
#include "levels.h"

#include <string.h>

enum level level_named(const char *name)
{
    static const char *const names[LEVEL_COUNT] = {"parameters", "state", "execution", "content"};
    enum level level = LEVEL_PARAMETERS;
    while (level < LEVEL_COUNT && strcmp(names[level], name) != 0)
        level++;
    return level;
}
