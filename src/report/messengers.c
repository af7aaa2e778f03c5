/* SPDX-License-Identifier: Apache-2.0 */
/* The list of messengers, and calls to them. */
#include "src/report/messengers.h"

#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

#include "src/report/message.h"

/* Constant within a list, except `removed`. */
struct messenger {
    VkObjectType type; /* VK_OBJECT_TYPE_DEBUG_UTILS_MESSENGER_EXT or ..._REPORT_CALLBACK_EXT */
    uint64_t handle;
    bool of_create_info;
    atomic_bool removed;
    VkDebugUtilsMessageSeverityFlagsEXT severities;
    VkDebugUtilsMessageTypeFlagsEXT types;
    VkDebugReportFlagsEXT report_flags;
    PFN_vkDebugUtilsMessengerCallbackEXT call;
    PFN_vkDebugReportCallbackEXT call_report;
    void *user_data;
};

struct messenger_list {
    unsigned users; /* calls under way, plus one if current; guarded by the lock */
    uint32_t count;
    struct messenger entries[];
};

void messengers_init(struct messengers *messengers)
{
    pthread_mutex_init(&messengers->lock, NULL);
    messengers->current = NULL;
    atomic_init(&messengers->instance_alive, false);
}

void messengers_destroy(struct messengers *messengers)
{
    free(messengers->current);
    pthread_mutex_destroy(&messengers->lock);
}

static void release_messengers(struct messenger_list *list)
{
    if (list && --list->users == 0)
        free(list);
}

static void copy_entry(struct messenger *to, const struct messenger *from)
{
    *to = (struct messenger){
        .type = from->type,
        .handle = from->handle,
        .of_create_info = from->of_create_info,
        .severities = from->severities,
        .types = from->types,
        .report_flags = from->report_flags,
        .call = from->call,
        .call_report = from->call_report,
        .user_data = from->user_data,
    };
}

/* Replaces the current list with a new one: the entries that are not removed, and `added`. */
static VkResult add_messenger(struct messengers *messengers, const struct messenger *added)
{
    pthread_mutex_lock(&messengers->lock);
    struct messenger_list *old = messengers->current;
    uint32_t old_count = old ? old->count : 0;
    struct messenger_list *list =
        malloc(sizeof(*list) + (old_count + 1) * sizeof(list->entries[0]));
    if (list) {
        list->users = 1;
        list->count = 0;
        for (uint32_t i = 0; i < old_count; i++)
            if (!atomic_load_explicit(&old->entries[i].removed, memory_order_relaxed))
                copy_entry(&list->entries[list->count++], &old->entries[i]);
        copy_entry(&list->entries[list->count++], added);
        messengers->current = list;
        release_messengers(old);
    }
    pthread_mutex_unlock(&messengers->lock);
    return list ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

static VkResult add_utils(struct messengers *messengers, VkDebugUtilsMessengerEXT handle,
                          const VkDebugUtilsMessengerCreateInfoEXT *info, bool of_create_info)
{
    if (!info->pfnUserCallback ||
        !(info->messageType & (VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                               VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT)))
        return VK_SUCCESS; /* it would never be called */
    return add_messenger(messengers, &(struct messenger){
                                         .type = VK_OBJECT_TYPE_DEBUG_UTILS_MESSENGER_EXT,
                                         .handle = (uint64_t)handle,
                                         .of_create_info = of_create_info,
                                         .severities = info->messageSeverity,
                                         .types = info->messageType,
                                         .call = info->pfnUserCallback,
                                         .user_data = info->pUserData,
                                     });
}

static VkResult add_report(struct messengers *messengers, VkDebugReportCallbackEXT handle,
                           const VkDebugReportCallbackCreateInfoEXT *info, bool of_create_info)
{
    if (!info->pfnCallback)
        return VK_SUCCESS;
    return add_messenger(messengers, &(struct messenger){
                                         .type = VK_OBJECT_TYPE_DEBUG_REPORT_CALLBACK_EXT,
                                         .handle = (uint64_t)handle,
                                         .of_create_info = of_create_info,
                                         .report_flags = info->flags,
                                         .call_report = info->pfnCallback,
                                         .user_data = info->pUserData,
                                     });
}

VkResult messengers_add_chain(struct messengers *messengers, const void *chain)
{
    VkResult result = VK_SUCCESS;
    for (const VkBaseInStructure *in = chain; in && result == VK_SUCCESS; in = in->pNext) {
        if (in->sType == VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT)
            result = add_utils(messengers, VK_NULL_HANDLE,
                               (const VkDebugUtilsMessengerCreateInfoEXT *)in, true);
        else if (in->sType == VK_STRUCTURE_TYPE_DEBUG_REPORT_CALLBACK_CREATE_INFO_EXT)
            result = add_report(messengers, VK_NULL_HANDLE,
                                (const VkDebugReportCallbackCreateInfoEXT *)in, true);
    }
    return result;
}

VkResult messengers_add(struct messengers *messengers, VkDebugUtilsMessengerEXT handle,
                        const VkDebugUtilsMessengerCreateInfoEXT *create_info)
{
    return add_utils(messengers, handle, create_info, false);
}

VkResult messengers_add_report_callback(struct messengers *messengers,
                                        VkDebugReportCallbackEXT handle,
                                        const VkDebugReportCallbackCreateInfoEXT *create_info)
{
    return add_report(messengers, handle, create_info, false);
}

void messengers_remove(struct messengers *messengers, VkObjectType type, uint64_t handle)
{
    pthread_mutex_lock(&messengers->lock);
    struct messenger_list *list = messengers->current;
    for (uint32_t i = 0; list && i < list->count; i++) {
        struct messenger *entry = &list->entries[i];
        if (!entry->of_create_info && entry->type == type && entry->handle == handle)
            atomic_store_explicit(&entry->removed, true, memory_order_relaxed);
    }
    pthread_mutex_unlock(&messengers->lock);
}

/* ---- calling */

static VkDebugUtilsMessageSeverityFlagBitsEXT utils_severity(enum report_flag severity)
{
    switch (severity) {
    case REPORT_ERROR:
        return VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    case REPORT_WARNING:
    case REPORT_PERFORMANCE:
        return VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    case REPORT_INFO:
        break;
    }
    return VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT;
}

static VkDebugUtilsMessageTypeFlagBitsEXT utils_type(enum report_flag severity)
{
    return severity == REPORT_PERFORMANCE ? VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT
                                          : VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
}

static VkDebugReportFlagBitsEXT report_severity(enum report_flag severity)
{
    switch (severity) {
    case REPORT_ERROR:
        return VK_DEBUG_REPORT_ERROR_BIT_EXT;
    case REPORT_WARNING:
        return VK_DEBUG_REPORT_WARNING_BIT_EXT;
    case REPORT_PERFORMANCE:
        return VK_DEBUG_REPORT_PERFORMANCE_WARNING_BIT_EXT;
    case REPORT_INFO:
        break;
    }
    return VK_DEBUG_REPORT_INFORMATION_BIT_EXT;
}

static bool is_called(const struct messengers *messengers, const struct messenger *messenger,
                      enum report_flag severity)
{
    if (atomic_load_explicit(&messenger->removed, memory_order_relaxed) ||
        (messenger->of_create_info &&
         atomic_load_explicit(&messengers->instance_alive, memory_order_relaxed)))
        return false;
    return (messenger->severities & (VkDebugUtilsMessageSeverityFlagsEXT)utils_severity(severity) &&
            messenger->types & (VkDebugUtilsMessageTypeFlagsEXT)utils_type(severity)) ||
           messenger->report_flags & (VkDebugReportFlagsEXT)report_severity(severity);
}

static VkBool32 call_utils(const struct messenger *messenger, const struct message *message)
{
    const VkDebugUtilsMessengerCallbackDataEXT data = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT,
        .pMessageIdName = message->id,
        .messageIdNumber = message->id_number,
        .pMessage = message->text,
        .queueLabelCount = message->queue_label_count,
        .pQueueLabels = message->queue_label_count ? message->queue_labels : NULL,
        .cmdBufLabelCount = message->label_count,
        .pCmdBufLabels = message->label_count ? message->labels : NULL,
        .objectCount = message->named.count,
        .pObjects = message->named.count ? message->named.objects : NULL,
    };
    return messenger->call(utils_severity(message->severity), utils_type(message->severity), &data,
                           messenger->user_data);
}

/* This callback has no parameter for the id, so it gets the heading with the text. The first object
 * is a command buffer or a device; both have the same value in both object type enumerations. */
static VkBool32 call_report(const struct messenger *messenger, const struct message *message)
{
    const VkDebugUtilsObjectNameInfoEXT *object = message->named.objects;
    return messenger->call_report(
        report_severity(message->severity),
        message->named.count ? (VkDebugReportObjectTypeEXT)object->objectType
                             : VK_DEBUG_REPORT_OBJECT_TYPE_UNKNOWN_EXT,
        message->named.count ? object->objectHandle : 0, 0, message->id_number, "Assay",
        message->heading, messenger->user_data);
}

bool messengers_call(struct messengers *messengers, const struct message *message, bool *delivered)
{
    *delivered = false;
    pthread_mutex_lock(&messengers->lock);
    struct messenger_list *list = messengers->current;
    if (list)
        list->users++;
    pthread_mutex_unlock(&messengers->lock);
    if (!list)
        return false;

    bool skip = false;
    for (uint32_t i = 0; i < list->count; i++) {
        const struct messenger *messenger = &list->entries[i];
        if (!is_called(messengers, messenger, message->severity))
            continue;
        *delivered = true;
        skip |= (messenger->call ? call_utils(messenger, message)
                                 : call_report(messenger, message)) != VK_FALSE;
    }

    pthread_mutex_lock(&messengers->lock);
    release_messengers(list);
    pthread_mutex_unlock(&messengers->lock);
    return skip;
}
