/* SPDX-License-Identifier: Apache-2.0 */
/* What the code of a shader says of ray tracing. */
#ifndef ASSAY_VIEW_SHADER_CODE_H
#define ASSAY_VIEW_SHADER_CODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* Whether a module of SPIR-V declares a capability of ray tracing. `size`: in bytes. Returns false
 * if the code is not readable. */
bool shader_code_traces(const uint32_t *code, size_t size);

/* Whether the only shader of a module traces rays, as far as its capabilities say. */
bool shader_code_certainly_traces(const uint32_t *code, size_t size);

/* Whether a shader may trace a structure that it has by its address. Returns true if the code is
 * not readable. */
bool shader_code_traces_addresses(const uint32_t *code, size_t size);

/* Whether a shader may write memory through an address (SPIR-V storage class
 * PhysicalStorageBuffer). Returns true if the code is not readable. */
bool shader_code_stores(const uint32_t *code, size_t size);

/* The same for the code in the chain of a stage, which a stage without a module may have. */
bool shader_stage_traces(const VkPipelineShaderStageCreateInfo *stage);
bool shader_stage_certainly_traces(const VkPipelineShaderStageCreateInfo *stage);
bool shader_stage_traces_addresses(const VkPipelineShaderStageCreateInfo *stage);
/* Returns true for a stage without a module if its code is not in its chain. */
bool shader_stage_stores(const VkPipelineShaderStageCreateInfo *stage);

#endif
