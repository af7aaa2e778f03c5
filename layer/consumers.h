/* SPDX-License-Identifier: Apache-2.0 */
/* Consumers of builds that have executed, and of what validation finds out about them. Each one
 * stands in a folder of its own, which an option of CMake leaves out. The rest of the layer names
 * none of them: it calls the functions below, which call all that the library has. */
#ifndef ASSAY_LAYER_CONSUMERS_H
#define ASSAY_LAYER_CONSUMERS_H

#include "layer/layer.h"
#include "src/check/content/content.h"
#include "src/snapshots/recording.h"
#include "src/state/order/batch.h"

/* A build that has executed, and whose inputs level content has copied. */
struct executed_input {
    struct journal *journal;
    const struct journal_entry *entry; /* the build's entry; NULL if it has none */
    const struct recorded_build *build;
    const struct input_memory *memory;
    const struct execution_point *point; /* of a build of instances; NULL: unknown */
    uint64_t destroy_count;              /* the value at the time of execution */
    const struct order_batch *batch;     /* that has executed it; may be gone after the call */
    uint32_t command;                    /* index of the command buffer in the batch */
    /* Builds are read in the order of their execution: not after the device was lost, when several
     * threads may read. */
    bool is_in_order;
};

/* What a consumer does. `self` is what its begin() or start() has made. Functions may be NULL. */
struct consumer {
    /* Before the device is created, with the application's parameters: may replace them by others,
     * which live until start(). Makes `*self`; NULL: the consumer is not needed. Not called on
     * backend cpu. */
    VkResult (*begin)(const struct layer_device *device, const VkDeviceCreateInfo **info,
                      void **self);
    /* The device could not be created with the parameters that begin() gave. */
    void (*refuse)(void *self);
    /* The device is created. Makes `*self` if there is no begin(), as that does. VK_INCOMPLETE: the
     * consumer is not needed. */
    VkResult (*start)(struct layer_device *device, void **self);
    /* The application leaves the device behind: it destroys it, or its instance. All work is
     * complete, and its input data was read. The caller holds no lock. */
    void (*conclude)(void *self, bool destroys_device);
    void (*stop)(void *self);    /* no batch runs, and no build is read any more */
    void (*destroy)(void *self); /* the device, if there is one, must be idle */

    /* How the records of structures refer to the inputs that the consumer retains. */
    const struct structure_inputs *inputs;
    /* What it does with batches. */
    struct batch_consumer (*batches)(void *self);
    /* A structure is about to be destroyed; its name is still known. Any thread. */
    void (*on_destroy)(void *self, VkAccelerationStructureKHR accel);
    /* A command traces a top-level structure, and an instance of it refers to `changed` (handles),
     * which was written since the last build of the top-level structure. Any thread. */
    void (*on_stale_trace)(void *self, uint64_t top, uint64_t changed);

    /* The functions below are called on the thread that delivers executions; if the device was
     * lost, on any thread. */

    /* A build is about to be read. Returns what reads it along with the rules; NULL: nothing. The
     * snapshots are locked until the reader has ended. */
    struct build_reader *(*on_build)(void *self, const struct executed_input *executed);
    /* The structures that the instances of an executed build by `command` refer to, if all are
     * known. `uses` is NULL if there are none. */
    void (*on_all_references)(void *self, enum build_command command,
                              const struct instance_uses *uses);
    /* The snapshots are locked only during this call: copies what is to be kept. */
    void (*keep)(void *self, const struct executed_input *executed);
    /* The findings about a command buffer of a batch were reported. `batch` is NULL if it was read
     * before it was complete: builds of it may follow. The caller holds no lock. */
    void (*report)(void *self, const struct order_batch *batch, uint32_t command);
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
void consumers_conclude(const struct layer_device *device, bool destroys_device);
void consumers_stop(const struct layer_device *device);
void consumers_destroy(struct layer_device *device);
/* Returns NULL if no consumer retains inputs. */
const struct structure_inputs *consumers_inputs(const struct layer_device *device);
/* Returns false if there is no memory. */
bool consumers_add_to_order(const struct layer_device *device);
void consumers_on_destroy(const struct layer_device *device, VkAccelerationStructureKHR accel);
void consumers_on_stale_trace(const struct layer_device *device, uint64_t top, uint64_t changed);
/* Returns the readers of a build, which the caller ends. */
struct build_reader *consumers_on_build(const struct layer_device *device,
                                        const struct executed_input *executed);
void consumers_end_readers(struct build_reader *readers);
void consumers_on_all_references(const struct layer_device *device, enum build_command command,
                                 const struct instance_uses *uses);
void consumers_keep(const struct layer_device *device, const struct executed_input *executed);
void consumers_report(const struct layer_device *device, const struct order_batch *batch,
                      uint32_t command);
void consumers_run(const struct layer_device *device);
bool consumers_are_postponed(const struct layer_device *device);

#endif
