/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: copies in command buffers, between structures and from and to memory. Micromaps are
 * structures, too. */
#include "layer/cpu/overlay.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"

void cpu_copy_structure(VkCommandBuffer commands, uint64_t dst, uint64_t src,
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

void cpu_write_structure(VkCommandBuffer commands, uint64_t src, VkDeviceAddress dst)
{
    struct recorder recorder;
    if (!recorder_begin(&recorder, commands))
        return;
    recorder_add(&recorder, &(struct recorded_command){
                                .kind = CPU_SERIALIZE, .structure = src, .address = dst});
}

/* The most bytes that the serialized form of a structure of `size` bytes takes: the header, and a
 * reference for each instance. */
static uint64_t serialized_max(uint64_t size)
{
    uint64_t references = size / sizeof(VkAccelerationStructureInstanceKHR) * sizeof(uint64_t);
    return 2 * VK_UUID_SIZE + 3 * sizeof(uint64_t) + references + size;
}

void cpu_read_structure(VkCommandBuffer commands, uint64_t dst, VkDeviceAddress src)
{
    struct recorder recorder;
    struct cpu_structure_info info;
    if (!recorder_begin(&recorder, commands))
        return;
    struct recorded_command read = {.kind = CPU_DESERIALIZE, .structure = dst};
    if (!cpu_structures_find(recorder.device->cpu->device->structures, read.structure, &info))
        return;
    if (recorder_copy(&recorder, src, serialized_max(info.size), &read.serialized))
        recorder_add(&recorder, &read);
    recorder_end(&recorder);
}
