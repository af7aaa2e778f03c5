/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the scene with ray queries in a compute shader. */
#ifndef DEMO_RENDER_H
#define DEMO_RENDER_H

#include "scene.h"
#include "tests/tools/gpu.h"

#define RENDER_GRID 3 /* samples a pixel, squared */

/* Fill pixels[width * height] with RGBA bytes, the top row first. */
void render_scene(struct gpu *gpu, const struct scene *scene, uint32_t width, uint32_t height,
                  uint32_t *pixels);

/* The same with the layer's reference tracing (assay.h), on a device of backend cpu. */
void trace_scene(struct gpu *gpu, const struct scene *scene, uint32_t width, uint32_t height,
                 uint32_t *pixels);

#endif
