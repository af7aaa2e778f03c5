/* SPDX-License-Identifier: Apache-2.0 */
/* The micromaps of a scene: none until a case asks for one. */
#ifndef RULES_SCENE_MICROMAP_H
#define RULES_SCENE_MICROMAP_H

#include "scene_inputs.h"

enum { SCENE_USAGES = 4, SCENE_MICROMAP_INPUT_SIZE = 1 << 16 };

struct scene;

struct scene_micromaps {
    /* Of scene_build_micromap. */
    VkAccelerationStructureGeometryMicromapDataKHR data;
    VkMicromapTriangleKHR *triangles; /* what it leads to, as the host writes it */
    struct test_buffer triangle_buffer;
    VkMicromapUsageKHR usages[SCENE_USAGES];
    const VkMicromapUsageKHR *usage_pointers[SCENE_USAGES];
    /* Of the others. */
    VkAccelerationStructureTrianglesOpacityMicromapKHR opacity, opacity_of_update;
    VkAccelerationStructureTrianglesOpacityMicromapEXT opacity_ext;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
    VkMicromapUsageEXT usages_ext[SCENE_USAGES];
    const VkMicromapUsageEXT *usage_pointers_ext[SCENE_USAGES];
};

/* Makes AABBS the build of an opacity micromap of VK_KHR_opacity_micromap, of one triangle. */
void scene_build_micromap(struct scene *scene);

/* A structure that such a build may have as its dst. */
VkAccelerationStructureKHR scene_micromap_structure(struct scene *scene,
                                                    VkAccelerationStructureTypeKHR type);

/* Each gives a micromap of its extension to the triangles of INDEXED, with 32-bit indices. Builds
 * on the host take no micromaps of VK_KHR_opacity_micromap: there it is null. */
void scene_use_micromap(struct scene *scene);
void scene_use_micromap_ext(struct scene *scene);
void scene_use_displacement(struct scene *scene);

VkMicromapEXT scene_micromap_ext(struct scene *scene, VkMicromapTypeEXT type);

/* A structure that the command buffer of the scene has made an opacity micromap of so many
 * triangles. */
VkAccelerationStructureKHR scene_record_micromap(struct scene *scene, uint32_t triangle_count);

/* Records a deserialization. */
void scene_deserialize(struct scene *scene, VkAccelerationStructureKHR structure);

#endif
