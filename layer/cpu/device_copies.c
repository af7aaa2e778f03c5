/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: copies in command buffers, between structures and from and to memory. */
#include "layer/cpu/overlay.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"

static void record_copy(VkCommandBuffer commands, uint64_t dst, uint64_t src,
                        VkCopyAccelerationStructureModeKHR mode)
{
    struct recorder recorder;
    if (!recorder_begin(&recorder, commands))
        return;
    recorder_add_copy(&recorder, &(struct recorded_command){
                                     .kind = mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR
                                                 ? CPU_COMPACT
                                                 : CPU_CLONE,
                                     .structure = dst,
                                     .src = src,
                                 });
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyAccelerationStructureInfoKHR *pInfo)
{
    record_copy(commandBuffer, (uint64_t)pInfo->dst, (uint64_t)pInfo->src, pInfo->mode);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyAccelerationStructureNV(
    VkCommandBuffer commandBuffer, VkAccelerationStructureNV dst, VkAccelerationStructureNV src,
    VkCopyAccelerationStructureModeKHR mode)
{
    record_copy(commandBuffer, (uint64_t)dst, (uint64_t)src, mode);
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyAccelerationStructureToMemoryKHR(
    VkCommandBuffer commandBuffer, const VkCopyAccelerationStructureToMemoryInfoKHR *pInfo)
{
    struct recorder recorder;
    if (!recorder_begin(&recorder, commandBuffer))
        return;
    recorder_add(&recorder, &(struct recorded_command){.kind = CPU_SERIALIZE,
                                                       .structure = (uint64_t)pInfo->src,
                                                       .address = pInfo->dst.deviceAddress});
}

/* The most bytes that the serialized form of a structure of `size` bytes takes: the header, and a
 * reference for each instance. */
static uint64_t serialized_max(uint64_t size)
{
    uint64_t references = size / sizeof(VkAccelerationStructureInstanceKHR) * sizeof(uint64_t);
    return 2 * VK_UUID_SIZE + 3 * sizeof(uint64_t) + references + size;
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdCopyMemoryToAccelerationStructureKHR(
    VkCommandBuffer commandBuffer, const VkCopyMemoryToAccelerationStructureInfoKHR *pInfo)
{
    struct recorder recorder;
    struct cpu_structure_info info;
    if (!recorder_begin(&recorder, commandBuffer))
        return;
    struct recorded_command read = {.kind = CPU_DESERIALIZE, .structure = (uint64_t)pInfo->dst};
    if (!cpu_structures_find(recorder.device->cpu->device->structures, read.structure, &info))
        return;
    if (recorder_copy(&recorder, pInfo->src.deviceAddress, serialized_max(info.size),
                      &read.serialized))
        recorder_add(&recorder, &read);
    recorder_end(&recorder);
}
