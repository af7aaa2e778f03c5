/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the calls of commands that build no structures, before anything observes them. The
 * generated entries call these functions. */
#ifndef ASSAY_LAYER_INTERCEPTS_CHECKS_H
#define ASSAY_LAYER_INTERCEPTS_CHECKS_H

#include "layer/layer.h"

/* Whether a rule about the command is active on the device. */
bool checks_are_active(const struct layer_device *device, enum build_command command);

/* Validates a call. `arguments`: struct arguments_of_NAME. Returns true if the call is to be
 * skipped. */
bool check_command(struct layer_device *device, enum build_command command, const void *arguments);

/* As check_referenced_micromaps(), at level CONTENT; below, returns NULL. */
struct geometry_shapes *find_referenced_micromaps(struct layer_device *device, const void *bytes);

/* Reports that the first argument is no command buffer, or no device. */
void check_invalid_handle(enum build_command command, const void *handle);

#endif
