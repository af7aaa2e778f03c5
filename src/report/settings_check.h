/* SPDX-License-Identifier: Apache-2.0 */
/* Settings that have no effect beside others. */
#ifndef ASSAY_REPORT_SETTINGS_CHECK_H
#define ASSAY_REPORT_SETTINGS_CHECK_H

#include "src/report/settings.h"

/* Calls `warn` with one line for each setting that has no effect, and turns it off. */
void settings_check(struct settings *settings, void (*warn)(void *context, const char *line),
                    void *context);

#endif
