/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of one geometry of an extension on a device fixture, from buffers of their own; and
 * micromaps. */
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

/* Describes separate triangles whose vertices are at that address, without indices. */
void input_scene_triangles(struct input_scene *scene, const void *chain, uint32_t count,
                           VkDeviceAddress vertices);

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

/* ---- micromaps: one of opacities: triangle 0 is transparent, 1 opaque, and of 2 the quarter at
 * vertex 0 is transparent, the middle opaque, that at vertex 1 unknown transparent, at vertex 2
 * unknown opaque. One of displacements: of triangle 0 the middles of its edges rise, by
 * `micromap_rise`, and all of triangle 1 does. */

enum { DATA = 256, MICROMAP_SIZE = 4096 };

extern const VkMicromapUsageEXT micromap_usages[2], micromap_displacement_usages[2];

struct micromap {
    VkMicromapEXT ext;
    VkAccelerationStructureKHR khr;
    struct device_buffer storage, input;
    VkMicromapTypeEXT type;
    const VkMicromapUsageEXT *usages;
};

void micromap_open(struct micromap *micromap, bool is_ext);
void micromap_open_displacement(struct micromap *micromap); /* of -EXT; its input is zeros */
void micromap_rise(const struct micromap *micromap, uint32_t rise); /* fills in the input */

/* A build of -EXT's from the input at that address. */
VkMicromapBuildInfoEXT micromap_info(const struct micromap *micromap, uint64_t base);
VkResult micromap_build_by_host(const struct micromap *micromap);
VkResult micromap_copy_by_host(const struct micromap *src, const struct micromap *dst,
                               VkCopyMicromapModeEXT mode);
VkResult micromap_save_by_host(const struct micromap *src, void *dst);
VkResult micromap_load_by_host(const void *src, const struct micromap *dst);
void micromap_clone_by_device(VkCommandBuffer commands, const struct micromap *src,
                              const struct micromap *dst);
/* Nothing is left of the input afterwards. */
void micromap_build_by_device(const struct micromap *micromap);

#endif
