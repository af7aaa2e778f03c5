/* SPDX-License-Identifier: Apache-2.0 */
/* What one device of backend cpu has done, counted from its creation on. */
#ifndef ASSAY_CPU_COUNTERS_H
#define ASSAY_CPU_COUNTERS_H

#include <stdatomic.h>

/* COUNTER(name). Each has a member of the same name in struct assay_counters (layer/assay.h). */
#define CPU_COUNTERS(COUNTER)                                                                      \
    COUNTER(builds)           /* trees built */                                                    \
    COUNTER(updates)          /* trees made from another one by an update */                       \
    COUNTER(copies)           /* clones, compactions, serializations, deserializations */          \
    COUNTER(primitives)       /* that builds and updates read */                                   \
    COUNTER(bytes_built)      /* of trees built, updated, copied or deserialized */                \
    COUNTER(bytes_serialized) /* written */                                                        \
    COUNTER(rays)             /* traced */                                                         \
    COUNTER(nodes_visited)                                                                         \
    COUNTER(instances_entered)                                                                     \
    COUNTER(primitives_tested)                                                                     \
    COUNTER(exact_calls) /* signs that needed exact arithmetic */

struct cpu_counters {
#define COUNTER(name) _Atomic unsigned long long name;
    CPU_COUNTERS(COUNTER)
#undef COUNTER
};

static inline void cpu_count(_Atomic unsigned long long *counter, unsigned long long by)
{
    atomic_fetch_add_explicit(counter, by, memory_order_relaxed);
}

#endif
