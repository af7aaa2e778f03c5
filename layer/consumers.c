/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/consumers.h"

#include <stdlib.h>

/* ---- the consumers. An option of CMake leaves each one out; then a warning says that its setting
 * has no effect. */

#define LEFT_OUT(name, setting, says)                                                              \
    static VkResult warn_of_##name(struct layer_device *device, void **self)                       \
    {                                                                                              \
        (void)self;                                                                                \
        if (reporter_settings(device->instance->reporter)->setting)                                \
            reporter_warn(device->instance->reporter,                                              \
                          "assay_validation." #setting ": this library was built without " says);  \
        return VK_SUCCESS;                                                                         \
    }                                                                                              \
    static const struct consumer name = {.start = warn_of_##name}

#ifdef ASSAY_ADVICE
extern const struct consumer adviser; /* layer/advice/adviser.c */
#else
LEFT_OUT(adviser, advice, "ASSAY_ADVICE. No advice is given.");
#endif

#ifdef ASSAY_COMPARE
extern const struct consumer comparison; /* layer/compare/comparer.c */
#else
LEFT_OUT(comparison, compare_rays, "ASSAY_COMPARE. No rays are compared.");
#endif

#ifdef ASSAY_CAPTURE
extern const struct consumer capturing; /* layer/capture/capturer.c */
#else
LEFT_OUT(capturing, capture, "ASSAY_CAPTURE. Nothing is captured.");
#endif

static const struct consumer *const consumers[] = {&adviser, &comparison, &capturing};
enum { CONSUMERS = sizeof(consumers) / sizeof(consumers[0]) };

/* ---- all consumers of a device */

/* A consumer of a device. */
struct attached_consumer {
    struct attached_consumer *next;
    const struct consumer *consumer;
    void *self;
};

/* Calls a function of each consumer of a device that has it. */
#define CALL_ALL(device, function, ...)                                                            \
    for (const struct attached_consumer *at = (device)->consumers; at; at = at->next)              \
        if (at->consumer->function)                                                                \
    at->consumer->function(at->self __VA_OPT__(, ) __VA_ARGS__)

static VkResult attach(struct layer_device *device, const struct consumer *consumer, void *self)
{
    struct attached_consumer *attached = malloc(sizeof(*attached));
    if (!attached) {
        consumer->destroy(self);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    *attached = (struct attached_consumer){device->consumers, consumer, self};
    device->consumers = attached;
    return VK_SUCCESS;
}

static void detach(struct attached_consumer **link)
{
    struct attached_consumer *attached = *link;
    *link = attached->next;
    attached->consumer->destroy(attached->self);
    free(attached);
}

VkResult consumers_begin(struct layer_device *device, const VkDeviceCreateInfo **info)
{
    VkResult result = VK_SUCCESS;
    for (int i = 0; result == VK_SUCCESS && i < CONSUMERS; i++) {
        void *self = NULL;
        if (consumers[i]->begin)
            result = consumers[i]->begin(device, info, &self);
        if (result == VK_SUCCESS && self)
            result = attach(device, consumers[i], self);
    }
    return result;
}

void consumers_refuse(const struct layer_device *device)
{
    CALL_ALL(device, refuse);
}

static VkResult start_attached(struct layer_device *device)
{
    struct attached_consumer **link = &device->consumers;
    while (*link) {
        const VkResult result = (*link)->consumer->start(device, &(*link)->self);
        if (result == VK_INCOMPLETE)
            detach(link);
        else if (result != VK_SUCCESS)
            return result;
        else
            link = &(*link)->next;
    }
    return VK_SUCCESS;
}

VkResult consumers_start(struct layer_device *device)
{
    VkResult result = start_attached(device);
    for (int i = 0; result == VK_SUCCESS && i < CONSUMERS; i++) {
        void *self = NULL;
        if (!consumers[i]->begin)
            result = consumers[i]->start(device, &self);
        if (result == VK_SUCCESS && self)
            result = attach(device, consumers[i], self);
    }
    return result;
}

void consumers_conclude(const struct layer_device *device, bool destroys_device)
{
    CALL_ALL(device, conclude, destroys_device);
}

void consumers_stop(const struct layer_device *device)
{
    CALL_ALL(device, stop);
}

void consumers_destroy(struct layer_device *device)
{
    while (device->consumers)
        detach(&device->consumers);
}

const struct structure_inputs *consumers_inputs(const struct layer_device *device)
{
    for (const struct attached_consumer *at = device->consumers; at; at = at->next)
        if (at->consumer->inputs)
            return at->consumer->inputs;
    return NULL;
}

bool consumers_add_to_order(const struct layer_device *device)
{
    bool has_room = true;
    for (const struct attached_consumer *at = device->consumers; at; at = at->next)
        if (at->consumer->batches)
            has_room &=
                execution_order_add_consumer(device->order, at->consumer->batches(at->self));
    return has_room;
}

void consumers_on_destroy(const struct layer_device *device, VkAccelerationStructureKHR accel)
{
    CALL_ALL(device, on_destroy, accel);
}

void consumers_on_stale_trace(const struct layer_device *device, uint64_t top, uint64_t changed)
{
    CALL_ALL(device, on_stale_trace, top, changed);
}

struct build_reader *consumers_on_build(const struct layer_device *device,
                                        const struct executed_input *executed)
{
    struct build_reader *readers = NULL;
    for (const struct attached_consumer *at = device->consumers; at; at = at->next) {
        struct build_reader *reader =
            at->consumer->on_build ? at->consumer->on_build(at->self, executed) : NULL;
        if (!reader)
            continue;
        reader->next = readers;
        readers = reader;
    }
    return readers;
}

void consumers_end_readers(struct build_reader *readers)
{
    while (readers) {
        struct build_reader *reader = readers;
        readers = reader->next;
        reader->end(reader);
    }
}

void consumers_on_all_references(const struct layer_device *device, enum build_command command,
                                 const struct instance_uses *uses)
{
    CALL_ALL(device, on_all_references, command, uses);
}

void consumers_keep(const struct layer_device *device, const struct executed_input *executed)
{
    CALL_ALL(device, keep, executed);
}

void consumers_report(const struct layer_device *device, const struct order_batch *batch,
                      uint32_t command)
{
    CALL_ALL(device, report, batch, command);
}

void consumers_run(const struct layer_device *device)
{
    CALL_ALL(device, run);
}

bool consumers_are_postponed(const struct layer_device *device)
{
    bool are_postponed = false;
    for (const struct attached_consumer *at = device->consumers; at; at = at->next)
        are_postponed |= at->consumer->is_postponed && at->consumer->is_postponed(at->self);
    return are_postponed;
}
