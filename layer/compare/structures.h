/* SPDX-License-Identifier: Apache-2.0 */
/* Acceleration structures of the layer's own, built by the driver. */
#ifndef ASSAY_LAYER_COMPARE_STRUCTURES_H
#define ASSAY_LAYER_COMPARE_STRUCTURES_H

#include "layer/compare/memory.h"
#include "src/compare/input.h"

struct compare_structure {
    struct own_buffer buffer, scratch, input;
    VkAccelerationStructureKHR handle;
    VkAccelerationStructureGeometryKHR *geometries; /* owned */
    VkBuildAccelerationStructureFlagsKHR flags;     /* these two: of a TLAS */
    uint32_t instance_count;
};

/* Makes room for a build, and for its input, which is filled in. `target`: NULL, or what an update
 * writes, which then needs no room of its own. Frees nothing: compare_structure_free() does. */
VkResult compare_structure_create(const struct compare_device *device,
                                  const struct compare_input *input,
                                  const struct compare_structure *target,
                                  struct compare_structure *structure);

/* Those of a TLAS; references, and records of the shader binding table, are filled in later. */
struct compare_instances {
    uint32_t count;
    const VkAccelerationStructureInstanceKHR *instances;
    bool array_of_pointers;
    VkBuildAccelerationStructureFlagsKHR flags;
    VkGeometryFlagsKHR geometry_flags;
};
VkResult compare_structure_create_top(const struct compare_device *device,
                                      const struct compare_instances *instances,
                                      struct compare_structure *structure);
void compare_structure_set_instance(const struct compare_structure *structure,
                                    const struct compare_instances *instances, uint32_t instance,
                                    uint64_t reference, uint32_t record);
void compare_structure_free(const struct compare_device *device,
                            struct compare_structure *structure);

/* Record the builds, and a barrier after each. */
void compare_structure_build(const struct compare_device *device, VkCommandBuffer commands,
                             const struct compare_input *input,
                             const struct compare_structure *target,
                             const struct compare_structure *structure);
void compare_structure_build_top(const struct compare_device *device, VkCommandBuffer commands,
                                 const struct compare_structure *structure);

#endif
