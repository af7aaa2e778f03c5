/* SPDX-License-Identifier: Apache-2.0 */
/* Consumers of builds that have executed, and whose inputs level content has copied. Each one
 * stands in a folder of its own, which an option of CMake leaves out. The rest of the layer names
 * none of them: it calls the functions below, which call all that the library has. */
#ifndef ASSAY_LAYER_CONSUMERS_H
#define ASSAY_LAYER_CONSUMERS_H

#include "layer/layer.h"
#include "src/snapshots/recording.h"

/* A build that has executed. */
struct executed_input {
    struct journal *journal;
    const struct journal_entry *entry; /* the build's entry; NULL if it has none */
    const struct recorded_build *build;
    const struct input_memory *memory;
    uint64_t destroy_count; /* the value at the time of execution */
    VkQueue queue;          /* that has executed it */
};

/* What a consumer does. `self` is what its begin() has made. */
struct consumer {
    /* Before the device is created, with the application's parameters: may replace them by others,
     * which live until start(). Makes `*self`; NULL: the consumer is not needed. */
    VkResult (*begin)(const struct layer_device *device, const VkDeviceCreateInfo **info,
                      void **self);
    /* The device could not be created with the parameters that begin() gave. */
    void (*refuse)(void *self);
    /* The device is created. VK_INCOMPLETE: the consumer is not needed. */
    VkResult (*start)(void *self, struct layer_device *device);
    void (*destroy)(void *self); /* the device, if there is one, must be idle */

    /* How the records of structures refer to the inputs that the consumer retains. */
    const struct structure_inputs *inputs;

    /* The functions below are called on the thread that delivers executions. The snapshots are
     * locked only during this call: copies what is to be kept. */
    void (*keep)(void *self, const struct executed_input *executed);
    /* Works on what was kept. The caller holds no lock: this function may report messages and
     * submit to queues. Builds whose queue the layer may not use now stay for the next call. */
    void (*run)(void *self);
    /* Whether builds stay for the next call of run(). Any thread may ask. */
    bool (*is_postponed)(const void *self);
};

/* ---- all consumers of a device */

VkResult consumers_begin(struct layer_device *device, const VkDeviceCreateInfo **info);
void consumers_refuse(const struct layer_device *device);
VkResult consumers_start(struct layer_device *device);
void consumers_destroy(struct layer_device *device);
/* Returns NULL if no consumer retains inputs. */
const struct structure_inputs *consumers_inputs(const struct layer_device *device);
void consumers_keep(const struct layer_device *device, const struct executed_input *executed);
void consumers_run(const struct layer_device *device);
bool consumers_are_postponed(const struct layer_device *device);

#endif
