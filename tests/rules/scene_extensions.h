/* SPDX-License-Identifier: Apache-2.0 */
/* Valid builds of extensions, for cases to break: of spheres, of linear swept spheres, with motion.
 */
#ifndef RULES_SCENE_EXTENSIONS_H
#define RULES_SCENE_EXTENSIONS_H

#include "scene.h"

/* The build that these add: one geometry of 4 primitives, its data in the scene's structures. */
enum { SPHERES = SCENE_BASE_BUILDS };
void scene_add_spheres(struct scene *scene);
void scene_add_swept_spheres(struct scene *scene);

/* An instance of TLAS; and making it refer to a structure. */
VkAccelerationStructureInstanceKHR *scene_instance(struct scene *scene, uint32_t index);
void scene_refer(struct scene *scene, uint32_t index, VkAccelerationStructureKHR accel);
/* A structure like `model` that is built before the call. */
VkAccelerationStructureKHR scene_built(struct scene *scene, uint32_t model);
/* Has TLAS read its instances, at their places, by pointers in the second half of the buffer; the
 * other pointers there are null. */
void scene_use_instance_pointers(struct scene *scene);

/* Gives a build a dst that was created for motion, and scratch. */
void scene_give_motion_dst(struct scene *scene, uint32_t build);

#endif
