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

/* Gives a build a dst that was created for motion, and scratch. */
void scene_give_motion_dst(struct scene *scene, uint32_t build);

#define SPHERES_PATH "pInfos[6].pGeometries[0].pNext<VkAccelerationStructureGeometrySpheresDataNV>."
#define SWEPT_PATH                                                                                 \
    "pInfos[6].pGeometries[0].pNext<VkAccelerationStructureGeometryLinearSweptSpheresDataNV>."

#endif
