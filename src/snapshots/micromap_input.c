/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's input for micromaps, and for geometries that use them. */
#include "src/snapshots/build_input.h"

#include <stdlib.h>

#include "src/model/inputs.h"

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
    if (memory->is_host && from->is_khr)
        return;
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const uint32_t count = inputs_of_geometry(build->info.flags, &build->geometries[0],
                                              &build->chained[0], NULL, inputs);
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t address = inputs[i].address.deviceAddress;
        if (inputs[i].role == INPUT_MICROMAP_TRIANGLES)
            to->triangles_size =
                memory->find(memory->context, address, input_end(&inputs[i]), &to->triangles);
        else if (!memory->is_for_rules)
            to->data_size =
                memory->find(memory->context, address,
                             memory->is_later ? UINT64_MAX : micromap_data_extent(to), &to->data);
    }
}

/* ---- triangles that use micromaps
 *
 * Also described if there are no triangles, because a size query tests whether a geometry has
 * opacity. */

static void describe_opacities(const struct build_parameters *build, struct build_input *input)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        const struct chained_input *chained = &build->chained[i];
        const VkAccelerationStructureTrianglesOpacityMicromapEXT *from = &chained->opacity;
        struct builder_geometry *to = &input->geometries[i];
        if (!chained->has_opacity)
            continue;
        input->opacities[i] = (struct builder_opacity){
            .index_type = from->indexType,
            .base_triangle = from->baseTriangle,
            .stride = from->indexStride,
            .micromap = (uint64_t)from->micromap,
        };
        *(type_is_dense(build->geometries[i].geometryType) ? &to->dense.opacity
                                                           : &to->triangles.opacity) =
            &input->opacities[i];
    }
}

static void describe_displacements(const struct build_parameters *build, struct build_input *input)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        const VkAccelerationStructureTrianglesDisplacementMicromapNV *from =
            &build->chained[i].displacement;
        if (!build->chained[i].has_displacement)
            continue;
        input->displacements[i] = (struct builder_displacement){
            .usage_count = build->chained[i].micromap.usage_count,
            .usages = build->chained[i].micromap.usages,
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

VkResult build_input_describe_micromaps(const struct build_parameters *build,
                                        struct build_input *input)
{
    const unsigned micromaps = micromaps_of(build);
    const uint32_t count = build->info.geometryCount;
    if (micromaps & HAS_OPACITY) {
        input->opacities = calloc(count, sizeof(*input->opacities));
        if (!input->opacities)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        describe_opacities(build, input);
    }
    if (micromaps & HAS_DISPLACEMENT) {
        input->displacements = calloc(count, sizeof(*input->displacements));
        if (!input->displacements)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        describe_displacements(build, input);
    }
    return VK_SUCCESS;
}
