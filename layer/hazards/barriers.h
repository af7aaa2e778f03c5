/* SPDX-License-Identifier: Apache-2.0 */
/* Translates the dependencies of synchronization commands into entries of a journal. */
#ifndef ASSAY_LAYER_HAZARDS_BARRIERS_H
#define ASSAY_LAYER_HAZARDS_BARRIERS_H

#include "layer/hazards/recording.h"

/* A dependency of a render pass, for all bytes. */
void barriers_add_global(struct hazard_recording *recording, const struct dependency *dependency);

/* Adds the access flags of a VkMemoryBarrierAccessFlags3KHR in a chain. */
struct dependency barriers_with_flags_3(struct dependency dependency, const void *chain);

/* All commands before, and all after, with all their accesses. */
struct dependency barriers_full_dependency(void);

#endif
