/* SPDX-License-Identifier: Apache-2.0 */
/* Compares executed builds (setting compare_rays): the driver builds the same input again in memory
 * of the layer, and rays are traced through that structure and through the reference.
 *
 * Only the thread that delivers executions uses a comparer. The inputs that it retains for
 * structures may be released on any thread. */
#ifndef ASSAY_LAYER_COMPARE_COMPARER_H
#define ASSAY_LAYER_COMPARE_COMPARER_H

#include "layer/layer.h"
#include "src/base/chain.h"
#include "src/snapshots/recording.h"

struct compare_enabling;

/* Creates layer_device.comparer, which stays NULL if nothing is to be compared. */
VkResult comparer_create(struct layer_device *device, const struct compare_enabling *enabling);
/* Frees the comparer and warns if builds were not compared. The device must be idle. */
void comparer_destroy(struct comparer *comparer); /* `comparer` may be NULL */

/* How the records of structures refer to the inputs that comparers retain. */
extern const struct structure_inputs comparer_inputs;

/* A build that has executed. */
struct executed_input {
    struct journal *journal;
    const struct journal_entry *entry; /* the build's entry; NULL if it has none */
    const struct recorded_build *build;
    const struct input_memory *memory;
    uint64_t destroy_count; /* the value at the time of execution */
    VkQueue queue;          /* that has executed it */
};
/* Copies the bytes of the input if they are known, because the snapshots are locked only during
 * this call. Does nothing if `comparer` is NULL. */
void comparer_keep(struct comparer *comparer, const struct executed_input *executed);

/* Compares the retained builds. The caller must hold no lock: this function reports messages and
 * submits to queues. Builds whose queue the layer may not use now stay for the next call. */
void comparer_run(struct comparer *comparer);
/* Whether builds stay for the next call of comparer_run(). Any thread may ask. */
bool comparer_is_postponed(const struct comparer *comparer); /* `comparer` may be NULL */

/* ---- Ray tracing for the layer: if rays are to be compared and the application enables neither
 * VK_KHR_ray_query nor VK_KHR_ray_tracing_pipeline, the layer enables one that the device has. */

struct compare_enabling {
    const VkDeviceCreateInfo *info; /* create the device with this */
    bool is_requested; /* the setting requests it, and the device enables acceleration structures */
    bool is_enabled;   /* the device will be able to trace rays */
    bool has_queries;  /* with ray queries; otherwise with ray-tracing pipelines */
    bool is_added;     /* the layer added the extension */
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
/* Call this if the device could not be created with the added extension. */
void compare_enabling_undo(struct compare_enabling *enabling, const VkDeviceCreateInfo *info);
/* Frees the storage. */
void compare_enabling_end(struct compare_enabling *enabling);

#endif
