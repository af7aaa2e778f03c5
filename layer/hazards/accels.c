/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies, serialization and queries of acceleration structures. They access what the last
 * build needed, which may be less than the structure was created with, and something else may lie
 * behind it: only the first byte is certain. Of serialized data it is the header. */
#include "layer/hazards/host.h"
#include "layer/hazards/recording.h"
#include "observers.h"

/* ---- structures and memory */

static void add_accel(struct hazard_recording *recording, enum access_kind kind,
                      enum hazard_role role, VkAccelerationStructureKHR handle)
{
    struct accel_facts facts;
    const struct hazard_use use = {.kind = kind, .role = role};
    resources_look_up_accel(recording->device->resources, handle, &facts);
    hazard_recording_add_accel(recording, &use, &facts, 1);
}

static void add_nv(struct hazard_recording *recording, enum access_kind kind, enum hazard_role role,
                   VkAccelerationStructureNV handle)
{
    struct nv_accel_facts facts;
    const struct hazard_use use = {.kind = kind, .role = role};
    resources_ask_nv_accel(recording->device->resources, handle, &facts);
    hazard_recording_add_nv(recording, &use, &facts);
    nv_shape_release(facts.created);
}

/* UUIDs of the driver and of the format, two sizes, and the number of references. */
enum { SERIALIZATION_HEADER = 2 * VK_UUID_SIZE + 3 * sizeof(uint64_t) };

static void add_header(struct hazard_recording *recording, enum access_kind kind,
                       VkDeviceAddress address)
{
    struct address_facts facts;
    const struct hazard_use use = {.kind = kind, .role = HAZARD_MEMORY};
    resources_look_up_address(recording->device->resources, address, &facts);
    hazard_recording_add_address(recording, &use, &facts, 0, SERIALIZATION_HEADER);
}

static void add_host_header(struct hazard_recording *recording, enum access_kind kind,
                            const void *address)
{
    const struct hazard_use use = {.kind = kind, .role = HAZARD_MEMORY};
    hazards_add_host(recording, &use, address, SERIALIZATION_HEADER);
}

/* ---- in command buffers */

void hazards_copy_accel(struct hazard_recording *recording,
                        const VkCopyAccelerationStructureInfoKHR *info)
{
    add_accel(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, info->src);
    add_accel(recording, ACCESS_COPY_ACCEL_WRITE, HAZARD_DST, info->dst);
}

void hazards_copy_nv_accel(struct hazard_recording *recording, VkAccelerationStructureNV dst,
                           VkAccelerationStructureNV src)
{
    add_nv(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, src);
    add_nv(recording, ACCESS_COPY_ACCEL_WRITE, HAZARD_DST, dst);
}

void hazards_write_accel(struct hazard_recording *recording,
                         const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    add_accel(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, info->src);
    add_header(recording, ACCESS_COPY_ACCEL_TRANSFER_WRITE, info->dst.deviceAddress);
}

void hazards_read_accel(struct hazard_recording *recording,
                        const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    add_header(recording, ACCESS_COPY_ACCEL_TRANSFER_READ, info->src.deviceAddress);
    add_accel(recording, ACCESS_COPY_ACCEL_WRITE, HAZARD_DST, info->dst);
}

void hazards_query_accels(struct hazard_recording *recording, uint32_t count,
                          const VkAccelerationStructureKHR *accels)
{
    for (uint32_t i = 0; i < count; i++)
        add_accel(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, accels[i]);
}

void hazards_query_nv_accels(struct hazard_recording *recording, uint32_t count,
                             const VkAccelerationStructureNV *accels)
{
    for (uint32_t i = 0; i < count; i++)
        add_nv(recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, accels[i]);
}

/* ---- on the host */

void hazards_copy_accel_on_host(struct hazard_recording *recording,
                                const VkCopyAccelerationStructureInfoKHR *info)
{
    add_accel(recording, ACCESS_HOST_READ, HAZARD_SRC, info->src);
    add_accel(recording, ACCESS_HOST_WRITE, HAZARD_DST, info->dst);
}

void hazards_read_accel_on_host(struct hazard_recording *recording,
                                const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    add_host_header(recording, ACCESS_HOST_READ, info->src.hostAddress);
    add_accel(recording, ACCESS_HOST_WRITE, HAZARD_DST, info->dst);
}

void hazards_write_accel_on_host(struct hazard_recording *recording,
                                 const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    add_accel(recording, ACCESS_HOST_READ, HAZARD_SRC, info->src);
    add_host_header(recording, ACCESS_HOST_WRITE, info->dst.hostAddress);
}

/* A query cannot be deferred, so its accesses end with the call. */
void hazards_query_accels_on_host(struct hazard_recording *recording, uint32_t count,
                                  const VkAccelerationStructureKHR *accels)
{
    for (uint32_t i = 0; i < count; i++)
        add_accel(recording, ACCESS_HOST_READ, HAZARD_SRC, accels[i]);
    struct host_work work = host_work_begin(recording->device);
    host_work_prepare(&work, false);
    host_work_finish(&work, VK_NULL_HANDLE, VK_SUCCESS);
}
