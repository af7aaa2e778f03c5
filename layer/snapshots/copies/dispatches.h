/* SPDX-License-Identifier: Apache-2.0 */
/* Records dispatches of the layer's own into the application's command buffers: owns the compute
 * pipelines, and restores the state that a dispatch disturbs. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_DISPATCHES_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_DISPATCHES_H

#include "layer/snapshots/recorder.h"

enum own_shader { SHADER_COPY, SHADER_GATHER, SHADER_GUARD, SHADER_COUNT };
enum { SHADER_CONSTANTS_MAX = 64 /* bytes of push constants */ };

/* One for each device; usable from any thread. */
struct own_shaders;

VkResult own_shaders_create(const struct layer_device *device, struct own_shaders **shaders);
void own_shaders_destroy(struct own_shaders *shaders); /* accepts NULL */

/* Whether a dispatch at this point leaves the application's commands unaffected. */
bool dispatches_are_allowed(const struct recorder *recorder);

/* Creates the pipeline of a shader and the recording's gate on first use. Returns false if that
 * fails. */
bool dispatches_prepare(const struct recorder *recorder, enum own_shader shader);

/* Records a dispatch of `groups` workgroups. Call dispatches_prepare() first. */
void dispatches_add(struct recorder *recorder, enum own_shader shader, const void *constants,
                    uint32_t size, uint32_t groups);

/* Called after the last dispatch of a command: restores the application's state. */
void dispatches_end(const struct recorder *recorder);

/* ---- Tracks the state of a command buffer that a dispatch of the layer's own disturbs, so that it
 * can be restored: compute bindings and push constants. */

/* The state of a command buffer. Returns NULL if it is not tracked. */
struct compute_state *compute_state_of(const struct layer_device *device, VkCommandBuffer handle);

#endif
