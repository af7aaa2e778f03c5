/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu of one device: it executes the device's acceleration-structure commands.
 *
 * Order of locks:
 * - the table of deferred operations, then a job
 * - BLAS references, then a tree (whose work may run builds), then one of scratch, host memory and
 *   structures
 * - private data, alone
 * While a tree is made, only locks of BLAS references and of trees are held. No lock is held during
 * a call out of the backend. */
#ifndef ASSAY_CPU_DEVICE_H
#define ASSAY_CPU_DEVICE_H

#include "src/bvh/bvh.h"
#include "src/cpu/counters.h"
#include "src/cpu/deferred.h"
#include "src/cpu/private_data.h"
#include "src/cpu/query_pools.h"
#include "src/cpu/scratch.h"
#include "src/cpu/structures.h"

/* Whether a tree was built from snapshots that a later execution in the same submission had
 * overwritten, and whether that was reported. */
enum cpu_overwritten { OVERWRITTEN_NEVER, OVERWRITTEN_ONCE, OVERWRITTEN_TOLD };

struct cpu_device {
    struct builder_uuids uuids; /* of serialized structures; constant */
    struct cpu_structures *structures;
    struct cpu_deferred_operations *deferred;
    struct cpu_query_pools *query_pools;
    struct cpu_scratch_claims scratch_claims;
    struct cpu_private_data private_data;
    struct cpu_counters counters;
    atomic_uint overwritten;  /* enum cpu_overwritten */
    atomic_bool lacks_copies; /* the driver has not executed the copies of a submission */
    bool has_micromaps;       /* an extension with micromaps is enabled; constant */
};

/* `driver_uuid`: VkPhysicalDeviceIDProperties::driverUUID. Fails only if memory runs out. */
VkResult cpu_device_create(const uint8_t driver_uuid[VK_UUID_SIZE], struct cpu_device **device);
void cpu_device_destroy(struct cpu_device *device); /* accepts NULL */

#endif
