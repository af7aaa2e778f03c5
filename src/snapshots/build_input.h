/* SPDX-License-Identifier: Apache-2.0 */
/* Translates the parameters of a build into the builder's input. */
#ifndef ASSAY_SNAPSHOTS_BUILD_INPUT_H
#define ASSAY_SNAPSHOTS_BUILD_INPUT_H

#include "src/snapshots/input.h"

VkResult build_input_open(const struct build_parameters *build, const struct input_memory *memory,
                          struct build_input *input);
void build_input_close(struct build_input *input);

#endif
