/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that the arguments of intercepted commands can be read, before the layer reads them.
 *
 * A driver may survive a call with NULL or an invalid pointer, or crash in its own code. The layer
 * must not crash first. So the application gets checked functions: if all memory that the layer
 * would read is readable, they call the intercept, and else the next layer's command. The layer
 * then does not learn of the call. On backend cpu, where the layer is the driver, such a call is
 * skipped.
 *
 * layer/lifecycle/arguments.py generates the checks from the registry. Build commands have none,
 * because they report invalid pointers themselves. */
#ifndef ASSAY_LAYER_LIFECYCLE_ARGUMENTS_H
#define ASSAY_LAYER_LIFECYCLE_ARGUMENTS_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

/* Returns the checked function of one of the layer's, or `command` if it needs no check. */
PFN_vkVoidFunction arguments_checked(PFN_vkVoidFunction command);

/* Whether a string can be read to its end. NULL cannot. */
bool arguments_can_read_string(const char *string);

#endif
