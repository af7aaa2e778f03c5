/* SPDX-License-Identifier: Apache-2.0 */
/* Host-visible memory that the device copies inputs of builds to, and results from. Chunks that
 * come back are kept for the next recording. */
#ifndef ASSAY_LAYER_CPU_STAGING_H
#define ASSAY_LAYER_CPU_STAGING_H

#include "cpu/overlay.h"
#include "cpu/recording.h"

struct cpu_staging_chunk {
    struct cpu_chunk chunk; /* first */
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceAddress address;
    struct cpu_staging_chunk *next;
};

VkResult cpu_staging_create(struct layer_device *device, struct cpu_staging **staging);
void cpu_staging_destroy(struct cpu_staging *staging); /* NULL: nothing */

/* A chunk of at least `size` bytes, nothing of it used; NULL without memory of either kind. From
 * any thread, as is giving it back. */
struct cpu_staging_chunk *cpu_staging_take(struct cpu_staging *staging, uint64_t size);
void cpu_staging_give_back(struct cpu_staging *staging, struct cpu_staging_chunk *chunk);

#endif
