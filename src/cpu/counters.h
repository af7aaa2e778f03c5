/* SPDX-License-Identifier: Apache-2.0 */
/* Counters of one device of backend cpu, from its creation on. */
#ifndef ASSAY_CPU_COUNTERS_H
#define ASSAY_CPU_COUNTERS_H

#include <stdatomic.h>

/* COUNTER(name, public): `public` is the member of AssayCounters (layer/assay.h), which explains
 * each counter. The copies of command buffers are counted elsewhere, when they are recorded. */
#define CPU_COUNTERS(COUNTER)                                                                      \
    COUNTER(builds, builds)                                                                        \
    COUNTER(updates, updates)                                                                      \
    COUNTER(copies, copies)                                                                        \
    COUNTER(primitives, primitives)                                                                \
    COUNTER(bytes_built, bytesBuilt)                                                               \
    COUNTER(bytes_serialized, bytesSerialized)                                                     \
    COUNTER(own_scratch, ownScratch)                                                               \
    COUNTER(rays, rays)                                                                            \
    COUNTER(nodes_visited, nodesVisited)                                                           \
    COUNTER(instances_entered, instancesEntered)                                                   \
    COUNTER(primitives_tested, primitivesTested)                                                   \
    COUNTER(exact_calls, exactCalls)                                                               \
    COUNTER(matrix_products, matrixProducts)                                                       \
    COUNTER(micromaps_read, micromapsRead)

struct cpu_counters {
#define COUNTER(name, public) _Atomic unsigned long long name;
    CPU_COUNTERS(COUNTER)
#undef COUNTER
};

static inline void cpu_count(_Atomic unsigned long long *counter, unsigned long long by)
{
    if (by > 0)
        atomic_fetch_add_explicit(counter, by, memory_order_relaxed);
}

#endif
