/* SPDX-License-Identifier: Apache-2.0 */
/* The settings of one instance, from the environment (VK_ASSAY_VALIDATION_KEY),
 * vk_layer_settings.txt (assay_validation.KEY) and VK_EXT_layer_settings. */
#ifndef ASSAY_REPORT_SETTINGS_H
#define ASSAY_REPORT_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/report/ids/message_id.h"
#include "src/report/settings/reported_lines.h"
#include "vuid-tables/advice.h"
#include "vuid-tables/rules.h"

/* enum backend_setting and others: the values of settings, as settings.def says what they mean. */
enum no_setting {
    NO_SETTING,
#define CHOICE(key, ...)                                                                           \
    }                                                                                              \
    ;                                                                                              \
    enum key##_setting                                                                             \
    {
#define VALUE(key, constant, ...) constant,
#include "src/report/settings.def"
};

/* What to do with a message. Every action but IGNORE calls the application's messengers. */
enum debug_action {
    DEBUG_ACTION_IGNORE = 1 << 0,   /* nothing; never set together with others */
    DEBUG_ACTION_CALLBACK = 1 << 1, /* only call the messengers */
    DEBUG_ACTION_LOG = 1 << 2,      /* also log to log_filename */
    DEBUG_ACTION_BREAK = 1 << 3,    /* also raise SIGTRAP after an error */
    DEBUG_ACTION_DEFAULT = 1 << 4,  /* also log if no messenger got the message, or to a file */
    DEBUG_ACTION_FAIL = 1 << 5,     /* also skip a call that has an error */
    /* Windows: also write to the debugger's output, as DEFAULT does if no messenger got the
     * message. */
    DEBUG_ACTION_DEBUGGER = 1 << 6,
};

enum report_flag {
    REPORT_ERROR = 1 << 0,
    REPORT_WARNING = 1 << 1,
    REPORT_INFO = 1 << 2,
    REPORT_PERFORMANCE = 1 << 3, /* advice about waste; also sent with REPORT_WARNING */
};

struct narrow_filter; /* src/report/ids/message_filter.h */

enum setting {
#define CHOICE(key, ...) SETTING_##key,
#define CHOICE_OF(key, ...) SETTING_##key,
#define FLAGS(key, ...) SETTING_##key,
#define SWITCH(key, ...) SETTING_##key,
#define NUMBER(key, ...) SETTING_##key,
#define OWN(key, ...) SETTING_##key,
#include "src/report/settings.def"
    SETTING_COUNT,
};

struct settings {
#define CHOICE(key, ...) enum key##_setting key;
#define CHOICE_OF(key, type, ...) type key;
#define FLAGS(key, ...) uint32_t key;
#define SWITCH(key, ...) bool key;
#define NUMBER(key, ...) uint32_t key;
#include "src/report/settings.def"
    char *log_filename;  /* NULL: stderr; owned */
    const char *capture; /* NULL: off; one of `values` */
    struct capture_point {
        enum { AT_ANY_POINT, AT_FRAME, AT_SUBMISSION, AT_LABEL } kind;
        uint64_t number;
        const char *label; /* a part of `values` */
    } capture_from, capture_until;
    struct advice_limits advice_limits;
    bool muted[MESSAGE_ID_COUNT];         /* message_id_filter: VUIDs */
    bool muted_others[OTHER_ID_COUNT];    /* message_id_filter: other ids */
    struct narrow_filter *narrow_filters; /* message_id_filter: ID@GLOB; owned list */
    /* The settings that differ from the defaults, and where each came from; owned. NULL: there are
     * none, report_flags lacks REPORT_INFO, or memory ran out. */
    char *changes;
    char *values[SETTING_COUNT];   /* as given; NULL: not; owned */
    bool by_preset[SETTING_COUNT]; /* its value is the preset's */
    bool is_given[SETTING_COUNT];  /* by the application, the environment or the file */
};

/* Reads the settings of an instance that is about to be created. An unknown key or an invalid value
 * falls back to the default and adds one line to `warnings`. Fails only if memory runs out. The
 * caller releases `settings` with settings_release, and calls settings_check. */
VkResult settings_load(const VkInstanceCreateInfo *create_info, struct kept_lines *warnings,
                       struct settings *settings);
void settings_release(struct settings *settings);
/* Clears the members that refer to memory, for a copy of settings that another owns. */
void settings_disown(struct settings *settings);

/* Calls `each` for every setting, with its value as text. */
void settings_each(const struct settings *settings,
                   void (*each)(void *context, const char *key, const char *value), void *context);

/* Turns each setting off that has no effect beside the others. Adds one line to `warnings` for it,
 * unless the preset has set it. */
void settings_check(struct settings *settings, struct kept_lines *warnings);

#endif
