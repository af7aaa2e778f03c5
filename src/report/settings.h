/* SPDX-License-Identifier: Apache-2.0 */
/* The settings of one instance: assay_validation.KEY of vk_layer_settings.txt,
 * VK_EXT_layer_settings and VK_ASSAY_VALIDATION_KEY of the environment. */
#ifndef ASSAY_REPORT_SETTINGS_H
#define ASSAY_REPORT_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/report/difference.h"
#include "vuid-tables/rules.h"

/* What carries builds out. */
enum backend {
    BACKEND_DRIVER, /* the driver, after the checks */
    BACKEND_CPU,    /* the layer, which keeps acceleration structures from the driver */
};

/* What to do with a message. The application's messengers hear it, unless it is ignored. */
enum debug_action {
    DEBUG_ACTION_IGNORE = 1 << 0,   /* nothing at all; only set alone */
    DEBUG_ACTION_CALLBACK = 1 << 1, /* the application's messengers only */
    DEBUG_ACTION_LOG = 1 << 2,      /* log_filename, or stderr, as well */
    DEBUG_ACTION_BREAK = 1 << 3,    /* raise SIGTRAP after an error */
    DEBUG_ACTION_DEFAULT = 1 << 4,  /* log only what no messenger listens to */
};

enum report_flag {
    REPORT_ERROR = 1 << 0,
    REPORT_WARNING = 1 << 1,
    REPORT_INFO = 1 << 2,
};

/* What a build does whose data would be beyond content_budget_mib. */
enum content_when_full {
    CONTENT_WAIT, /* it waits for what is complete soon, and is left out where that doesn't help */
    CONTENT_SKIP, /* it is left out */
};

/* By which ids messages go where the registry has retired the one that states their condition. */
enum vuid_names {
    VUID_NAMES_CURRENT, /* today's */
    VUID_NAMES_LISTED,  /* the retired one */
};

struct settings {
    enum level level;
    enum backend backend;
    enum vuid_names vuid_names;
    uint32_t content_budget_mib; /* of what the layer copies of builds' data; backend driver */
    enum content_when_full content_when_full;
    uint32_t report_flags;            /* enum report_flag */
    uint32_t debug_action;            /* enum debug_action */
    char *log_filename;               /* NULL: stderr; owned */
    uint32_t duplicate_message_limit; /* per id; 0: no limit */
    bool muted[MESSAGE_ID_COUNT];     /* by message_id_filter, as are: */
    bool muted_differences[DIFFERENCE_COUNT];
    uint32_t compare_rays; /* a build; 0: none */
};

/* Reads them for an instance about to be created. A key or a value that isn't understood leaves the
 * default and is told through `warn`, one line each. Fails only without memory. */
VkResult settings_load(const VkInstanceCreateInfo *create_info,
                       void (*warn)(void *context, const char *line), void *context,
                       struct settings *settings);
void settings_release(struct settings *settings);

#endif
