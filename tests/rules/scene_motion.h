/* SPDX-License-Identifier: Apache-2.0 */
/* Structures for builds with motion. */
#ifndef RULES_SCENE_MOTION_H
#define RULES_SCENE_MOTION_H

#include "scene.h"

/* Gives a build a dst that was created for motion, and scratch. */
void scene_give_motion_dst(struct scene *scene, uint32_t build);

#endif
