/* SPDX-License-Identifier: Apache-2.0 */
/* Repeats the scene's builds with planted mistakes and prints what the layer says about each. */
#ifndef DEMO_MISTAKES_H
#define DEMO_MISTAKES_H

#include "findings.h"
#include "gpu.h"
#include "scene.h"

struct mistakes_score {
    uint32_t planted;
    uint32_t caught;
};

struct mistakes_score mistakes_run(struct gpu *gpu, const struct scene *scene,
                                   struct findings *findings);

#endif
