/* SPDX-License-Identifier: Apache-2.0 */
/* When something executed: the count-th batch of a queue, by the queue's index. */
#ifndef ASSAY_STATE_MOMENT_H
#define ASSAY_STATE_MOMENT_H

#include <stdint.h>

struct moment {
    uint32_t queue;
    uint64_t count;
};

/* A moment that nothing follows: after writes of undetermined order. */
static inline struct moment moment_never(void)
{
    return (struct moment){.queue = UINT32_MAX, .count = UINT64_MAX};
}

#endif
