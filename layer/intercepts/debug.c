/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of VK_EXT_debug_utils, VK_EXT_debug_report and VK_EXT_debug_marker: the messengers
 * that receive the layer's messages, and the names and labels in these messages. */
#include <string.h>

#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"

/* ---- messengers */

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateDebugUtilsMessengerEXT(
    VkInstance instance, const VkDebugUtilsMessengerCreateInfoEXT *pCreateInfo,
    const VkAllocationCallbacks *pAllocator, VkDebugUtilsMessengerEXT *pMessenger)
{
    struct layer_instance *state = layer_find_instance(instance);
    if (!state->vk.CreateDebugUtilsMessengerEXT)
        return VK_ERROR_EXTENSION_NOT_PRESENT;

    VkResult result =
        state->vk.CreateDebugUtilsMessengerEXT(instance, pCreateInfo, pAllocator, pMessenger);
    if (result != VK_SUCCESS)
        return result;
    result = reporter_add_messenger(state->reporter, *pMessenger, pCreateInfo);
    if (result != VK_SUCCESS) {
        state->vk.DestroyDebugUtilsMessengerEXT(instance, *pMessenger, pAllocator);
        *pMessenger = VK_NULL_HANDLE;
    }
    return result;
}

VKAPI_ATTR void VKAPI_CALL
assay_DestroyDebugUtilsMessengerEXT(VkInstance instance, VkDebugUtilsMessengerEXT messenger,
                                    const VkAllocationCallbacks *pAllocator)
{
    struct layer_instance *state = layer_find_instance(instance);
    reporter_remove_messenger(state->reporter, messenger);
    if (state->vk.DestroyDebugUtilsMessengerEXT)
        state->vk.DestroyDebugUtilsMessengerEXT(instance, messenger, pAllocator);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateDebugReportCallbackEXT(
    VkInstance instance, const VkDebugReportCallbackCreateInfoEXT *pCreateInfo,
    const VkAllocationCallbacks *pAllocator, VkDebugReportCallbackEXT *pCallback)
{
    struct layer_instance *state = layer_find_instance(instance);
    if (!state->vk.CreateDebugReportCallbackEXT)
        return VK_ERROR_EXTENSION_NOT_PRESENT;

    VkResult result =
        state->vk.CreateDebugReportCallbackEXT(instance, pCreateInfo, pAllocator, pCallback);
    if (result != VK_SUCCESS)
        return result;
    result = reporter_add_report_callback(state->reporter, *pCallback, pCreateInfo);
    if (result != VK_SUCCESS) {
        state->vk.DestroyDebugReportCallbackEXT(instance, *pCallback, pAllocator);
        *pCallback = VK_NULL_HANDLE;
    }
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyDebugReportCallbackEXT(
    VkInstance instance, VkDebugReportCallbackEXT callback, const VkAllocationCallbacks *pAllocator)
{
    struct layer_instance *state = layer_find_instance(instance);
    reporter_remove_report_callback(state->reporter, callback);
    if (state->vk.DestroyDebugReportCallbackEXT)
        state->vk.DestroyDebugReportCallbackEXT(instance, callback, pAllocator);
}

/* ---- names */

VKAPI_ATTR VkResult VKAPI_CALL
assay_SetDebugUtilsObjectNameEXT(VkDevice device, const VkDebugUtilsObjectNameInfoEXT *pNameInfo)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = VK_SUCCESS;
    if (state->vk.SetDebugUtilsObjectNameEXT)
        result = state->vk.SetDebugUtilsObjectNameEXT(device, pNameInfo);
    if (result == VK_SUCCESS)
        object_names_set(state->names, pNameInfo->objectType, pNameInfo->objectHandle,
                         pNameInfo->pObjectName);
    return result;
}

/* The two enumerations of object types have the same values for all types that messages name. */
VKAPI_ATTR VkResult VKAPI_CALL
assay_DebugMarkerSetObjectNameEXT(VkDevice device, const VkDebugMarkerObjectNameInfoEXT *pNameInfo)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = VK_SUCCESS;
    if (state->vk.DebugMarkerSetObjectNameEXT)
        result = state->vk.DebugMarkerSetObjectNameEXT(device, pNameInfo);
    if (result == VK_SUCCESS)
        object_names_set(state->names, (VkObjectType)pNameInfo->objectType, pNameInfo->object,
                         pNameInfo->pObjectName);
    return result;
}

/* ---- labels of command buffers */

static void open_label(struct layer_device *state, VkCommandBuffer command_buffer,
                       const VkDebugUtilsLabelEXT *label)
{
    struct label_stack *labels = command_buffers_labels(state->command_buffers, command_buffer);
    if (labels)
        label_stack_push(labels, label);
}

static void close_label(struct layer_device *state, VkCommandBuffer command_buffer)
{
    struct label_stack *labels = command_buffers_labels(state->command_buffers, command_buffer);
    if (labels)
        label_stack_pop(labels);
}

static void insert_label(struct layer_device *state, VkCommandBuffer command_buffer,
                         const VkDebugUtilsLabelEXT *label)
{
    struct label_stack *labels = command_buffers_labels(state->command_buffers, command_buffer);
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

VKAPI_ATTR void VKAPI_CALL assay_CmdBeginDebugUtilsLabelEXT(VkCommandBuffer commandBuffer,
                                                            const VkDebugUtilsLabelEXT *pLabelInfo)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    open_label(state, commandBuffer, pLabelInfo);
    if (state->vk.CmdBeginDebugUtilsLabelEXT)
        state->vk.CmdBeginDebugUtilsLabelEXT(commandBuffer, pLabelInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdEndDebugUtilsLabelEXT(VkCommandBuffer commandBuffer)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    close_label(state, commandBuffer);
    if (state->vk.CmdEndDebugUtilsLabelEXT)
        state->vk.CmdEndDebugUtilsLabelEXT(commandBuffer);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdInsertDebugUtilsLabelEXT(VkCommandBuffer commandBuffer,
                                                             const VkDebugUtilsLabelEXT *pLabelInfo)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    insert_label(state, commandBuffer, pLabelInfo);
    if (state->vk.CmdInsertDebugUtilsLabelEXT)
        state->vk.CmdInsertDebugUtilsLabelEXT(commandBuffer, pLabelInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdDebugMarkerBeginEXT(
    VkCommandBuffer commandBuffer, const VkDebugMarkerMarkerInfoEXT *pMarkerInfo)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    VkDebugUtilsLabelEXT label = label_of_marker(pMarkerInfo);
    open_label(state, commandBuffer, &label);
    if (state->vk.CmdDebugMarkerBeginEXT)
        state->vk.CmdDebugMarkerBeginEXT(commandBuffer, pMarkerInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdDebugMarkerEndEXT(VkCommandBuffer commandBuffer)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    close_label(state, commandBuffer);
    if (state->vk.CmdDebugMarkerEndEXT)
        state->vk.CmdDebugMarkerEndEXT(commandBuffer);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdDebugMarkerInsertEXT(
    VkCommandBuffer commandBuffer, const VkDebugMarkerMarkerInfoEXT *pMarkerInfo)
{
    struct layer_device *state = layer_find_recording_device(commandBuffer);
    if (!state)
        return;
    VkDebugUtilsLabelEXT label = label_of_marker(pMarkerInfo);
    insert_label(state, commandBuffer, &label);
    if (state->vk.CmdDebugMarkerInsertEXT)
        state->vk.CmdDebugMarkerInsertEXT(commandBuffer, pMarkerInfo);
}

/* ---- labels of queues */

VKAPI_ATTR void VKAPI_CALL
assay_QueueBeginDebugUtilsLabelEXT(VkQueue queue, const VkDebugUtilsLabelEXT *pLabelInfo)
{
    struct layer_device *state = layer_find_device(queue);
    queue_labels_push(state->queue_labels, queue, pLabelInfo);
    if (state->vk.QueueBeginDebugUtilsLabelEXT)
        state->vk.QueueBeginDebugUtilsLabelEXT(queue, pLabelInfo);
}

VKAPI_ATTR void VKAPI_CALL assay_QueueEndDebugUtilsLabelEXT(VkQueue queue)
{
    struct layer_device *state = layer_find_device(queue);
    queue_labels_pop(state->queue_labels, queue);
    if (state->vk.QueueEndDebugUtilsLabelEXT)
        state->vk.QueueEndDebugUtilsLabelEXT(queue);
}

VKAPI_ATTR void VKAPI_CALL
assay_QueueInsertDebugUtilsLabelEXT(VkQueue queue, const VkDebugUtilsLabelEXT *pLabelInfo)
{
    struct layer_device *state = layer_find_device(queue);
    queue_labels_insert(state->queue_labels, queue, pLabelInfo);
    if (state->vk.QueueInsertDebugUtilsLabelEXT)
        state->vk.QueueInsertDebugUtilsLabelEXT(queue, pLabelInfo);
}
