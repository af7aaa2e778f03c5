/* SPDX-License-Identifier: Apache-2.0 */
/* What the code of a shader says of ray tracing. */
#ifndef ASSAY_VIEW_SHADER_CODE_H
#define ASSAY_VIEW_SHADER_CODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Whether a module of SPIR-V declares a capability of ray tracing. `size`: in bytes. Returns false
 * if the code is not readable. */
bool shader_code_traces(const uint32_t *code, size_t size);

#endif
