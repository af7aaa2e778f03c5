/* SPDX-License-Identifier: Apache-2.0 */
/* Ray tracing for the layer: if rays are to be compared and the application enables neither
 * VK_KHR_ray_query nor VK_KHR_ray_tracing_pipeline, the layer enables one that the device has. */
#ifndef ASSAY_LAYER_COMPARE_ENABLE_H
#define ASSAY_LAYER_COMPARE_ENABLE_H

#include "layer/layer.h"
#include "src/base/chain.h"

struct compare_enabling {
    const VkDeviceCreateInfo *info; /* create the device with this */
    bool is_enabled;                /* the device will be able to trace rays */
    bool has_queries;               /* with ray queries; otherwise with ray-tracing pipelines */
    /* Storage that `info` may point to. */
    VkDeviceCreateInfo changed;
    union {
        VkPhysicalDeviceRayQueryFeaturesKHR queries;
        VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipelines;
    } features;
    struct chain_copy chain;
    const char **names;
};

/* Chooses the extension. If memory runs out, adds nothing. The caller calls compare_enabling_end()
 * after creating the device. */
void compare_enabling_begin(const struct layer_device *device, const VkDeviceCreateInfo *info,
                            struct compare_enabling *enabling);
/* Frees the storage. */
void compare_enabling_end(struct compare_enabling *enabling);

#endif
