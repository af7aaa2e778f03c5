/* SPDX-License-Identifier: Apache-2.0 */
/* The scratch memory of host builds: the application's if it is writable and no other running build
 * uses a part of it; otherwise the backend's own. */
#ifndef ASSAY_CPU_SCRATCH_H
#define ASSAY_CPU_SCRATCH_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/platform/threads.h"

/* Scratch sizes that the backend returns are this much larger than the builder needs, so that the
 * backend can align the scratch. In bytes. */
#define CPU_SCRATCH_SLACK 63u

/* The scratch memory that is in use. */
struct cpu_scratch_claims {
    pthread_mutex_t lock; /* only held for look-ups */
    struct cpu_scratch *first;
};

void cpu_scratch_claims_init(struct cpu_scratch_claims *claims);
void cpu_scratch_claims_release(struct cpu_scratch_claims *claims);

struct cpu_scratch {
    void *bytes; /* aligned for the builder */
    uint64_t size;
    void *owned; /* the backend's own memory, or NULL */
    struct cpu_scratch_claims *claims;
    struct cpu_scratch *next;
};

/* `given`: the application's size + CPU_SCRATCH_SLACK bytes, or NULL. Fails only if memory runs
 * out. `*scratch` must not move until it is returned. */
VkResult cpu_scratch_take(struct cpu_scratch_claims *claims, void *given, uint64_t size,
                          struct cpu_scratch *scratch);
void cpu_scratch_return(struct cpu_scratch *scratch);

#endif
