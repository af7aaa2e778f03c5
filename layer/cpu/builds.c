/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: sizes and compatibility of structures, and the end of a recording. */
#include <string.h>

#include "observers.h"
#include "src/cpu/device.h"
#include "src/snapshots/build_parameters.h"
#include "src/snapshots/build_sizes.h"

/* Builds of both types use the same builder. */
void cpu_get_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                         const uint32_t *max_primitive_counts,
                         VkAccelerationStructureBuildSizesInfoKHR *out)
{
    struct builder_sizes sizes;
    cpu_build_sizes(info, max_primitive_counts, &sizes);
    out->accelerationStructureSize = sizes.structure;
    out->buildScratchSize = sizes.build_scratch + (sizes.structure ? CPU_SCRATCH_SLACK : 0);
    out->updateScratchSize = sizes.update_scratch + (sizes.structure ? CPU_SCRATCH_SLACK : 0);
}

void cpu_compare_versions(struct cpu_device *backend, const uint8_t *version,
                          VkAccelerationStructureCompatibilityKHR *compatibility)
{
    const struct builder_uuids *uuids = &backend->uuids;
    struct readable_cache cache = {0};
    bool is_same =
        readable(&cache, version, sizeof(*uuids)) && memcmp(version, uuids, sizeof(*uuids)) == 0;
    *compatibility = is_same ? VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR
                             : VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR;
}

/* Reports lack of memory during recording. */
VkResult cpu_end_command_buffer(struct layer_device *device, PFN_vkEndCommandBuffer down,
                                VkCommandBuffer handle)
{
    const struct command_buffer *command_buffer =
        command_buffers_find(device->command_buffers, handle);
    VkResult result = down(handle);
    return result == VK_SUCCESS && command_buffer && command_buffer->work_failed
               ? VK_ERROR_OUT_OF_HOST_MEMORY
               : result;
}
