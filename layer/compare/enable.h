/* SPDX-License-Identifier: Apache-2.0 */
/* Tracing for the layer itself: where rays are to be compared and the application enables neither
 * VK_KHR_ray_query nor VK_KHR_ray_tracing_pipeline, the layer adds what the device has. */
#ifndef ASSAY_LAYER_COMPARE_ENABLE_H
#define ASSAY_LAYER_COMPARE_ENABLE_H

#include "layer/layer.h"
#include "src/base/chain_copy.h"

struct compare_enabling {
    const VkDeviceCreateInfo *info; /* to create the device with */
    bool is_wanted;                 /* rays are to be compared, and the device builds */
    bool is_enabled;                /* the device will trace: */
    bool has_queries;               /* by ray queries; else by ray-tracing pipelines */
    bool is_added;                  /* by the layer */
    /* What `info` may point to. */
    VkDeviceCreateInfo changed;
    union {
        VkPhysicalDeviceRayQueryFeaturesKHR queries;
        VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipelines;
    } features;
    struct chain_copy chain;
    const char **names;
};

/* Without memory nothing is added. */
void compare_enabling_begin(const struct layer_device *device, const VkDeviceCreateInfo *info,
                            struct compare_enabling *enabling);
/* The device couldn't be created so. */
void compare_enabling_undo(struct compare_enabling *enabling, const VkDeviceCreateInfo *info);
void compare_enabling_end(struct compare_enabling *enabling);

#endif
