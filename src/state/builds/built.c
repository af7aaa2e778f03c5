/* SPDX-License-Identifier: Apache-2.0 */
/* Makes, shares and releases descriptions of builds, their inputs and shapes. */
#include "src/state/builds/built.h"

#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

#include "src/base/chain.h"

struct build_inputs *build_inputs_share(struct build_inputs *inputs); /* may be NULL */

struct build_inputs *build_inputs_create(uint32_t count)
{
    struct build_inputs *inputs =
        calloc(1, sizeof(*inputs) + (size_t)count * sizeof(inputs->items[0]));
    if (!inputs)
        return NULL;
    atomic_init(&inputs->references, 1);
    atomic_init(&inputs->is_known, false);
    inputs->count = count;
    return inputs;
}

struct build_inputs *build_inputs_share(struct build_inputs *inputs)
{
    if (inputs)
        atomic_fetch_add_explicit(&inputs->references, 1, memory_order_relaxed);
    return inputs;
}

struct kept_block *kept_block_share(struct kept_block *block)
{
    atomic_fetch_add_explicit(&block->references, 1, memory_order_relaxed);
    return block;
}

void kept_block_release(struct kept_block *block)
{
    if (block && atomic_fetch_sub_explicit(&block->references, 1, memory_order_acq_rel) == 1)
        free(block);
}

struct kept_indices *kept_indices_create(const void *bytes, uint64_t size, uint32_t max)
{
    struct kept_indices *indices = malloc(sizeof(*indices) + size);
    if (!indices)
        return NULL;
    atomic_init(&indices->block.references, 1);
    indices->max = max;
    indices->size = size;
    memcpy(indices->bytes, bytes, size);
    return indices;
}

void build_inputs_release(struct build_inputs *inputs)
{
    if (!inputs || atomic_fetch_sub_explicit(&inputs->references, 1, memory_order_acq_rel) != 1)
        return;
    for (uint32_t i = 0; i < inputs->count; i++) {
        free(inputs->items[i].inactive);
        kept_block_release((struct kept_block *)inputs->items[i].indices);
        kept_block_release(inputs->items[i].kept);
    }
    free(inputs);
}

void build_inputs_mark_known(struct build_inputs *inputs)
{
    if (inputs)
        atomic_store_explicit(&inputs->is_known, true, memory_order_release);
}

const struct geometry_inputs *build_inputs_of(const struct build_inputs *inputs, uint32_t geometry)
{
    return inputs && geometry < inputs->count &&
                   atomic_load_explicit(&inputs->is_known, memory_order_acquire)
               ? &inputs->items[geometry]
               : NULL;
}

/* ---- makes, shares and releases descriptions of builds and their shapes */

static void add_reference(atomic_uint *references)
{
    atomic_fetch_add_explicit(references, 1, memory_order_relaxed);
}

/* Returns true if this was the last reference. Acquire and release: the thread that frees the
 * object must see the other threads' accesses done. */
static bool drop_reference(atomic_uint *references)
{
    return atomic_fetch_sub_explicit(references, 1, memory_order_acq_rel) == 1;
}

struct built built_share(const struct built *built)
{
    if (built->shapes)
        add_reference(&built->shapes->references);
    if (built->compacted_size)
        add_reference(&built->compacted_size->references);
    build_inputs_share(built_inputs(built));
    return *built;
}

void built_release(struct built *built)
{
    build_inputs_release(built_inputs(built));
    if (built->shapes && drop_reference(&built->shapes->references))
        free(built->shapes);
    if (built->compacted_size && drop_reference(&built->compacted_size->references))
        free(built->compacted_size);
    *built = (struct built){0};
}

struct compacted_size *compacted_size_create(uint64_t id)
{
    struct compacted_size *compacted = malloc(sizeof(*compacted));
    if (!compacted)
        return NULL;
    atomic_init(&compacted->references, 1);
    compacted->size = compacted->serialized = compacted->full = 0;
    compacted->serialized_id = id;
    compacted->full_is_queried = false;
    return compacted;
}

void compacted_size_update(struct compacted_size *compacted, VkDeviceSize size)
{
    if (size && (!compacted->size || size < compacted->size))
        compacted->size = size;
}

/* Returns the offset of the dense shapes, which follow `count` items. */
static size_t dense_offset(uint32_t count)
{
    size_t end = sizeof(struct geometry_shapes) + (size_t)count * sizeof(struct geometry_shape);
    size_t alignment = _Alignof(struct dense_shape);
    return (end + alignment - 1) / alignment * alignment;
}

const struct dense_shape *built_dense_shapes(const struct geometry_shapes *shapes)
{
    return (const void *)((const char *)shapes + dense_offset(shapes->count));
}

static struct dense_shape
describe_dense(uint32_t index,
               const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *data)
{
    return (struct dense_shape){.geometry = index,
                                .triangle_count = data->numTriangles,
                                .vertex_count = data->numVertices,
                                .max_primitive_index = data->maxPrimitiveIndex,
                                .max_geometry_index = data->maxGeometryIndex,
                                .format = (uint32_t)data->format,
                                .data_size = data->dataSize};
}

/* Returns false if a dense geometry has no data. */
static bool describe_all_dense(const struct build_description *description,
                               struct geometry_shapes *shapes)
{
    struct dense_shape *next = (void *)((char *)shapes + dense_offset(shapes->count));
    for (uint32_t i = 0; i < shapes->count; i++) {
        const VkAccelerationStructureGeometryKHR *geometry = build_geometry(description->info, i);
        if (!type_is_dense(geometry->geometryType))
            continue;
        const void *data = chain_find(
            geometry->pNext,
            VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX);
        if (!data)
            return false;
        *next++ = describe_dense(i, data);
    }
    return true;
}

static uint32_t count_dense(const struct build_description *description)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < description->info->geometryCount; i++)
        if (type_is_dense(build_geometry(description->info, i)->geometryType))
            count++;
    return count;
}

static size_t micromaps_offset(uint32_t count, uint32_t dense_count)
{
    _Static_assert(sizeof(struct dense_shape) % _Alignof(struct micromap_shape) == 0,
                   "micromaps can lie behind dense shapes");
    _Static_assert(_Alignof(struct dense_shape) % _Alignof(struct micromap_shape) == 0,
                   "and those behind geometries");
    return dense_offset(count) + (size_t)dense_count * sizeof(struct dense_shape);
}

struct micromap_shape built_micromap_shape(const struct geometry_shapes *shapes, uint32_t geometry)
{
    const void *micromaps =
        (const char *)shapes + micromaps_offset(shapes->count, shapes->dense_count);
    return shapes->has_micromaps ? ((const struct micromap_shape *)micromaps)[geometry]
                                 : (struct micromap_shape){0};
}

static void describe_micromaps(const struct micromap_uses *uses, struct geometry_shapes *shapes)
{
    void *begin = (char *)shapes + micromaps_offset(shapes->count, shapes->dense_count);
    struct micromap_shape *micromaps = begin;
    for (uint32_t i = 0; i < shapes->count; i++)
        micromaps[i] = (struct micromap_shape){0};
    for (uint32_t i = 0; i < uses->count; i++)
        if (!uses->items[i].is_ext)
            micromaps[uses->items[i].geometry] =
                (struct micromap_shape){.handle = uses->items[i].handle, .given = true};
}

/* The usage counts of a micromap build give the number of its triangles. */
static void describe_built_micromap(const struct micromap_uses *uses,
                                    struct geometry_shapes *shapes)
{
    shapes->items[0].count_known = uses->built_count_known;
    shapes->items[0].primitive_count = uses->built_triangle_count;
}

/* Without dense geometries and micromaps, only the items are allocated. */
static struct geometry_shapes *allocate_shapes(uint32_t count, uint32_t dense_count,
                                               bool has_micromaps)
{
    size_t size = sizeof(struct geometry_shapes) + (size_t)count * sizeof(struct geometry_shape);
    if (dense_count || has_micromaps)
        size = micromaps_offset(count, dense_count);
    if (has_micromaps)
        size += (size_t)count * sizeof(struct micromap_shape);
    struct geometry_shapes *shapes = malloc(size);
    if (!shapes)
        return NULL;
    atomic_init(&shapes->references, 1);
    shapes->has_micromaps = has_micromaps;
    shapes->count = count;
    shapes->dense_count = dense_count;
    return shapes;
}

struct geometry_shapes *built_with_micromaps(uint32_t count, const struct micromap_shape *micromaps)
{
    struct geometry_shapes *shapes = allocate_shapes(count, 0, true);
    if (!shapes)
        return NULL;
    shapes->dst_size = shapes->needed_size = 0;
    memset(shapes->items, 0, count * sizeof(shapes->items[0]));
    memcpy((char *)shapes + micromaps_offset(count, 0), micromaps, count * sizeof(*micromaps));
    return shapes;
}

static bool is_micromap(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    return info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

struct geometry_shapes *geometry_shapes_create(const struct build_description *description)
{
    uint32_t dense_count = count_dense(description);
    const struct micromap_uses *micromaps = description->micromaps;
    if ((dense_count && !description->dense_readable) ||
        (micromaps && unknown_is_set(&micromaps->unknown)))
        return NULL;
    struct geometry_shapes *shapes = allocate_shapes(description->info->geometryCount, dense_count,
                                                     micromaps && micromaps->count);
    if (!shapes)
        return NULL;
    shapes->dst_size = description->dst_size;
    shapes->needed_size = description->needed_size;
    for (uint32_t i = 0; i < shapes->count; i++)
        shapes->items[i] =
            geometry_shape_of(build_geometry(description->info, i),
                              description->ranges ? &description->ranges[i].primitiveCount : NULL);
    if (shapes->has_micromaps)
        describe_micromaps(micromaps, shapes);
    if (micromaps && is_micromap(description->info) && shapes->count)
        describe_built_micromap(micromaps, shapes);
    if (dense_count && !describe_all_dense(description, shapes)) {
        free(shapes);
        return NULL;
    }
    return shapes;
}

void built_forget(struct built *built)
{
    *built = (struct built){.state = BUILT_UNKNOWN, .position = built->position};
}

void built_add_shapes(struct built *built, const struct build_description *description)
{
    built->shapes = geometry_shapes_create(description);
    if (built->shapes)
        built->inputs = build_inputs_share(description->inputs);
    else
        built_forget(built);
}
