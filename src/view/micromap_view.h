/* SPDX-License-Identifier: Apache-2.0 */
/* The views of rules about micromaps. A view is created only if the device enables a micromap
 * extension. */
#ifndef ASSAY_VIEW_MICROMAP_VIEW_H
#define ASSAY_VIEW_MICROMAP_VIEW_H

#include <vulkan/vulkan.h>

#include "src/state/commands/journal.h"
#include "src/view/view.h"

/* The usage counts of a micromap structure. */
struct micromap_usages {
    const char *array_field, *pointers_field; /* relative to the geometry */
    /* If count is not 0, exactly one of these is set and readable. */
    const void *array; /* VkMicromapUsageKHR or VkMicromapUsageEXT, which have the same layout */
    const void *const *pointers;
    uint32_t count;
    bool both_given, array_unreadable, pointers_unreadable;
};

/* A build, for the rules about micromaps. */
struct micromap_build_view {
    const struct build_view *build;
};

/* A geometry with or without micromaps. */
struct micromap_geometry_view {
    const struct geometry_view *geometry;
    bool has_data; /* the chain has a VkAccelerationStructureGeometryMicromapDataKHR */
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
    /* Whether primitive_count is known; the indirect command's is in device memory. */
    bool count_known;
    uint32_t primitive_count;
    /* From level STATE on. */
    struct accel_facts micromap;
    const struct address_facts *indices; /* NULL if there are no indices */
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

/* A micromap that a recorded build uses, and its state when the build executes. */
struct used_micromap_view {
    enum build_command command;
    uint64_t handle;
    const struct journal_micromap *use;
    const struct built *built;
    /* The build of the source if this build is an update; otherwise NULL. */
    const struct built *source;
};

/* The micromaps of one geometry of an update, and of the geometry of the same index that its source
 * was built with. */
struct updated_micromap_view {
    const struct updated_geometry_view *geometry;
    struct micromap_shape requested, source;
};

#endif
