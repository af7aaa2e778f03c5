/* SPDX-License-Identifier: Apache-2.0 */
/* Vector clocks: when a batch executed, and which batches certainly executed before it.
 *
 * Each queue counts its batches; the host counts its commands. A clock holds, for each queue and
 * for the host, how many of them certainly executed before. The order of a batch that the clock
 * doesn't cover is unknown: it may have executed before, too (Mattern, Virtual Time and Global
 * States of Distributed Systems, 1988). */
#ifndef ASSAY_STATE_ORDER_CLOCK_H
#define ASSAY_STATE_ORDER_CLOCK_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum {
    EXECUTION_HOST = 0,    /* the host's index among the queues */
    EXECUTION_QUEUES = 32, /* the host and the queues that may be submitted to */
};

/* When something executed: in batch `count` of a queue. Batches count from 1. */
struct timestamp {
    uint32_t queue;
    uint64_t count;
};

/* A timestamp that no clock covers, for writes whose order is unknown. */
static inline struct timestamp timestamp_never(void)
{
    return (struct timestamp){.count = UINT64_MAX};
}

struct execution_clock {
    uint32_t queues; /* stored counts; counts beyond these are 0 */
    uint64_t counts[EXECUTION_QUEUES];
};

static inline bool execution_clock_has(const struct execution_clock *clock,
                                       struct timestamp timestamp)
{
    return timestamp.queue < clock->queues && timestamp.count <= clock->counts[timestamp.queue];
}

static inline void execution_clock_copy(struct execution_clock *clock,
                                        const struct execution_clock *other)
{
    clock->queues = other->queues;
    memcpy(clock->counts, other->counts, other->queues * sizeof(other->counts[0]));
}

static inline void execution_clock_extend(struct execution_clock *clock, uint32_t queues)
{
    while (clock->queues < queues)
        clock->counts[clock->queues++] = 0;
}

static inline void execution_clock_join(struct execution_clock *clock,
                                        const struct execution_clock *other)
{
    execution_clock_extend(clock, other->queues);
    for (uint32_t i = 0; i < other->queues; i++)
        if (clock->counts[i] < other->counts[i])
            clock->counts[i] = other->counts[i];
}

static inline void execution_clock_add(struct execution_clock *clock, struct timestamp timestamp)
{
    execution_clock_extend(clock, timestamp.queue + 1);
    if (clock->counts[timestamp.queue] < timestamp.count)
        clock->counts[timestamp.queue] = timestamp.count;
}

/* Whether `clock` covers all that `other` covers. */
static inline bool execution_clock_covers(const struct execution_clock *clock,
                                          const struct execution_clock *other)
{
    for (uint32_t i = 0; i < other->queues; i++)
        if (other->counts[i] &&
            !execution_clock_has(clock, (struct timestamp){i, other->counts[i]}))
            return false;
    return true;
}

#endif
