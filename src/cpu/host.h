/* SPDX-License-Identifier: Apache-2.0 */
/* The host commands of backend cpu. Each takes a deferred operation's handle, or 0 to be carried
 * out at once, on the caller's thread; parameters are copied, so that nothing but the data behind
 * addresses is read later. Handles are looked up when the work is done.
 *
 * Results as in make.h; with a deferred operation VK_OPERATION_DEFERRED_KHR. */
#ifndef ASSAY_CPU_HOST_H
#define ASSAY_CPU_HOST_H

#include "src/cpu/device.h"

/* vkBuildAccelerationStructuresKHR. Builds follow each other where they aren't deferred. A build
 * that fails leaves dst as it was, and the others are still carried out. */
VkResult cpu_host_build(struct cpu_device *device, uint64_t operation, uint32_t count,
                        const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                        const VkAccelerationStructureBuildRangeInfoKHR *const *ranges);

/* vkBuildMicromapsEXT, likewise. */
VkResult cpu_host_build_micromaps(struct cpu_device *device, uint64_t operation, uint32_t count,
                                  const VkMicromapBuildInfoEXT *infos);

/* vkCopyAccelerationStructureKHR and to and from memory. */
VkResult cpu_host_copy(struct cpu_device *device, uint64_t operation,
                       const VkCopyAccelerationStructureInfoKHR *info);
VkResult cpu_host_serialize(struct cpu_device *device, uint64_t operation,
                            const VkCopyAccelerationStructureToMemoryInfoKHR *info);
VkResult cpu_host_deserialize(struct cpu_device *device, uint64_t operation,
                              const VkCopyMemoryToAccelerationStructureInfoKHR *info);

/* vkWriteAccelerationStructuresPropertiesKHR: writes what fits in `size` bytes, and nothing where
 * `data` can't be written. The value of what isn't built is 0, and the result an error. */
VkResult cpu_host_write_properties(struct cpu_device *device, uint32_t count,
                                   const VkAccelerationStructureKHR *structures, VkQueryType type,
                                   size_t size, void *data, size_t stride);

#endif
