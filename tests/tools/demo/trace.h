/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the scene with the layer's reference tracing (assay.h), as render.h does with ray queries.
 */
#ifndef DEMO_TRACE_H
#define DEMO_TRACE_H

#include "gpu.h"
#include "scene.h"

/* Fill pixels[width * height] with RGBA bytes, the top row first. On a device of backend cpu. */
void trace_scene(struct gpu *gpu, const struct scene *scene, uint32_t width, uint32_t height,
                 uint32_t *pixels);

#endif
