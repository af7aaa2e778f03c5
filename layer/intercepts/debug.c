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

static void set_name(struct layer_device *device, VkObjectType type, uint64_t handle,
                     const char *name)
{
    const struct command_buffer *command_buffer =
        type == VK_OBJECT_TYPE_COMMAND_BUFFER
            ? command_buffers_find(device->command_buffers, (VkCommandBuffer)(uintptr_t)handle)
            : NULL;
    object_names_set_of(device->names, type, handle, command_buffer ? command_buffer->facts.id : 0,
                        name);
}

void note_object_name(struct layer_device *device, const VkDebugUtilsObjectNameInfoEXT *info)
{
    set_name(device, info->objectType, info->objectHandle, info->pObjectName);
}

/* The two enumerations of object types have the same values for all types that messages name. */
void note_marker_name(struct layer_device *device, const VkDebugMarkerObjectNameInfoEXT *info)
{
    set_name(device, (VkObjectType)info->objectType, info->object, info->pObjectName);
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

static VkDebugUtilsLabelEXT label_of_marker(const VkDebugMarkerMarkerInfoEXT *marker)
{
    VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
    if (marker) {
        label.pLabelName = marker->pMarkerName;
        memcpy(label.color, marker->color, sizeof(label.color));
    }
    return label;
}

void open_marker(struct layer_device *device, VkCommandBuffer command_buffer,
                 const VkDebugMarkerMarkerInfoEXT *marker)
{
    VkDebugUtilsLabelEXT label = label_of_marker(marker);
    open_label(device, command_buffer, &label);
}

void insert_marker(struct layer_device *device, VkCommandBuffer command_buffer,
                   const VkDebugMarkerMarkerInfoEXT *marker)
{
    VkDebugUtilsLabelEXT label = label_of_marker(marker);
    insert_label(device, command_buffer, &label);
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
