/* SPDX-License-Identifier: Apache-2.0 */
/* Descriptions of builds, and the shapes that they share. */
#include "state/built.h"

#include <stdlib.h>

#include "state/build_info.h"

static void add_reference(atomic_uint *references)
{
    atomic_fetch_add_explicit(references, 1, memory_order_relaxed);
}

/* Release and acquire: who takes the last one has seen what the other holders did. */
static bool take_reference(atomic_uint *references)
{
    return atomic_fetch_sub_explicit(references, 1, memory_order_acq_rel) == 1;
}

struct built built_share(const struct built *built)
{
    if (built->shapes)
        add_reference(&built->shapes->references);
    if (built->compacted_size)
        add_reference(&built->compacted_size->references);
    return *built;
}

void built_release(struct built *built)
{
    if (built->shapes && take_reference(&built->shapes->references))
        free(built->shapes);
    if (built->compacted_size && take_reference(&built->compacted_size->references))
        free(built->compacted_size);
    *built = (struct built){0};
}

struct compacted_size *compacted_size_create(void)
{
    struct compacted_size *compacted = malloc(sizeof(*compacted));
    if (!compacted)
        return NULL;
    atomic_init(&compacted->references, 1);
    compacted->size = 0;
    return compacted;
}

void compacted_size_learn(struct compacted_size *compacted, VkDeviceSize size)
{
    if (size && (!compacted->size || size < compacted->size))
        compacted->size = size;
}

static struct geometry_shape
describe_geometry(const VkAccelerationStructureGeometryKHR *geometry,
                  const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    struct geometry_shape shape = {.type = geometry->geometryType, .flags = geometry->flags};
    if (range) {
        shape.count_known = true;
        shape.primitive_count = range->primitiveCount;
    }
    if (geometry->geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR) {
        const VkAccelerationStructureGeometryTrianglesDataKHR *t = &geometry->geometry.triangles;
        shape.vertex_format = t->vertexFormat;
        shape.max_vertex = t->maxVertex;
        shape.index_type = t->indexType;
        shape.has_transform = t->transformData.deviceAddress != 0;
    }
    return shape;
}

static struct geometry_shapes *describe_geometries(const struct build_description *description)
{
    uint32_t count = description->info->geometryCount;
    struct geometry_shapes *shapes =
        malloc(sizeof(*shapes) + (size_t)count * sizeof(shapes->items[0]));
    if (!shapes)
        return NULL;
    atomic_init(&shapes->references, 1);
    shapes->count = count;
    shapes->dst_size = description->dst_size;
    shapes->needed_size = description->needed_size;
    for (uint32_t i = 0; i < count; i++)
        shapes->items[i] = describe_geometry(build_geometry(description->info, i),
                                             description->ranges ? &description->ranges[i] : NULL);
    return shapes;
}

struct built built_describe(const struct build_description *description)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = description->info;
    struct built built = {.state = BUILT_BEFORE,
                          .flags = info->flags,
                          .type = info->type,
                          .geometry_count = info->geometryCount,
                          .command_buffer = description->command_buffer,
                          .position = description->position};
    bool may_be_asked = (info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) ||
                        info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    if (!may_be_asked)
        return built;
    built.shapes = describe_geometries(description);
    if (!built.shapes)
        built = (struct built){.state = BUILT_UNKNOWN};
    return built;
}
