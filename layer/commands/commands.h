/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that the layer intercepts. layer/commands/rows/ has a row for each, which says what
 * observes it; layer/commands/generate.py makes the functions that the application calls instead of
 * the next layer's: the entries. docs/code/commands.md says in which order an entry calls what.
 *
 * An entry first checks that the arguments can be read, before the layer reads them. A driver may
 * survive a call with NULL or an invalid pointer, or crash in its own code; the layer must not
 * crash first. If the memory that the layer would read is not readable, the entry only calls the
 * next layer. On backend cpu, where the layer is the driver, it skips such a call. Build commands
 * have no such check, because they report invalid pointers themselves. */
#ifndef ASSAY_LAYER_COMMANDS_COMMANDS_H
#define ASSAY_LAYER_COMMANDS_COMMANDS_H

#include "layer/layer.h"

/* What decides which entry of a command is used. */
enum command_condition {
    WITH_HAZARDS = 1 << 0,    /* setting hazards */
    WITH_CONTENT = 1 << 1,    /* inputs of builds are copied (layer/snapshots/) */
    WITH_CALL_SITES = 1 << 2, /* setting call_sites */
    WITH_BACKEND = 1 << 3,    /* backend cpu */
    WITH_CHECKS = 1 << 4,     /* a rule about the command is active */
    COMMAND_CONDITION_SETS = 1 << 5,
};

/* What vkGetInstanceProcAddr and vkGetDeviceProcAddr return, but for the commands of layer/assay.h:
 * an entry, or the next layer's command if nothing observes it. NULL: the next layer lacks it.
 * command_of_loader(): NULL unless vkGetInstanceProcAddr returns an entry whatever the instance. */
PFN_vkVoidFunction command_of_loader(const char *name, bool has_instance);
PFN_vkVoidFunction command_of_instance(const struct layer_instance *instance, const char *name);
PFN_vkVoidFunction command_of_device(const struct layer_device *device, const char *name);

/* Whether a string can be read to its end. NULL cannot. */
bool command_can_read_string(const char *string);

#endif
