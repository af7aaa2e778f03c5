/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the code of a shader needs ray tracing: what backend cpu keeps from the driver. */
#ifndef ASSAY_VIEW_SHADER_CODE_H
#define ASSAY_VIEW_SHADER_CODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* Whether a module of SPIR-V declares a capability of ray tracing. `size`: in bytes. Returns false
 * if the code is not readable. */
bool shader_code_traces(const uint32_t *code, size_t size);

/* The same for the code in the chain of a stage, which a stage without a module may have. */
bool shader_stage_traces(const VkPipelineShaderStageCreateInfo *stage);

#endif
