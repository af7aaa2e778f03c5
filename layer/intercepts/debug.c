/* SPDX-License-Identifier: Apache-2.0 */
/* Observes VK_EXT_debug_utils, VK_EXT_debug_report and VK_EXT_debug_marker: the messengers
 * that receive the layer's messages, and the names and labels in these messages. */
#include <string.h>

#include "observers.h"
#include "src/report/log/lines.h"

/* ---- messengers */

VkResult note_messenger(struct layer_instance *instance, VkDebugUtilsMessengerEXT *messenger,
                        const VkDebugUtilsMessengerCreateInfoEXT *info,
                        const VkAllocationCallbacks *allocator)
{
    VkResult result = reporter_add_messenger(instance->reporter, *messenger, info);
    if (result != VK_SUCCESS) {
        instance->vk.DestroyDebugUtilsMessengerEXT(instance->handle, *messenger, allocator);
        *messenger = VK_NULL_HANDLE;
    }
    return result;
}

void forget_messenger(struct layer_instance *instance, VkDebugUtilsMessengerEXT messenger)
{
    reporter_remove_messenger(instance->reporter, messenger);
}

VkResult note_report_callback(struct layer_instance *instance, VkDebugReportCallbackEXT *callback,
                              const VkDebugReportCallbackCreateInfoEXT *info,
                              const VkAllocationCallbacks *allocator)
{
    VkResult result = reporter_add_report_callback(instance->reporter, *callback, info);
    if (result != VK_SUCCESS) {
        instance->vk.DestroyDebugReportCallbackEXT(instance->handle, *callback, allocator);
        *callback = VK_NULL_HANDLE;
    }
    return result;
}

void forget_report_callback(struct layer_instance *instance, VkDebugReportCallbackEXT callback)
{
    reporter_remove_report_callback(instance->reporter, callback);
}

/* ---- names */

void note_object_name(struct layer_device *device, const VkDebugUtilsObjectNameInfoEXT *info)
{
    const struct command_buffer *command_buffer =
        info->objectType == VK_OBJECT_TYPE_COMMAND_BUFFER
            ? command_buffers_find(device->command_buffers,
                                   (VkCommandBuffer)(uintptr_t)info->objectHandle)
            : NULL;
    object_names_set_of(device->names, info->objectType, info->objectHandle,
                        command_buffer ? command_buffer->facts.id : 0, info->pObjectName);
}

/* ---- labels of command buffers */

/* Logs a label that announces findings: assay-run has to know of regions without any. */
static void note_expectation(struct layer_device *device, const VkDebugUtilsLabelEXT *label)
{
    const size_t length = strlen(EXPECTATION_PREFIX);
    if (label && label->pLabelName && strncmp(label->pLabelName, EXPECTATION_PREFIX, length) == 0)
        reporter_record(device->instance->reporter, &(struct log_record){
                                                        .kind = RECORD_EXPECTATION,
                                                        .device = device->handle,
                                                        .label = label->pLabelName,
                                                    });
}

void open_label(struct layer_device *device, VkCommandBuffer command_buffer,
                const VkDebugUtilsLabelEXT *label)
{
    struct label_stack *labels = command_buffers_labels(device->command_buffers, command_buffer);
    note_expectation(device, label);
    if (labels)
        label_stack_push(labels, label);
}

void close_label(struct layer_device *device, VkCommandBuffer command_buffer)
{
    struct label_stack *labels = command_buffers_labels(device->command_buffers, command_buffer);
    if (labels)
        label_stack_pop(labels);
}

void insert_label(struct layer_device *device, VkCommandBuffer command_buffer,
                  const VkDebugUtilsLabelEXT *label)
{
    struct label_stack *labels = command_buffers_labels(device->command_buffers, command_buffer);
    if (labels)
        label_stack_insert(labels, label);
}

/* ---- labels of queues */

void open_queue_label(struct layer_device *device, VkQueue queue, const VkDebugUtilsLabelEXT *label)
{
    note_expectation(device, label);
    queue_labels_push(device->queue_labels, queue, label);
}

void close_queue_label(struct layer_device *device, VkQueue queue)
{
    queue_labels_pop(device->queue_labels, queue);
}

void insert_queue_label(struct layer_device *device, VkQueue queue,
                        const VkDebugUtilsLabelEXT *label)
{
    queue_labels_insert(device->queue_labels, queue, label);
}
