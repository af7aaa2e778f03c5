/* SPDX-License-Identifier: Apache-2.0 */
/* The host commands of backend cpu. Each takes the handle of a deferred operation, or 0 to execute
 * at once on the caller's thread. Parameters are copied, so a deferred command only reads the data
 * behind addresses later. Handles are looked up when the command executes.
 *
 * Results are those of make.h; VK_OPERATION_DEFERRED_KHR with a deferred operation. */
#ifndef ASSAY_CPU_HOST_H
#define ASSAY_CPU_HOST_H

#include "src/cpu/device.h"

/* vkBuildAccelerationStructuresKHR. Builds that are not deferred execute one after the other. If a
 * build fails, its dst keeps its contents, and the others still execute. */
VkResult cpu_host_build(struct cpu_device *device, uint64_t operation, uint32_t count,
                        const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                        const VkAccelerationStructureBuildRangeInfoKHR *const *ranges);

/* vkBuildMicromapsEXT, in the same way. */
VkResult cpu_host_build_micromaps(struct cpu_device *device, uint64_t operation, uint32_t count,
                                  const VkMicromapBuildInfoEXT *infos);

/* vkCopyAccelerationStructureKHR, vkCopyAccelerationStructureToMemoryKHR and
 * vkCopyMemoryToAccelerationStructureKHR. */
VkResult cpu_host_copy(struct cpu_device *device, uint64_t operation,
                       const VkCopyAccelerationStructureInfoKHR *info);
VkResult cpu_host_serialize(struct cpu_device *device, uint64_t operation,
                            const VkCopyAccelerationStructureToMemoryInfoKHR *info);
VkResult cpu_host_deserialize(struct cpu_device *device, uint64_t operation,
                              const VkCopyMemoryToAccelerationStructureInfoKHR *info);

/* vkWriteAccelerationStructuresPropertiesKHR. Writes the values that fit into `size` bytes, and
 * none if `data` is not writable. If a structure is not built, its value is 0, and the result is an
 * error. */
VkResult cpu_host_write_properties(struct cpu_device *device, uint32_t count,
                                   const VkAccelerationStructureKHR *structures, VkQueryType type,
                                   size_t size, void *data, size_t stride);

#endif
