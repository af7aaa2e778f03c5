/* SPDX-License-Identifier: Apache-2.0 */
/* The application's debug callbacks, of VK_EXT_debug_utils and of VK_EXT_debug_report.
 *
 * Thread-safe. A call works on a list that stays as it is until the call is through: adding makes a
 * new list, and removing marks an entry, so that it cannot fail. The lock guards which list is the
 * current one and how many use each; it is never held during a callback. */
#ifndef ASSAY_REPORT_MESSENGERS_H
#define ASSAY_REPORT_MESSENGERS_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <vulkan/vulkan_core.h>

struct message;
struct messenger_list;

struct messengers {
    pthread_mutex_t lock;
    struct messenger_list *current; /* NULL: none */
    atomic_bool instance_alive;     /* messengers of the instance's create info are silent */
};

void messengers_init(struct messengers *messengers);
void messengers_destroy(struct messengers *messengers);

/* Those in the pNext chain of VkInstanceCreateInfo. */
VkResult messengers_add_chain(struct messengers *messengers, const void *chain);

VkResult messengers_add(struct messengers *messengers, VkDebugUtilsMessengerEXT handle,
                        const VkDebugUtilsMessengerCreateInfoEXT *create_info);
VkResult messengers_add_report_callback(struct messengers *messengers,
                                        VkDebugReportCallbackEXT handle,
                                        const VkDebugReportCallbackCreateInfoEXT *create_info);
void messengers_remove(struct messengers *messengers, VkObjectType type, uint64_t handle);

/* Calls all that listen to messages of this severity. `heard` tells whether there was one; returns
 * true if one asked to skip the call. */
bool messengers_call(struct messengers *messengers, const struct message *message, bool *heard);

#endif
