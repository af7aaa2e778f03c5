/* SPDX-License-Identifier: Apache-2.0 */
/* The application's debug callbacks of VK_EXT_debug_utils and VK_EXT_debug_report.
 *
 * Thread-safe. messengers_call uses a list that does not change during the call: adding makes a new
 * list, and removing marks an entry, so removing cannot fail. The lock guards the pointer to the
 * current list and the use counts of all lists. It is never held during a callback. */
#ifndef ASSAY_REPORT_MESSENGERS_H
#define ASSAY_REPORT_MESSENGERS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <vulkan/vulkan_core.h>

#include "src/platform/threads.h"

struct message;
struct messenger_list;

struct messengers {
    pthread_mutex_t lock;
    struct messenger_list *current; /* NULL: none */
    atomic_bool instance_alive;     /* true: messengers of the instance's create info are silent */
};

void messengers_init(struct messengers *messengers);
void messengers_destroy(struct messengers *messengers);

/* Adds the messengers in the pNext chain of VkInstanceCreateInfo. */
VkResult messengers_add_chain(struct messengers *messengers, const void *chain);

VkResult messengers_add(struct messengers *messengers, VkDebugUtilsMessengerEXT handle,
                        const VkDebugUtilsMessengerCreateInfoEXT *create_info);
VkResult messengers_add_report_callback(struct messengers *messengers,
                                        VkDebugReportCallbackEXT handle,
                                        const VkDebugReportCallbackCreateInfoEXT *create_info);
void messengers_remove(struct messengers *messengers, VkObjectType type, uint64_t handle);

/* Calls all messengers for messages of this severity. Sets `delivered` if there is one. Returns
 * true if a callback returned VK_TRUE, which means to skip the call. */
bool messengers_call(struct messengers *messengers, const struct message *message, bool *delivered);

#endif
