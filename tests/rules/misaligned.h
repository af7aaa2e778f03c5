/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of a call's arrays and structures at odd addresses. */
#ifndef RULES_MISALIGNED_H
#define RULES_MISALIGNED_H

#include "scene.h"

/* Makes the call of the scene lead to misaligned copies of all of its arrays, structures and chains
 * that are the scene's own, as they are now. The copies last until the thread calls it again. */
void scene_misalign(struct scene *scene);

#endif
