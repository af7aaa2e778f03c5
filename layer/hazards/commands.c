/* SPDX-License-Identifier: Apache-2.0 */
/* The intercepts that record accesses and barriers, by name. */
#include "layer/hazards/commands.h"

#include <string.h>

PFN_vkVoidFunction hazards_command(const struct layer_instance *instance, const char *name,
                                   PFN_vkVoidFunction own)
{
#define NAMED(name) {"vk" #name, (PFN_vkVoidFunction)hazards_##name},
    static const struct {
        const char *name;
        PFN_vkVoidFunction function;
    } commands[] = {HAZARDS_COMMANDS(NAMED)};
#undef NAMED
    if (!reporter_settings(instance->reporter)->hazards)
        return own;
    for (unsigned i = 0; i < sizeof(commands) / sizeof(commands[0]); i++)
        if (strcmp(commands[i].name, name) == 0)
            return commands[i].function;
    return own;
}
