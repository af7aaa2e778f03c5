/* SPDX-License-Identifier: Apache-2.0 */
/* What the validation layer says in the debug callback, kept to be counted and compared. */
#ifndef DEMO_FINDINGS_H
#define DEMO_FINDINGS_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

#include "tests/fixture/make.h"

#define FINDINGS_KEPT                                                                              \
    32 /* a planted mistake yields one or two; beyond this they are only counted */

struct finding {
    char *id; /* the VUID */
    char *text;
};

/* Written by the callback, on the thread that makes the call; the demo has one thread. */
struct findings {
    uint32_t clean_count; /* arrived while nothing was planted; printed on arrival, not kept */
    /* While this is set, what arrives is kept, and the callback asks for the call to be skipped, so
     * that the driver never sees the mistake. */
    bool planted;
    uint32_t count;
    struct finding kept[FINDINGS_KEPT];
};

/* Forget what is kept. */
void findings_clear(struct findings *findings);
bool findings_have(const struct findings *findings, const char *vuid);

/* A messenger for validation warnings and errors, to chain to VkInstanceCreateInfo as well. */
VkDebugUtilsMessengerCreateInfoEXT findings_messenger(struct findings *findings);

/* Ends the process if the layer that should find mistakes is not loaded. */
void findings_require_layer(void);

/* Print a text of several lines, each behind `margin`. */
void findings_print(const char *text, const char *margin);

#endif
