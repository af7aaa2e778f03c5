/* SPDX-License-Identifier: Apache-2.0 */
/* Finds settings that have no effect beside others. */
#include "src/report/settings_check.h"

#include "src/base/text_buffer.h"

enum { LINE_SIZE = 1024, VALUE_SHOWN = 200 };

struct checker {
    void (*warn)(void *context, const char *line);
    void *context;
    struct settings *settings;
};

/* Rays compare the driver's structures with structures built from the inputs that level content
 * reads. */
static void check_compare_rays(const struct checker *checker)
{
    struct settings *settings = checker->settings;
    if (!settings->compare_rays ||
        (settings->level == LEVEL_CONTENT && settings->backend == BACKEND_DRIVER))
        return;
    settings->compare_rays = 0;
    checker->warn(checker->context,
                  "assay_validation.compare_rays needs level = content and backend = driver. No "
                  "rays are compared.");
}

/* The file would look as if there were no messages. */
static void check_log_filename(const struct checker *checker)
{
    const struct settings *settings = checker->settings;
    if (!settings->log_filename ||
        settings->debug_action & (DEBUG_ACTION_LOG | DEBUG_ACTION_DEFAULT))
        return;
    char line[LINE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text, "assay_validation.log_filename: nothing is written to ");
    text_append_quoted(&text, settings->log_filename, VALUE_SHOWN);
    text_append(&text, ", because debug_action has neither log nor default.");
    checker->warn(checker->context, line);
}

/* Journals, which list the builds of command buffers, begin at level execution. */
static void check_record_builds(const struct checker *checker)
{
    struct settings *settings = checker->settings;
    if (!settings->record_builds ||
        (settings->level >= LEVEL_EXECUTION && settings->log_format == LOG_FORMAT_JSON &&
         settings->debug_action & (DEBUG_ACTION_LOG | DEBUG_ACTION_DEFAULT)))
        return;
    settings->record_builds = false;
    checker->warn(checker->context,
                  "assay_validation.record_builds needs level = execution or content, log_format = "
                  "json, and a debug_action that logs. No builds are recorded.");
}

/* Journals, which hold what is to be ordered, begin at level execution. */
static void check_hazards(const struct checker *checker)
{
    struct settings *settings = checker->settings;
    if (!settings->hazards || settings->level >= LEVEL_EXECUTION)
        return;
    settings->hazards = false;
    checker->warn(checker->context,
                  "assay_validation.hazards needs level = execution or content. No hazards are "
                  "reported.");
}

/* Guarded builds need what level content records. */
static void check_guard(const struct checker *checker)
{
    struct settings *settings = checker->settings;
    if (settings->guard == GUARD_OFF ||
        (settings->level == LEVEL_CONTENT && settings->backend == BACKEND_DRIVER))
        return;
    settings->guard = GUARD_OFF;
    checker->warn(
        checker->context,
        "assay_validation.guard needs level = content and backend = driver. No builds are "
        "guarded.");
}

void settings_check(struct settings *settings, void (*warn)(void *context, const char *line),
                    void *context)
{
    const struct checker checker = {warn, context, settings};
    check_compare_rays(&checker);
    check_guard(&checker);
    check_hazards(&checker);
    check_log_filename(&checker);
    check_record_builds(&checker);
}
