/* SPDX-License-Identifier: Apache-2.0 */
/* Dispatches of the layer's own in the application's command buffers: the compute pipelines, and
 * the state of the command buffer that a dispatch disturbs. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COPIES_DISPATCHES_H
#define ASSAY_LAYER_SNAPSHOTS_COPIES_DISPATCHES_H

#include "layer/snapshots/recorder.h"

enum own_shader { SHADER_COPY, SHADER_GATHER, SHADER_COUNT };
enum { SHADER_CONSTANTS_MAX = 64 /* bytes of push constants */ };

/* Of a device; from any thread. */
struct own_shaders;

VkResult own_shaders_create(const struct layer_device *device, struct own_shaders **shaders);
void own_shaders_destroy(struct own_shaders *shaders); /* NULL: nothing */

/* Whether a dispatch there changes nothing of what the application does. */
bool dispatches_are_allowed(const struct recorder *recorder);

/* Makes the pipeline of a shader and the recording's gate when they are first needed; false if that
 * fails. */
bool dispatches_prepare(const struct recorder *recorder, enum own_shader shader);

/* Records a dispatch of `groups` workgroups. The shader is prepared. */
void dispatches_add(struct recorder *recorder, enum own_shader shader, const void *constants,
                    uint32_t size, uint32_t groups);

/* After the last dispatch of a command: restores what the application had set. */
void dispatches_end(const struct recorder *recorder);

#endif
