/* SPDX-License-Identifier: Apache-2.0 */
/* Shapes, and one difference for each rule about updates. */
#include "shape.h"

#include <stdio.h>

enum {
    ALLOW_UPDATE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
    ALLOW_COMPACTION = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
    FAST_TRACE = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR,
};

struct shape shape_plain(void)
{
    return (struct shape){
        .flags = ALLOW_UPDATE | ALLOW_COMPACTION,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .geometry_count = 1,
        .geometry_type = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .vertex_format = VK_FORMAT_R32G32B32_SFLOAT,
        .max_vertex = 5,
        .index_type = VK_INDEX_TYPE_UINT32,
        .has_transform = true,
        .primitive_count = 2,
    };
}

enum { INPUT_SIZE = 128 };

static void write_triangles(const struct shape *shape, char words[INPUT_SIZE])
{
    snprintf(words, INPUT_SIZE, "plain%s%s%s",
             shape->index_type == VK_INDEX_TYPE_UINT16 ? " short-indices I1" : "",
             shape->vertex_format == VK_FORMAT_R16G16B16A16_SFLOAT ? " format rgba16" : "",
             shape->has_transform ? "" : " no-transform");
}

/* The geometry comes first, as it replaces what is said of one before; `max` behind `primitives`.
 */
void shape_write(const struct shape *shape, char words[SHAPE_WORDS_SIZE])
{
    char input[INPUT_SIZE] = "boxes A0", max[16] = "";
    if (shape->geometry_type == VK_GEOMETRY_TYPE_TRIANGLES_KHR) {
        write_triangles(shape, input);
        snprintf(max, sizeof(max), " max %u", shape->max_vertex);
    } else if (shape->geometry_type == VK_GEOMETRY_TYPE_INSTANCES_KHR) {
        snprintf(input, sizeof(input), "instances N0");
    }
    snprintf(words, SHAPE_WORDS_SIZE, "%s%s primitives %u%s geometries %u flags none%s%s%s", input,
             shape->geometry_flags ? " opaque" : "", shape->primitive_count, max,
             shape->geometry_count, shape->flags & ALLOW_UPDATE ? "|update" : "",
             shape->flags & ALLOW_COMPACTION ? "|compaction" : "",
             shape->flags & FAST_TRACE ? "|fast_trace" : "");
}

struct difference differences[DIFFERENCES];

void differences_fill(void)
{
    for (uint32_t i = 0; i < DIFFERENCES; i++)
        differences[i].built = differences[i].asked = shape_plain();
    differences[0].built.flags = ALLOW_COMPACTION;
    differences[1].built.geometry_count = 2;
    differences[2].built.flags |= FAST_TRACE;
    differences[3].asked.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    differences[3].asked.geometry_type = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    differences[4].built.geometry_type = VK_GEOMETRY_TYPE_AABBS_KHR;
    differences[5].built.geometry_flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    differences[6].built.vertex_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    differences[7].built.max_vertex = 6;
    differences[8].built.index_type = VK_INDEX_TYPE_UINT16;
    differences[9].built.has_transform = false;
    differences[10].asked.has_transform = false;
    differences[11].built.primitive_count = 1;
}
