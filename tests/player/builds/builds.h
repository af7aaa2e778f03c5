/* SPDX-License-Identifier: Apache-2.0 */
/* A line of builds: what its words fill in. */
#ifndef ASSAY_TESTS_PLAYER_BUILDS_BUILDS_H
#define ASSAY_TESTS_PLAYER_BUILDS_BUILDS_H

#include "tests/player/play.h"

enum { PRIMITIVES = 2, GEOMETRIES = 20 };

struct one_build {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometry; /* all are alike */
    VkFormat last_format;                        /* but for these two of the last one; or 0 */
    VkDeviceSize last_stride;
    uint32_t last_primitives;
    VkAccelerationStructureGeometryKHR geometries[GEOMETRIES];
    VkAccelerationStructureTrianglesOpacityMicromapEXT micromap;
    VkMicromapUsageEXT usage;
    uint32_t first_micromap; /* of those with numbers; 0: all geometries have the same, if any */
    VkAccelerationStructureTrianglesOpacityMicromapEXT micromaps[GEOMETRIES];
    VkAccelerationStructureTrianglesOpacityMicromapKHR opacity;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displaced;
    VkMicromapUsageKHR usage_khr, mixed_khr[PLAY_MIXED_USAGES];
    VkBaseInStructure unknown;
    union {
        VkAccelerationStructureGeometryMicromapDataKHR micromap_khr;
        VkAccelerationStructureGeometryMotionTrianglesDataNV motion;
        VkAccelerationStructureGeometrySpheresDataNV spheres;
        VkAccelerationStructureGeometryLinearSweptSpheresDataNV swept;
        VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX dense;
    } chained;
    VkAccelerationStructureBuildRangeInfoKHR range;
    VkAccelerationStructureBuildRangeInfoKHR ranges[GEOMETRIES];
    uint32_t counts[GEOMETRIES];
    VkDeviceAddress indirect;
    char *indirect_place; /* where the host writes ranges, or NULL */
    bool are_pointers, have_hole, are_misplaced, are_null, are_astray; /* the geometries */
    bool lose_ranges; /* the pointers to ranges and counts lead nowhere */
};

struct build_line {
    struct play *play;
    struct one_build builds[PLAY_ITEMS];
    uint32_t count;
    bool is_host, is_indirect;
    VkDeferredOperationKHR operation;
    const char *null_array, *astray_array; /* names of the arrays below, or NULL */
    VkAccelerationStructureBuildGeometryInfoKHR infos[PLAY_ITEMS];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[PLAY_ITEMS];
    VkDeviceAddress addresses[PLAY_ITEMS];
    uint32_t strides[PLAY_ITEMS];
    const uint32_t *counts[PLAY_ITEMS];
};

/* Where nothing is. */
#define BUILD_NOWHERE ((const void *)(uintptr_t)0x40000008)

VkDeviceOrHostAddressConstKHR build_input(const struct build_line *line, const char *word);

/* These return false if the option is another one. extensions.c: geometries of extensions. */
bool build_read_extension(struct build_line *line, struct one_build *build, const char *option,
                          const char *word);
void build_mix_usages(const struct play *play, struct one_build *build);
/* members.c */
bool build_read_wild_word(struct one_build *build, const char *word);
bool build_read_wild(struct build_line *line, struct one_build *build, const char *option,
                     const char *word);
/* Sets pGeometries or ppGeometries of a build that is complete. */
void build_point_to_geometries(struct play *play, struct one_build *build);
/* Bounds what would take too long, or lead to memory that can be read but is not the application's.
 */
void build_bound(const struct build_line *line, struct one_build *build);

#endif
