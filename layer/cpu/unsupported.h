/* SPDX-License-Identifier: Apache-2.0 */
/* Reports commands that cannot work on backend cpu: shaders cannot access a structure that is built
 * on the host. */
#ifndef ASSAY_LAYER_CPU_UNSUPPORTED_H
#define ASSAY_LAYER_CPU_UNSUPPORTED_H

#include "layer/layer.h"

/* Reports that a command cannot do what the application requests, and names the setting that causes
 * it: "vkCommand(): WHAT ...". */
void cpu_report_unsupported(const struct layer_instance *instance, const char *command,
                            const char *what);

#endif
