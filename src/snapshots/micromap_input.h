/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's input as far as micromaps go; for build_input.c. */
#ifndef ASSAY_SNAPSHOTS_MICROMAP_INPUT_H
#define ASSAY_SNAPSHOTS_MICROMAP_INPUT_H

#include "src/snapshots/input.h"

/* Of a build of a micromap. */
void build_input_find_micromap(const struct build_parameters *build,
                               const struct input_memory *memory, struct micromap_input *to);

/* Of geometries that use micromaps; the others of the input have been described. */
VkResult build_input_find_micromaps(const struct build_parameters *build,
                                    const struct input_memory *memory, struct build_input *input);

#endif
