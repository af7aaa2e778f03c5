/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies, serialization and queries of acceleration structures. They access what the last
 * build needed, which may be less than the structure was created with, and something else may lie
 * behind it: only the first byte is certain. Of serialized data it is the header. */
#include "layer/hazards/commands.h"
#include "layer/hazards/host.h"
#include "layer/hazards/recording.h"
#include "layer/intercepts/intercepts.h"

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

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    struct hazard_recording recording;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdCopyAccelerationStructureKHR")) {
        add_accel(&recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, pInfo->src);
        add_accel(&recording, ACCESS_COPY_ACCEL_WRITE, HAZARD_DST, pInfo->dst);
    }
    assay_CmdCopyAccelerationStructureKHR(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyAccelerationStructureNV(
    VkCommandBuffer commandBuffer, VkAccelerationStructureNV dst, VkAccelerationStructureNV src,
    VkCopyAccelerationStructureModeKHR mode)
{
    struct hazard_recording recording;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdCopyAccelerationStructureNV")) {
        add_nv(&recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, src);
        add_nv(&recording, ACCESS_COPY_ACCEL_WRITE, HAZARD_DST, dst);
    }
    assay_CmdCopyAccelerationStructureNV(commandBuffer, dst, src, mode);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyAccelerationStructureToMemoryKHR(
    VkCommandBuffer commandBuffer, const VkCopyAccelerationStructureToMemoryInfoKHR *pInfo)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer,
                               "vkCmdCopyAccelerationStructureToMemoryKHR")) {
        add_accel(&recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, pInfo->src);
        add_header(&recording, ACCESS_COPY_ACCEL_TRANSFER_WRITE, pInfo->dst.deviceAddress);
    }
    device->vk.CmdCopyAccelerationStructureToMemoryKHR(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyMemoryToAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    struct hazard_recording recording;
    if (hazard_recording_begin(&recording, commandBuffer,
                               "vkCmdCopyMemoryToAccelerationStructureKHR")) {
        add_header(&recording, ACCESS_COPY_ACCEL_TRANSFER_READ, pInfo->src.deviceAddress);
        add_accel(&recording, ACCESS_COPY_ACCEL_WRITE, HAZARD_DST, pInfo->dst);
    }
    assay_CmdCopyMemoryToAccelerationStructureKHR(commandBuffer, pInfo);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdWriteAccelerationStructuresPropertiesKHR(
    VkCommandBuffer commandBuffer, uint32_t accelerationStructureCount,
    const VkAccelerationStructureKHR *pAccelerationStructures, VkQueryType queryType,
    VkQueryPool queryPool, uint32_t firstQuery)
{
    struct hazard_recording recording;
    if (hazard_recording_begin(&recording, commandBuffer,
                               "vkCmdWriteAccelerationStructuresPropertiesKHR"))
        for (uint32_t i = 0; i < accelerationStructureCount; i++)
            add_accel(&recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, pAccelerationStructures[i]);
    assay_CmdWriteAccelerationStructuresPropertiesKHR(commandBuffer, accelerationStructureCount,
                                                      pAccelerationStructures, queryType, queryPool,
                                                      firstQuery);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdWriteAccelerationStructuresPropertiesNV(
    VkCommandBuffer commandBuffer, uint32_t accelerationStructureCount,
    const VkAccelerationStructureNV *pAccelerationStructures, VkQueryType queryType,
    VkQueryPool queryPool, uint32_t firstQuery)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer,
                               "vkCmdWriteAccelerationStructuresPropertiesNV"))
        for (uint32_t i = 0; i < accelerationStructureCount; i++)
            add_nv(&recording, ACCESS_COPY_ACCEL_READ, HAZARD_SRC, pAccelerationStructures[i]);
    device->vk.CmdWriteAccelerationStructuresPropertiesNV(commandBuffer, accelerationStructureCount,
                                                          pAccelerationStructures, queryType,
                                                          queryPool, firstQuery);
}

/* ---- on the host */

VKAPI_ATTR VkResult VKAPI_CALL
hazards_CopyAccelerationStructureKHR(VkDevice device, VkDeferredOperationKHR deferredOperation,
                                     const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    struct hazard_recording recording;
    if (hazards_start_host(&recording, device, "vkCopyAccelerationStructureKHR")) {
        add_accel(&recording, ACCESS_HOST_READ, HAZARD_SRC, pInfo->src);
        add_accel(&recording, ACCESS_HOST_WRITE, HAZARD_DST, pInfo->dst);
    }
    return assay_CopyAccelerationStructureKHR(device, deferredOperation, pInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL hazards_CopyMemoryToAccelerationStructureKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation,
    const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    struct hazard_recording recording;
    if (hazards_start_host(&recording, device, "vkCopyMemoryToAccelerationStructureKHR")) {
        add_host_header(&recording, ACCESS_HOST_READ, pInfo->src.hostAddress);
        add_accel(&recording, ACCESS_HOST_WRITE, HAZARD_DST, pInfo->dst);
    }
    return assay_CopyMemoryToAccelerationStructureKHR(device, deferredOperation, pInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL hazards_CopyAccelerationStructureToMemoryKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation,
    const VkCopyAccelerationStructureToMemoryInfoKHR *pInfo)
{
    struct layer_device *state = layer_find_device(device);
    struct hazard_recording recording;
    if (hazards_start_host(&recording, device, "vkCopyAccelerationStructureToMemoryKHR")) {
        add_accel(&recording, ACCESS_HOST_READ, HAZARD_SRC, pInfo->src);
        add_host_header(&recording, ACCESS_HOST_WRITE, pInfo->dst.hostAddress);
    }
    struct host_work work = host_work_begin(state);
    host_work_prepare(&work, false);
    VkResult result =
        state->vk.CopyAccelerationStructureToMemoryKHR(device, deferredOperation, pInfo);
    return host_work_finish(&work, deferredOperation, result);
}

/* The command cannot be deferred, so its accesses end with the call. */
VKAPI_ATTR VkResult VKAPI_CALL hazards_WriteAccelerationStructuresPropertiesKHR(
    VkDevice device, uint32_t accelerationStructureCount,
    const VkAccelerationStructureKHR *pAccelerationStructures, VkQueryType queryType,
    size_t dataSize, void *pData, size_t stride)
{
    struct hazard_recording recording;
    if (hazards_start_host(&recording, device, "vkWriteAccelerationStructuresPropertiesKHR")) {
        for (uint32_t i = 0; i < accelerationStructureCount; i++)
            add_accel(&recording, ACCESS_HOST_READ, HAZARD_SRC, pAccelerationStructures[i]);
        struct host_work work = host_work_begin(recording.device);
        host_work_prepare(&work, false);
        host_work_finish(&work, VK_NULL_HANDLE, VK_SUCCESS);
    }
    return assay_WriteAccelerationStructuresPropertiesKHR(device, accelerationStructureCount,
                                                          pAccelerationStructures, queryType,
                                                          dataSize, pData, stride);
}
