/* SPDX-License-Identifier: Apache-2.0 */
/* Acceleration structures of the layer that the driver builds. */
#ifndef ASSAY_LAYER_COMPARE_STRUCTURES_H
#define ASSAY_LAYER_COMPARE_STRUCTURES_H

#include "layer/compare/pipelines.h"
#include "src/compare/input.h"

struct compare_structure {
    struct own_buffer buffer, scratch, input;
    VkAccelerationStructureKHR handle;
    VkAccelerationStructureGeometryKHR *geometries; /* owned */
    VkBuildAccelerationStructureFlagsKHR flags;     /* flags and instance_count: for a TLAS */
    uint32_t instance_count;
};

/* Allocates the memory of a build and of its input, and fills the input. `target` is the structure
 * that an update writes, or NULL; an update allocates no structure. Frees nothing: the caller calls
 * compare_structure_free(), also after a failure. */
VkResult compare_structure_create(const struct compare_device *device,
                                  const struct compare_input *input,
                                  const struct compare_structure *target,
                                  struct compare_structure *structure);

/* The instances of a TLAS. Their references and shader binding table offsets are filled in
 * later. */
struct compare_instances {
    uint32_t count;
    const VkAccelerationStructureInstanceKHR *instances;
    bool array_of_pointers;
    VkBuildAccelerationStructureFlagsKHR flags;
    VkGeometryFlagsKHR geometry_flags;
};
/* As compare_structure_create(), for a TLAS. */
VkResult compare_structure_create_top(const struct compare_device *device,
                                      const struct compare_instances *instances,
                                      struct compare_structure *structure);
/* Writes one instance with its reference and its shader binding table offset. */
void compare_structure_set_instance(const struct compare_structure *structure,
                                    const struct compare_instances *instances, uint32_t instance,
                                    uint64_t reference, uint32_t record);
void compare_structure_free(const struct compare_device *device,
                            struct compare_structure *structure);

/* Record a build and a barrier after it. */
void compare_structure_build(const struct compare_device *device, VkCommandBuffer commands,
                             const struct compare_input *input,
                             const struct compare_structure *target,
                             const struct compare_structure *structure);
void compare_structure_build_top(const struct compare_device *device, VkCommandBuffer commands,
                                 const struct compare_structure *structure);

#endif
