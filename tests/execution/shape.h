/* SPDX-License-Identifier: Apache-2.0 */
/* Builds reduced to what updates are judged by, and pairs of them that no update may join. */
#ifndef EXECUTION_SHAPE_H
#define EXECUTION_SHAPE_H

#include "scene.h"
#include "tests/fixture/make.h"

/* All geometries of a build are alike. */
struct shape {
    VkBuildAccelerationStructureFlagsKHR flags;
    VkAccelerationStructureTypeKHR type;
    uint32_t geometry_count; /* up to SHAPE_GEOMETRIES */
    VkGeometryTypeKHR geometry_type;
    VkGeometryFlagsKHR geometry_flags;
    VkFormat vertex_format; /* these four: triangles only */
    uint32_t max_vertex;
    VkIndexType index_type;
    bool has_transform;
    bool moves; /* VK_NV_ray_tracing_motion_blur: triangles have second positions */
    uint32_t primitive_count;
    struct {
        uint32_t triangles, vertices, max_primitive, max_geometry;
        VkDeviceSize size; /* bytes */
    } dense;               /* geometries of VK_AMDX_dense_geometry_format only */
};

enum { SHAPE_GEOMETRIES = 2, SHAPE_RULES = 1 };

/* A build of one triangle geometry, with everything. */
struct shape shape_plain(void);
struct shape shape_boxes(void);

/* Defines a function that returns the shape of `base` but for one member. */
#define SHAPE_BUT(name, base, member, value)                                                       \
    static struct shape name(void)                                                                 \
    {                                                                                              \
        struct shape shape = base();                                                               \
        shape.member = value;                                                                      \
        return shape;                                                                              \
    }

/* The arguments of a build of that shape; they refer to each other. */
struct shape_arguments {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometries[SHAPE_GEOMETRIES];
    VkAccelerationStructureBuildRangeInfoKHR ranges[SHAPE_GEOMETRIES];
    const VkAccelerationStructureBuildRangeInfoKHR *range_pointer;
    uint32_t counts[SHAPE_GEOMETRIES];
    const uint32_t *count_pointer;
    union shape_extension {
        VkAccelerationStructureGeometryMotionTrianglesDataNV motion;
        VkAccelerationStructureGeometrySpheresDataNV spheres;
        VkAccelerationStructureGeometryLinearSweptSpheresDataNV swept;
        VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX dense;
    } chained[SHAPE_GEOMETRIES];
};

/* Inputs are those of the scene, at their addresses for the device or the host; dst, src and
 * scratch are left to the caller. */
void shape_fill(struct shape_arguments *arguments, const struct scene *scene,
                const struct shape *shape, bool by_host);

/* What a build of that shape needs. */
VkAccelerationStructureBuildSizesInfoKHR shape_sizes(const struct scene *scene,
                                                     const struct shape *shape);

/* An update that asks for `asked` of a source that was last built as `built` breaks the rules. */
struct difference {
    const char *name;
    enum rule rules[SHAPE_RULES];
    uint32_t rule_count;
    const char *path; /* below pInfos[0] */
    struct shape built, asked;
};

enum { DIFFERENCES = 12 };

extern struct difference differences[DIFFERENCES];
void differences_fill(void);

#endif
