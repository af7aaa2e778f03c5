/* SPDX-License-Identifier: Apache-2.0 */
/* Valid builds of spheres and of linear swept spheres, for cases to break. */
#ifndef RULES_SCENE_SPHERES_H
#define RULES_SCENE_SPHERES_H

#include "scene.h"

/* The build that these add: one geometry of 4 primitives, its data in the scene's structures. */
enum { SPHERES = SCENE_BASE_BUILDS };
void scene_add_spheres(struct scene *scene);
void scene_add_swept_spheres(struct scene *scene);

#define SPHERES_PATH "pInfos[6].pGeometries[0].pNext<VkAccelerationStructureGeometrySpheresDataNV>."
#define SWEPT_PATH                                                                                 \
    "pInfos[6].pGeometries[0].pNext<VkAccelerationStructureGeometryLinearSweptSpheresDataNV>."

#endif
