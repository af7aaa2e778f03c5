/* SPDX-License-Identifier: Apache-2.0 */
/* The debug messenger of the cases. */
#include "messages.h"
#include "tests/fixture/make.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

static pthread_mutex_t arriving = PTHREAD_MUTEX_INITIALIZER;

/* The loader and drivers speak through the same messengers; only the layer validates, or has ids of
 * its own. */
static bool is_of_the_layer(VkDebugUtilsMessageTypeFlagsEXT types, const char *id)
{
    return (types & VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT) != 0 ||
           (id != NULL && (strstr(id, "ssay") != NULL || strncmp(id, "ASSAY-", 6) == 0));
}

static VKAPI_ATTR VkBool32 VKAPI_CALL message_arrives(
    VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT types,
    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user_data)
{
    struct messages *messages = user_data;
    (void)severity;

    if (!is_of_the_layer(types, data->pMessageIdName))
        return VK_FALSE;
    pthread_mutex_lock(&arriving);
    if (messages->count < MESSAGES_MAX) {
        struct message *message = &messages->items[messages->count];
        snprintf(message->id, sizeof(message->id), "%s",
                 data->pMessageIdName != NULL ? data->pMessageIdName : "");
        snprintf(message->text, sizeof(message->text), "%s",
                 data->pMessage != NULL ? data->pMessage : "");
    }
    messages->count++;
    const VkBool32 answer = messages->answer;
    pthread_mutex_unlock(&arriving);
    return answer;
}

VkDebugUtilsMessengerCreateInfoEXT messages_messenger(struct messages *messages)
{
    return MAKE(VkDebugUtilsMessengerCreateInfoEXT,
                .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                   VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                               VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                               VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
                .pfnUserCallback = message_arrives, .pUserData = messages);
}

void messages_clear(struct messages *messages)
{
    messages->count = 0;
}

void messages_after_fork(void)
{
    pthread_mutex_init(&arriving, NULL);
}

uint32_t messages_kept(const struct messages *messages)
{
    return messages->count < MESSAGES_MAX ? messages->count : MESSAGES_MAX;
}

uint32_t messages_count(const struct messages *messages, const char *id, const char *text)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        const struct message *message = &messages->items[i];
        if (strcmp(message->id, id) == 0 && (text == NULL || strstr(message->text, text) != NULL))
            count++;
    }
    return count;
}
