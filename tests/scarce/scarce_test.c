/* SPDX-License-Identifier: Apache-2.0 */
/* The life of an application with many objects (application_parts.h), with memory running out. */
#include <stdio.h>
#include <stdlib.h>

#include "application_parts.h"
#include "lives.h"

static const char *live(bool is_scarce)
{
    application_live();
    if (!outcome.wrong[0] && !is_scarce && outcome.found != outcome.expected)
        snprintf(outcome.wrong, sizeof(outcome.wrong), "%u of %u were found", outcome.found,
                 outcome.expected);
    return outcome.wrong;
}

int main(void)
{
    setenv("VK_DRIVER_FILES", DRIVER_MANIFEST, 1);
    setenv("VK_LAYER_PATH", LAYER_FOLDER, 1);
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error,warn", 1);
    setenv("VK_ASSAY_VALIDATION_BACKEND", "cpu", 1);
    setenv("VK_ASSAY_VALIDATION_LEVEL", "execution", 1);
    lives_open();
    lives_play("an application", live);
    return lives_close(100);
}
