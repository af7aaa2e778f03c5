/* SPDX-License-Identifier: Apache-2.0 */
/* The scratch of host builds: the application's where it can be written and no other build that
 * runs has any of it, else the backend's own. */
#ifndef ASSAY_CPU_SCRATCH_H
#define ASSAY_CPU_SCRATCH_H

#include <pthread.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* Bytes that sizes told to applications have more than the builder's, so that it can align. */
#define CPU_SCRATCH_SLACK 63u

/* What is in use now. */
struct cpu_scratch_claims {
    pthread_mutex_t lock; /* held for look-ups alone */
    struct cpu_scratch *first;
};

void cpu_scratch_claims_init(struct cpu_scratch_claims *claims);
void cpu_scratch_claims_release(struct cpu_scratch_claims *claims);

struct cpu_scratch {
    void *bytes; /* aligned for the builder */
    uint64_t size;
    void *owned; /* to be freed, or NULL */
    struct cpu_scratch_claims *claims;
    struct cpu_scratch *next;
};

/* `given`: size + CPU_SCRATCH_SLACK bytes, if it can be written; or NULL. Fails without memory. The
 * scratch must not move until it is returned. */
VkResult cpu_scratch_take(struct cpu_scratch_claims *claims, void *given, uint64_t size,
                          struct cpu_scratch *scratch);
void cpu_scratch_return(struct cpu_scratch *scratch);

#endif
