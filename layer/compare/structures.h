/* SPDX-License-Identifier: Apache-2.0 */
/* Acceleration structures of the layer's own, built by the driver. */
#ifndef ASSAY_LAYER_COMPARE_STRUCTURES_H
#define ASSAY_LAYER_COMPARE_STRUCTURES_H

#include "compare/input.h"
#include "compare/memory.h"

struct compare_structure {
    struct compare_buffer buffer, scratch, input;
    VkAccelerationStructureKHR handle;
    VkAccelerationStructureGeometryKHR *geometries; /* owned */
};

/* Makes room for a build, and for its input, which is filled in. `target`: NULL, or what an update
 * writes, which then needs no room of its own. Frees nothing: compare_structure_free() does. */
VkResult compare_structure_create(const struct compare_device *device,
                                  const struct compare_input *input,
                                  const struct compare_structure *target,
                                  struct compare_structure *structure);
/* A TLAS of one instance of it. */
VkResult compare_structure_create_top(const struct compare_device *device,
                                      const struct compare_structure *bottom,
                                      struct compare_structure *structure);
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
