/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of one geometry of an extension on a device fixture, from buffers of their own. */
#ifndef CPU_BACKEND_INPUT_SCENE_H
#define CPU_BACKEND_INPUT_SCENE_H

#include "device_fixture.h"

enum { INPUT_SIZE = 4096 };

/* What a geometry is read from: by the host in `bytes`, by command buffers at `address`. */
struct input_scene {
    struct fixture_build build;
    struct fixture_structure blas;
    struct device_buffer vertices, radii, indices;
};

/* A geometry that all else of is to be filled in; nothing is made yet but the buffers. */
void input_scene_open(struct input_scene *scene, VkGeometryTypeKHR type, const void *chain);

/* Makes the structure; before it is built. */
void input_scene_create(struct input_scene *scene);

/* By a command buffer, ranges directly or in a buffer. Once it has executed, the buffers are
 * cleared: nothing can be read there any more. `ranges`: NULL: none is given. */
void input_scene_build(struct input_scene *scene,
                       const VkAccelerationStructureBuildRangeInfoKHR *ranges, bool is_indirect);

/* A ray at (y, z) towards +x from -1. */
AssayHit input_scene_trace(const struct input_scene *scene, float y, float z);
void input_scene_expect_hit(const struct input_scene *scene, float y, float z, float t,
                            uint32_t primitive);
void input_scene_expect_miss(const struct input_scene *scene, float y, float z);

#endif
