/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu's part of a device. */
#ifndef ASSAY_CPU_DEVICE_H
#define ASSAY_CPU_DEVICE_H

#include <stdatomic.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/base/handle_table.h"
#include "src/bvh/bvh.h"
#include "src/cpu/deferred.h"
#include "src/cpu/query_pools.h"
#include "src/cpu/structures.h"
#include "src/platform/threads.h"

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

/* ---- private data (vkSetPrivateData) of the backend's own objects, which the driver does not have
 */

struct cpu_private_data {
    pthread_mutex_t lock;        /* only held for look-ups */
    struct handle_table objects; /* lists of values, by the object's handle */
};

VkResult cpu_private_data_set(struct cpu_private_data *data, uint64_t object, uint64_t slot,
                              uint64_t value);
uint64_t cpu_private_data_get(struct cpu_private_data *data, uint64_t object, uint64_t slot);
void cpu_private_data_forget_object(struct cpu_private_data *data, uint64_t object);
void cpu_private_data_forget_slot(struct cpu_private_data *data, uint64_t slot);

/* ---- The scratch memory of host builds: the application's if it is writable and no other running
 * build uses a part of it; otherwise the backend's own. */

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

/* ---- the device */

/* Whether something has occurred that is reported once, and whether that was done. */
enum cpu_occurrence { OCCURRED_NEVER, OCCURRED, OCCURRENCE_REPORTED };

static inline void cpu_occurs(atomic_uint *occurrence)
{
    unsigned never = OCCURRED_NEVER;
    atomic_compare_exchange_strong(occurrence, &never, OCCURRED);
}

struct cpu_device {
    struct builder_uuids uuids; /* of serialized structures; constant */
    struct cpu_structures *structures;
    struct cpu_deferred_operations *deferred;
    struct cpu_query_pools *query_pools;
    struct cpu_scratch_claims scratch_claims;
    struct cpu_private_data private_data;
    struct cpu_counters counters;
    /* enum cpu_occurrence: a tree was built from snapshots that a later execution in the same
     * submission had overwritten; the host used a structure before its batch was complete. */
    atomic_uint overwritten, used_early;
    atomic_uint refused;      /* commands of command buffers that no message was about */
    atomic_bool lacks_copies; /* the driver has not executed the copies of a submission */
    bool has_micromaps;       /* an extension with micromaps is enabled; constant */
};

/* `driver_uuid`: VkPhysicalDeviceIDProperties::driverUUID. Fails only if memory runs out. */
VkResult cpu_device_create(const uint8_t driver_uuid[VK_UUID_SIZE], struct cpu_device **device);
void cpu_device_destroy(struct cpu_device *device); /* accepts NULL */

#endif
