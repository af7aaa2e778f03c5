/* SPDX-License-Identifier: Apache-2.0 */
/* The views of rules about micromaps, made only on devices that have one of their extensions. */
#ifndef ASSAY_VIEW_MICROMAP_VIEW_H
#define ASSAY_VIEW_MICROMAP_VIEW_H

#include <vulkan/vulkan.h>

#include "src/state/commands/journal.h"
#include "src/view/view.h"

/* The usage counts of a structure. */
struct micromap_usages {
    const char *array_field, *pointers_field; /* relative to the geometry */
    /* One of both is given and readable, or count is 0. */
    const void *array; /* of VkMicromapUsageKHR or -EXT, which are laid out alike */
    const void *const *pointers;
    uint32_t count;
    bool both_given, array_unreadable, pointers_unreadable;
};

/* A build, as far as micromaps go. */
struct micromap_build_view {
    const struct build_view *build;
};

/* A geometry, whether or not it has micromaps. */
struct micromap_geometry_view {
    const struct geometry_view *geometry;
    bool has_data; /* a VkAccelerationStructureGeometryMicromapDataKHR is in its chain */
};

/* A VkAccelerationStructureGeometryMicromapDataKHR. */
struct micromap_data_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureGeometryMicromapDataKHR *data;
    struct micromap_usages usages;
    /* From level STATE on; NULL in host builds. */
    const struct address_facts *triangles_facts;
};

/* A VkAccelerationStructureTrianglesOpacityMicromapKHR. */
struct opacity_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureTrianglesOpacityMicromapKHR *opacity;
    bool count_known; /* of the triangles: the indirect command's is in device memory */
    uint32_t primitive_count;
    /* From level STATE on. */
    struct accel_facts micromap;
    const struct address_facts *indices; /* NULL without indices */
};

/* A VkAccelerationStructureTrianglesOpacityMicromapEXT. */
struct opacity_ext_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity;
    struct micromap_usages usages;
    /* From level STATE on. */
    struct micromap_facts micromap;
};

/* A VkAccelerationStructureTrianglesDisplacementMicromapNV. */
struct displacement_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureTrianglesDisplacementMicromapNV *displacement;
    struct micromap_usages usages;
    /* From level STATE on. */
    struct micromap_facts micromap;
};

/* A micromap that a recorded build uses, and what is known of it when the build executes. */
struct used_micromap_view {
    enum build_command command;
    uint64_t handle;
    const struct journal_micromap *use;
    const struct built *built;
    const struct built *source; /* of the update that the build is; or NULL */
};

/* The micromaps of a geometry of an update, and of the geometry of the same index that its source
 * was built with. */
struct updated_micromap_view {
    const struct updated_geometry_view *geometry;
    struct micromap_shape asked, source;
};

#endif
