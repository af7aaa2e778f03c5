/* SPDX-License-Identifier: Apache-2.0 */
/* The part of the builder's input that concerns micromaps; for build_input.c. */
#ifndef ASSAY_SNAPSHOTS_MICROMAP_INPUT_H
#define ASSAY_SNAPSHOTS_MICROMAP_INPUT_H

#include "src/snapshots/input.h"

/* Fills in the input of a micromap build. */
void build_input_find_micromap(const struct build_parameters *build,
                               const struct input_memory *memory, struct micromap_input *to);

/* Fills in the micromaps of geometries that use them, after the geometries have been described. */
VkResult build_input_find_micromaps(const struct build_parameters *build,
                                    const struct input_memory *memory, struct build_input *input);

#endif
