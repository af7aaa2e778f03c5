/* SPDX-License-Identifier: Apache-2.0 */
/* Displacements of any kind, of the fuzz target's data. */
#include "fuzz_displaced.h"

/* A block of displacements, used at several levels. */
const void *fuzz_find_displacing(void *context, uint64_t reference)
{
    static _Alignas(BUILDER_ALIGNMENT) uint8_t micromap[2048];
    static const VkMicromapUsageEXT usages[3] = {{1, 1, 1}, {1, 4, 1}, {1, 5, 3}};
    static const VkMicromapTriangleEXT triangles[3] = {{0, 1, 1}, {0, 4, 1}, {0, 5, 3}};
    const struct span *data = context;
    const struct micromap_input input = {VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV,
                                         3,
                                         usages,
                                         data->bytes,
                                         triangles,
                                         data->size,
                                         sizeof(triangles),
                                         sizeof(triangles[0])};
    return reference == 1 && micromap_build(&input, micromap, sizeof(micromap)) == BUILDER_OK
               ? micromap
               : NULL;
}

struct builder_displacement fuzz_displacement(const struct span *data, VkIndexType index_type,
                                              uint32_t flags)
{
    static const VkMicromapUsageEXT usages[3] = {{2000, 1, 1}, {7, 4, 1}, {3, 5, 3}};
    static uint8_t indices[2000]; /* mostly good ones: level 1, now and then a special one */
    bool is_random = flags % 16 == 5;
    for (uint32_t i = 0; indices[4] == 0 && i < sizeof(indices); i++)
        indices[i] = i % 5 == 4 ? 0xff : i % 200 == 3 ? 1 : i % 400 == 6 ? 2 : 0;
    return (struct builder_displacement){
        .usage_count = 3,
        .usages = usages,
        .vector_format = VK_FORMAT_R16G16B16_SFLOAT,
        .bias_and_scale_format = VK_FORMAT_R16G16_SNORM,
        .index_type = is_random ? index_type : VK_INDEX_TYPE_UINT8_KHR,
        .base_triangle = is_random ? flags >> 13 & 1 : 0,
        .vectors = data->bytes,
        .biases_and_scales = flags & 0x200 ? data->bytes : NULL,
        .flags = data->bytes,
        .indices = is_random ? data->bytes : indices,
        .vectors_size = data->size,
        .biases_and_scales_size = data->size,
        .flags_size = data->size,
        .indices_size = is_random ? data->size : sizeof(indices),
        .vector_stride = flags >> 12,
        .bias_and_scale_stride = flags >> 14,
        .flags_stride = flags & 1,
        .index_stride = is_random ? flags >> 15 : 1,
        .micromap = flags % 8 == 3 ? flags >> 12 & 3 : 1,
    };
}

void fuzz_make_likely(struct builder_triangles *triangles,
                      VkAccelerationStructureBuildRangeInfoKHR *range, uint32_t flags)
{
    if (flags % 16 == 5)
        return;
    triangles->vertex_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    triangles->index_type = VK_INDEX_TYPE_NONE_KHR;
    triangles->max_vertex = UINT32_MAX;
    triangles->vertex_stride %= 9;
    range->primitiveCount %= 50;
}
