/* SPDX-License-Identifier: Apache-2.0 */
/* The settings of one instance, from the environment (VK_ASSAY_VALIDATION_KEY),
 * vk_layer_settings.txt (assay_validation.KEY) and VK_EXT_layer_settings. */
#ifndef ASSAY_REPORT_SETTINGS_H
#define ASSAY_REPORT_SETTINGS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/report/ids/message_id.h"
#include "vuid-tables/advice.h"
#include "vuid-tables/rules.h"

/* Who executes builds. */
enum backend {
    BACKEND_DRIVER, /* the driver, after validation */
    BACKEND_CPU,    /* the layer; the driver never gets acceleration structures */
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

/* What to do if the copies of a build's inputs would exceed content_budget_mib. */
enum content_when_full {
    CONTENT_WAIT, /* wait until pending builds free memory; skip if that does not suffice */
    CONTENT_SKIP, /* leave the build unchecked */
};

/* Which id a message has if the registry has replaced the id of its condition. */
enum vuid_names {
    VUID_NAMES_CURRENT, /* the current id */
    VUID_NAMES_LISTED,  /* the retired id */
};

/* How much of the specification's sentence a message quotes. */
enum spec_text {
    SPEC_TEXT_FULL,  /* the sentence and a link to it */
    SPEC_TEXT_SHORT, /* at most 160 characters of the sentence, and the link */
    SPEC_TEXT_NONE,  /* neither */
};

/* What the builds of top-level structures read. */
enum guard_setting {
    GUARD_OFF,        /* the application's instances */
    GUARD_REFERENCES, /* copies, without references to structures that are not live */
};

/* Which limits and sizes the layer reports to the application, and checks by. */
enum limits_setting {
    LIMITS_DRIVER, /* the driver's */
    LIMITS_HARSH,  /* src/state/builds/harsh.h */
};

enum log_format {
    LOG_FORMAT_TEXT,
    LOG_FORMAT_JSON, /* one line for each message: json/findings.schema.json */
};

/* How the layer finds from where a build command is called. */
enum call_site_mode {
    CALL_SITES_OFF,
    CALL_SITES_FRAMES, /* by frame pointers */
    CALL_SITES_FULL,   /* by unwinding tables */
};

struct narrow_filter; /* src/report/ids/message_filter.h */

struct settings {
    enum level level;
    enum backend backend;
    enum limits_setting limits;
    enum vuid_names vuid_names;
    enum spec_text spec_text;
    uint32_t content_budget_mib; /* MiB for copies of builds' inputs; backend driver */
    enum content_when_full content_when_full;
    enum guard_setting guard;
    uint32_t hang_seconds; /* without progress, before a wait reports; level content; 0: never */
    bool crash_report;     /* report when the process gets a signal that ends it */
    uint32_t report_flags; /* enum report_flag */
    uint32_t debug_action; /* enum debug_action */
    char *log_filename;    /* NULL: stderr; owned */
    enum log_format log_format;
    enum call_site_mode call_sites;
    bool hazards; /* report accesses that no barrier orders */
    bool advice;  /* list what the application wastes */
    struct advice_limits advice_limits;
    bool record_builds; /* the log also has a line for each build, copy and submission */
    uint32_t duplicate_message_limit;     /* per id and object; 0: no limit */
    bool muted[MESSAGE_ID_COUNT];         /* message_id_filter: VUIDs */
    bool muted_others[OTHER_ID_COUNT];    /* message_id_filter: other ids */
    struct narrow_filter *narrow_filters; /* message_id_filter: ID@GLOB; owned list */
    uint32_t compare_rays;                /* rays per build; 0: none */
    /* The settings that differ from the defaults, and where each came from; owned. NULL: there are
     * none, report_flags lacks REPORT_INFO, or memory ran out. */
    char *changes;
    char **values;      /* by key; the settings own the array and its strings */
    uint32_t by_preset; /* a bit for each key: its value is the preset's */
};

/* Reads the settings of an instance that is about to be created. An unknown key or an invalid value
 * falls back to the default and calls `warn` with one line. Fails only if memory runs out. The
 * caller releases `settings` with settings_release, and calls settings_check. */
VkResult settings_load(const VkInstanceCreateInfo *create_info,
                       void (*warn)(void *context, const char *line), void *context,
                       struct settings *settings);
void settings_release(struct settings *settings);
/* Clears the members that refer to memory, for a copy of settings that another owns. */
void settings_disown(struct settings *settings);

/* Calls `each` for every setting, with its value as text. */
void settings_each(const struct settings *settings,
                   void (*each)(void *context, const char *key, const char *value), void *context);

/* ---- settings that have no effect beside others */

/* Returns whether the preset has set a key, which then counts as not set. */
bool settings_leave_out(struct settings *settings, const char *key);

/* Turns each setting off that has no effect. Calls `warn` with one line for it, unless the preset
 * has set it. */
void settings_check(struct settings *settings, void (*warn)(void *context, const char *line),
                    void *context);

#endif
