/* SPDX-License-Identifier: Apache-2.0 */
/* What cases of displaced triangles share. */
#include "displaced.h"

void open_displaced(struct displaced *displaced, uint32_t format, uint32_t count,
                    const uint8_t *levels, encoder_value *value, void *context,
                    const float *vectors, uint64_t vectors_size)
{
    displaced->coded = fixture_allocate(count * sizeof(*displaced->coded));
    displaced->micromap = encoder_micromap(format, count, levels, value, context, displaced->usages,
                                           displaced->coded);
    displaced->displacement = (struct builder_displacement){
        .usage_count = 6,
        .usages = displaced->usages,
        .vector_format = VK_FORMAT_R32G32B32_SFLOAT,
        .bias_and_scale_format = VK_FORMAT_R32G32_SFLOAT,
        .index_type = VK_INDEX_TYPE_NONE_KHR,
        .vectors = vectors,
        .vectors_size = vectors_size,
        .vector_stride = 12,
        .bias_and_scale_stride = 8,
        .micromap = (uintptr_t)displaced->micromap,
    };
}

uint16_t random_value(void *context, uint32_t triangle, uint32_t level, uint32_t u, uint32_t v)
{
    (void)triangle;
    (void)level;
    (void)u;
    (void)v;
    return (uint16_t)(fixture_random(context) & 2047);
}
