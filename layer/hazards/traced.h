/* SPDX-License-Identifier: Apache-2.0 */
/* Records what the shaders of a command may write, and which structures they trace, as far as code,
 * push constants and descriptors show. */
#ifndef ASSAY_LAYER_HAZARDS_TRACED_H
#define ASSAY_LAYER_HAZARDS_TRACED_H

#include "layer/hazards/pipelines.h"
#include "layer/hazards/recording.h"
#include "src/state/commands/bound_shaders.h"

/* A command that runs shaders. */
struct shader_command {
    const char *name;
    enum shader_point point;
    enum access_kind write, trace; /* `trace`: ACCESS_KINDS: the command does not trace */
    uint32_t base[3], size[3];     /* in workgroups, or rays; size 0: unknown */
};

/* Begins the command and adds its accesses. */
void hazards_add_shaders(struct hazard_recording *recording, const struct shader_command *command);

#endif
