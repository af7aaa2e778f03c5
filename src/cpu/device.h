/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu of one device: what carries out its commands.
 *
 * Order of locks: the table of deferred operations, then a job's; pins, then a tree's (whose work
 * may run builds of its own), then scratch, host memory or structures, one at a time; private data
 * by itself. No lock but pins' and a tree's is held while trees are made, and none across a call
 * out of the backend. */
#ifndef ASSAY_CPU_DEVICE_H
#define ASSAY_CPU_DEVICE_H

#include "src/bvh/bvh.h"
#include "src/cpu/counters.h"
#include "src/cpu/deferred.h"
#include "src/cpu/private_data.h"
#include "src/cpu/query_pools.h"
#include "src/cpu/scratch.h"
#include "src/cpu/structures.h"

/* Whether something was built of what a later execution of the same submission had copied. */
enum cpu_overwritten { OVERWRITTEN_NEVER, OVERWRITTEN_ONCE, OVERWRITTEN_TOLD };

struct cpu_device {
    struct builder_uuids uuids; /* of serialized structures; never change */
    struct cpu_structures *structures;
    struct cpu_deferred_operations *deferred;
    struct cpu_query_pools *query_pools;
    struct cpu_scratch_claims scratch_claims;
    struct cpu_private_data private_data;
    struct cpu_counters counters;
    atomic_uint overwritten;  /* enum cpu_overwritten */
    atomic_bool lacks_copies; /* the driver has not executed the copies of a submission */
    bool has_micromaps;       /* an extension that has them is enabled; never changes */
};

/* `driver_uuid`: VkPhysicalDeviceIDProperties::driverUUID. */
VkResult cpu_device_create(const uint8_t driver_uuid[VK_UUID_SIZE], struct cpu_device **device);
void cpu_device_destroy(struct cpu_device *device); /* NULL: nothing */

#endif
