/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu of one device: what carries out its commands.
 *
 * Order of locks: deferred operations, then scratch, then structures; a tree's lock is taken before
 * any of these. Each module states what it holds when. */
#ifndef ASSAY_CPU_DEVICE_H
#define ASSAY_CPU_DEVICE_H

#include "build/build.h"
#include "cpu/counters.h"
#include "cpu/structures.h"

struct cpu_device {
    struct builder_uuids uuids; /* of serialized structures; never change */
    struct cpu_structures *structures;
    struct cpu_counters counters;
};

/* `driver_uuid`: VkPhysicalDeviceIDProperties::driverUUID. */
VkResult cpu_device_create(const uint8_t driver_uuid[VK_UUID_SIZE], struct cpu_device **device);
void cpu_device_destroy(struct cpu_device *device); /* NULL: nothing */

#endif
