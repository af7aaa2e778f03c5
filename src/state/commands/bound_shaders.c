/* SPDX-License-Identifier: Apache-2.0 */
#include "src/state/commands/bound_shaders.h"

#include <stdlib.h>
#include <string.h>

struct bound_shaders *bound_shaders_change(struct bound_shaders **bound)
{
    if (*bound)
        return *bound;
    *bound = calloc(1, sizeof(**bound));
    for (unsigned i = 0; *bound && i < SHADER_POINTS; i++)
        (*bound)->pushed_set[i] = BOUND_SETS;
    return *bound;
}

void bound_shaders_free(struct bound_shaders *bound)
{
    for (unsigned i = 0; bound && i < SHADER_POINTS; i++)
        held_set_clear(&bound->pushed[i]);
    free(bound);
}

void bound_shaders_bind_set(struct bound_shaders *bound, enum shader_point point, uint32_t set,
                            uint64_t handle)
{
    if (set >= BOUND_SETS)
        return;
    bound->sets[point][set] = handle;
    if (bound->pushed_set[point] == set)
        bound->pushed_set[point] = BOUND_SETS;
}

struct held_set *bound_shaders_push(struct bound_shaders *bound, enum shader_point point,
                                    uint32_t set)
{
    if (set >= BOUND_SETS)
        return NULL;
    if (bound->pushed_set[point] != set)
        held_set_clear(&bound->pushed[point]);
    bound->pushed_set[point] = set;
    return &bound->pushed[point];
}

uint32_t bound_shaders_find(const struct bound_shaders *bound, struct descriptor_sets *sets,
                            enum shader_point point, uint32_t set, uint32_t binding,
                            struct held_descriptor *found, uint32_t count)
{
    if (set >= BOUND_SETS)
        return UINT32_MAX;
    if (bound->pushed_set[point] == set)
        return held_set_find(&bound->pushed[point], binding, found, count);
    return descriptor_sets_find(sets, bound->sets[point][set], binding, found, count);
}

/* The stages of each bind point. */
static const VkShaderStageFlags stages_of_point[SHADER_POINTS] = {
    [SHADERS_OF_COMPUTE] = VK_SHADER_STAGE_COMPUTE_BIT,
    [SHADERS_OF_RAYS] = VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR |
                        VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR | VK_SHADER_STAGE_MISS_BIT_KHR |
                        VK_SHADER_STAGE_INTERSECTION_BIT_KHR | VK_SHADER_STAGE_CALLABLE_BIT_KHR,
    [SHADERS_OF_GRAPHICS] =
        VK_SHADER_STAGE_ALL_GRAPHICS | VK_SHADER_STAGE_TASK_BIT_EXT | VK_SHADER_STAGE_MESH_BIT_EXT,
};

VkShaderStageFlags shader_stages_of(VkPipelineBindPoint bind_point)
{
    switch (bind_point) {
    case VK_PIPELINE_BIND_POINT_COMPUTE:
        return stages_of_point[SHADERS_OF_COMPUTE];
    case VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR:
        return stages_of_point[SHADERS_OF_RAYS];
    case VK_PIPELINE_BIND_POINT_GRAPHICS:
        return stages_of_point[SHADERS_OF_GRAPHICS];
    default:
        return 0;
    }
}

bool shader_point_has(enum shader_point point, VkShaderStageFlags stages)
{
    return stages & stages_of_point[point];
}

/* Offset and size are multiples of 4, or the call is invalid. */
static void push(struct pushed_constants *constants, bool is_known, uint32_t offset, uint32_t size,
                 const void *values)
{
    for (uint32_t i = 0; i < size / 4 && offset / 4 + i < PUSHED_BYTES / 4; i++) {
        const uint32_t word = offset / 4 + i;
        memcpy(&constants->words[word], (const char *)values + (size_t)i * 4, 4);
        constants->known &= ~(UINT64_C(1) << word);
        constants->known |= (uint64_t)is_known << word;
    }
}

void bound_shaders_push_constants(struct bound_shaders *bound, VkShaderStageFlags stages,
                                  uint32_t offset, uint32_t size, const void *values)
{
    for (unsigned i = 0; i < SHADER_POINTS; i++)
        push(&bound->constants[i], shader_point_has((enum shader_point)i, stages), offset, size,
             values);
}
