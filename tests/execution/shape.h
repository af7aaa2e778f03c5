/* SPDX-License-Identifier: Apache-2.0 */
/* Builds reduced to what updates are judged by, and pairs of them that no update may join. */
#ifndef EXECUTION_SHAPE_H
#define EXECUTION_SHAPE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

enum { SHAPE_GEOMETRIES = 2, SHAPE_WORDS_SIZE = 256 };

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
    uint32_t primitive_count;
};

/* A build of one triangle geometry, with everything. */
struct shape shape_plain(void);

/* The options of such a build in a program. */
void shape_write(const struct shape *shape, char words[SHAPE_WORDS_SIZE]);

/* An update that asks for `asked` of a source that was last built as `built` breaks a rule. */
struct difference {
    struct shape built, asked;
};

enum { DIFFERENCES = 12 };

extern struct difference differences[DIFFERENCES];
void differences_fill(void);

#endif
