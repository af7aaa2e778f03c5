/* SPDX-License-Identifier: Apache-2.0 */
/* Where things stand in the scene: the boxes and the instances. */
#ifndef DEMO_LAYOUT_H
#define DEMO_LAYOUT_H

#include <vulkan/vulkan.h>

#define LAYOUT_BOX_COUNT 480
#define LAYOUT_INSTANCE_COUNT 7

/* What scene.comp reads from an instance's custom index. */
#define LAYOUT_TWISTED_BIT                                                                         \
    0x100 /* shaded with the second set of normals; below it, the material                         \
           */

/* The BLAS that instances refer to. */
struct layout_references {
    VkDeviceAddress mesh;
    VkDeviceAddress twisted;
    VkDeviceAddress box_field;
};

void layout_boxes(VkAabbPositionsKHR boxes[LAYOUT_BOX_COUNT]);
void layout_instances(VkAccelerationStructureInstanceKHR instances[LAYOUT_INSTANCE_COUNT],
                      const struct layout_references *references);

#endif
