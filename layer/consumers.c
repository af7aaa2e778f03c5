/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/consumers.h"

#include <stdlib.h>

/* ---- which there are: each by the option of CMake that has its name */

#ifdef ASSAY_COMPARE
extern const struct consumer comparison; /* layer/compare/comparer.c */
#else
static VkResult warn_of_setting(const struct layer_device *device, const VkDeviceCreateInfo **info,
                                void **self)
{
    (void)info;
    (void)self;
    if (reporter_settings(device->instance->reporter)->compare_rays)
        reporter_warn(device->instance->reporter,
                      "assay_validation.compare_rays: this library was built without "
                      "ASSAY_COMPARE. No rays are compared.");
    return VK_SUCCESS;
}
static const struct consumer comparison = {.begin = warn_of_setting};
#endif

static const struct consumer *const consumers[] = {&comparison};

/* ---- all consumers of a device */

/* A consumer of a device. */
struct attached_consumer {
    struct attached_consumer *next;
    const struct consumer *consumer;
    void *self;
};

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
    for (size_t i = 0; i < sizeof(consumers) / sizeof(consumers[0]); i++) {
        void *self = NULL;
        VkResult result = consumers[i]->begin(device, info, &self);
        if (result == VK_SUCCESS && self)
            result = attach(device, consumers[i], self);
        if (result != VK_SUCCESS)
            return result;
    }
    return VK_SUCCESS;
}

void consumers_refuse(const struct layer_device *device)
{
    for (struct attached_consumer *at = device->consumers; at; at = at->next)
        at->consumer->refuse(at->self);
}

VkResult consumers_start(struct layer_device *device)
{
    struct attached_consumer **link = &device->consumers;
    while (*link) {
        const VkResult result = (*link)->consumer->start((*link)->self, device);
        if (result == VK_INCOMPLETE)
            detach(link);
        else if (result != VK_SUCCESS)
            return result;
        else
            link = &(*link)->next;
    }
    return VK_SUCCESS;
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

void consumers_keep(const struct layer_device *device, const struct executed_input *executed)
{
    for (struct attached_consumer *at = device->consumers; at; at = at->next)
        at->consumer->keep(at->self, executed);
}

void consumers_run(const struct layer_device *device)
{
    for (struct attached_consumer *at = device->consumers; at; at = at->next)
        at->consumer->run(at->self);
}

bool consumers_are_postponed(const struct layer_device *device)
{
    bool are_postponed = false;
    for (struct attached_consumer *at = device->consumers; at; at = at->next)
        are_postponed |= at->consumer->is_postponed(at->self);
    return are_postponed;
}
