/* SPDX-License-Identifier: Apache-2.0 */
/* The two sides of a comparison: a device with the layer above it, and one without. Both live in
 * one process, so that their samples can take turns. */
#ifndef BENCH_SIDE_H
#define BENCH_SIDE_H

#include <stdbool.h>

#include "scripts/tools/gpu.h"

#define BENCH_PEER "VK_LAYER_KHRONOS_validation"

/* Messages of the layer once the device is there: there should be none, or, of builds with
 * mistakes, some. */
struct side_findings {
    bool is_open;
    bool are_expected;
    uint32_t count;
};

struct side {
    const char *layer; /* or NULL */
    struct gpu gpu;
    struct side_findings *findings;
};

/* Makes the loader see only the driver "null" or "lavapipe", and layers only of this build tree, or
 * of VK_LAYER_PATH where the caller has set it. */
void driver_select(const char *name);

/* Lets the loader find layers where it looks by itself, too, and in `folder`, unless that is NULL.
 * Call it before driver_select. */
void layers_select_all(const char *folder);
/* What the loader says of a layer; false: it finds none of that name. */
bool layer_find(const char *name, VkLayerProperties *found);

/* `layer` is one of the names above, or NULL; `level` is a setting of GPU_LAYER, or NULL for its
 * default. */
void side_open(struct side *side, const char *layer, const char *level);
/* Opens a side whose layer gets `count` settings. */
void side_open_with(struct side *side, const char *layer, const VkLayerSettingEXT *settings,
                    uint32_t count);
void side_close(struct side *side);

#endif
