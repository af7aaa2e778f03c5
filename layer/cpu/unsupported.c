/* SPDX-License-Identifier: Apache-2.0 */
/* Words the reports of what cannot work. */
#include "layer/cpu/unsupported.h"

#include "src/base/text_buffer.h"

void cpu_report_unsupported(const struct layer_instance *instance, const char *command,
                            const char *what)
{
    char line[512];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text,
                "%s(): %s cannot work, because assay_validation.backend is cpu: acceleration "
                "structures are built on the host, where shaders do not reach them. The driver's "
                "ray tracing needs assay_validation.backend = driver.",
                command, what);
    reporter_report_unsupported(instance->reporter, line);
}
