/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's input for micromaps, and for geometries that use them. */
#include "src/snapshots/build_input.h"

#include <stdlib.h>

#include "src/snapshots/input_find.h"

/* If triangles can't be read yet, the amount of their data is unknown. */
void build_input_find_micromap(const struct build_parameters *build,
                               const struct input_memory *memory, struct micromap_input *to)
{
    *to = (struct micromap_input){.type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT};
    if (build->info.geometryCount != 1 || !build->chained)
        return;
    const struct micromap_parameters *from = &build->chained[0].micromap;
    to->type = from->type;
    to->usage_count = from->usage_count;
    to->usages = from->usages;
    to->stride = from->stride;
    uint64_t count = micromap_triangle_count(to);
    if (!count)
        return;
    to->triangles_size = input_find(
        memory, from->triangles,
        input_extent(0, count - 1, to->stride, sizeof(VkMicromapTriangleEXT)), &to->triangles);
    to->data_size = input_find(memory, from->data,
                               memory->is_later ? UINT64_MAX : micromap_data_extent(to), &to->data);
}

/* ---- triangles that use micromaps */

/* Fills in the opacity of `count` triangles. */
static void find_opacity(const struct input_memory *memory,
                         const VkAccelerationStructureTrianglesOpacityMicromapEXT *from,
                         uint64_t count, struct builder_opacity *to)
{
    *to = (struct builder_opacity){
        .index_type = from->indexType,
        .base_triangle = from->baseTriangle,
        .stride = from->indexStride,
        .micromap = (uint64_t)from->micromap,
    };
    if (count && from->indexType != VK_INDEX_TYPE_NONE_KHR)
        to->indices_size =
            input_find(memory, from->indexBuffer,
                       input_extent(0, count - 1, to->stride, input_index_size(from->indexType)),
                       &to->indices);
}

/* Also fills it in if there are no triangles, because a size query tests whether a geometry has
 * opacity. */
static void find_opacities(const struct build_parameters *build, const struct input_memory *memory,
                           struct build_input *input)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        const struct chained_input *chained = &build->chained[i];
        struct builder_geometry *to = &input->geometries[i];
        bool is_dense = geometry_is_dense(&build->geometries[i]);
        uint64_t count = build->ranges[i].primitiveCount;
        if (!chained->has_opacity)
            continue;
        if (is_dense && count)
            count = (uint64_t)to->dense.max_primitive + 1;
        find_opacity(memory, &chained->opacity, count, &input->opacities[i]);
        *(is_dense ? &to->dense.opacity : &to->triangles.opacity) = &input->opacities[i];
    }
}

static void find_displacement(const struct input_memory *memory,
                              const struct build_parameters *build, uint32_t geometry,
                              struct builder_displacement *to)
{
    const VkAccelerationStructureTrianglesDisplacementMicromapNV *from =
        &build->chained[geometry].displacement;
    const VkAccelerationStructureBuildRangeInfoKHR *range = &build->ranges[geometry];
    *to = (struct builder_displacement){
        .usage_count = build->chained[geometry].micromap.usage_count,
        .usages = build->chained[geometry].micromap.usages,
        .vector_format = from->displacementVectorFormat,
        .bias_and_scale_format = from->displacementBiasAndScaleFormat,
        .index_type = from->indexType,
        .base_triangle = from->baseTriangle,
        .vector_stride = from->displacementVectorStride,
        .bias_and_scale_stride = from->displacementBiasAndScaleStride,
        .flags_stride = from->displacedMicromapPrimitiveFlagsStride,
        .index_stride = from->indexStride,
        .micromap = (uint64_t)from->micromap,
    };
    uint64_t count = range->primitiveCount;
    if (!count || !to->micromap || memory->is_for_rules)
        return;
    uint64_t last = range->firstVertex +
                    input_vertices(&build->geometries[geometry].geometry.triangles, range) - 1;
    to->vectors_size =
        input_find(memory, from->displacementVectorBuffer,
                   input_extent(0, last, to->vector_stride, INPUT_VERTEX_MAX), &to->vectors);
    if (from->displacementBiasAndScaleBuffer.deviceAddress) {
        to->biases_and_scales_size =
            input_find(memory, from->displacementBiasAndScaleBuffer,
                       input_extent(0, last, to->bias_and_scale_stride, INPUT_VERTEX_MAX),
                       &to->biases_and_scales);
        if (!to->biases_and_scales)
            to->biases_and_scales = from; /* has them, but none can be read */
    }
    if (from->displacedMicromapPrimitiveFlags.deviceAddress) {
        to->flags_size = input_find(memory, from->displacedMicromapPrimitiveFlags,
                                    input_extent(0, count - 1, to->flags_stride, 1), &to->flags);
        if (!to->flags)
            to->flags = from;
    }
    if (from->indexType != VK_INDEX_TYPE_NONE_KHR)
        to->indices_size = input_find(
            memory, from->indexBuffer,
            input_extent(0, count - 1, to->index_stride, input_index_size(from->indexType)),
            &to->indices);
}

static void find_displacements(const struct build_parameters *build,
                               const struct input_memory *memory, struct build_input *input)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        if (!build->chained[i].has_displacement)
            continue;
        find_displacement(memory, build, i, &input->displacements[i]);
        input->geometries[i].triangles.displacement = &input->displacements[i];
    }
}

enum { HAS_OPACITY = 1, HAS_DISPLACEMENT = 2 };

static unsigned micromaps_of(const struct build_parameters *build)
{
    unsigned found = 0;
    for (uint32_t i = 0; build->chained && i < build->info.geometryCount; i++)
        found |= (build->chained[i].has_opacity ? HAS_OPACITY : 0) |
                 (build->chained[i].has_displacement ? HAS_DISPLACEMENT : 0);
    return found;
}

VkResult build_input_find_micromaps(const struct build_parameters *build,
                                    const struct input_memory *memory, struct build_input *input)
{
    unsigned micromaps = micromaps_of(build);
    uint32_t count = build->info.geometryCount;
    if (micromaps & HAS_OPACITY) {
        input->opacities = calloc(count, sizeof(*input->opacities));
        if (!input->opacities)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        find_opacities(build, memory, input);
    }
    if (micromaps & HAS_DISPLACEMENT) {
        input->displacements = calloc(count, sizeof(*input->displacements));
        if (!input->displacements)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        find_displacements(build, memory, input);
    }
    return VK_SUCCESS;
}
