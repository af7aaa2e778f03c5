/* SPDX-License-Identifier: Apache-2.0 */
/* What cannot work on backend cpu: shaders reach no structure that is built on the host. */
#ifndef ASSAY_LAYER_CPU_UNSUPPORTED_H
#define ASSAY_LAYER_CPU_UNSUPPORTED_H

#include "layer/layer.h"

/* Tells the application that a command cannot do what is asked of it, and which setting brings
 * that: "vkCommand(): WHAT ...". */
void cpu_report_unsupported(const struct layer_instance *instance, const char *command,
                            const char *what);

#endif
