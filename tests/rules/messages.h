/* SPDX-License-Identifier: Apache-2.0 */
/* What the layer said: a debug messenger that keeps every validation message. Messages may arrive
 * from several threads; all else is for when none does. */
#ifndef RULES_MESSAGES_H
#define RULES_MESSAGES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

enum { MESSAGES_MAX = 512, MESSAGE_ID_MAX = 128, MESSAGE_TEXT_MAX = 1024 };

struct message {
    char id[MESSAGE_ID_MAX]; /* "" where there was none */
    char text[MESSAGE_TEXT_MAX];
};

struct messages {
    uint32_t count; /* of all that came; those beyond MESSAGES_MAX are not kept */
    struct message items[MESSAGES_MAX];
    VkBool32 answer; /* what the callback returns */
};

/* The create info of a messenger that writes to `messages`. */
VkDebugUtilsMessengerCreateInfoEXT messages_messenger(struct messages *messages);

void messages_clear(struct messages *messages);

/* In the child of a fork: another thread may have been in a callback. */
void messages_after_fork(void);

uint32_t messages_kept(const struct messages *messages);

/* How many kept messages have this id; if `text` is not NULL, of those that contain it. */
uint32_t messages_count(const struct messages *messages, const char *id, const char *text);

#endif
