/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of the command that runs a shader. */
#ifndef ASSAY_SHADERS_LAUNCH_H
#define ASSAY_SHADERS_LAUNCH_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

enum { PUSHED_BYTES = 256 }; /* push constants behind them are unknown */

/* The push constants of a command. */
struct pushed_constants {
    uint32_t words[PUSHED_BYTES / 4];
    uint64_t known; /* a bit for each word */
};

struct shader_launch {
    const VkSpecializationInfo *constants; /* may be NULL */
    const struct pushed_constants *pushed; /* NULL: unknown */
    uint32_t size[3]; /* workgroups of a dispatch, or the size of a trace; 0: unknown */
    uint32_t base[3]; /* the first workgroup */
};

#endif
