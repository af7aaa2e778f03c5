/* SPDX-License-Identifier: Apache-2.0 */
/* What is bound in a command buffer when a command runs shaders: pipelines, descriptor sets and
 * push constants. For setting `hazards`; owned by the journal. */
#ifndef ASSAY_STATE_COMMANDS_BOUND_SHADERS_H
#define ASSAY_STATE_COMMANDS_BOUND_SHADERS_H

#include "src/shaders/launch.h"
#include "src/state/resources/descriptors.h"

/* Bind points. */
enum shader_point { SHADERS_OF_COMPUTE, SHADERS_OF_RAYS, SHADERS_OF_GRAPHICS, SHADER_POINTS };
enum { BOUND_SETS = 8 }; /* others are unknown */

struct bound_shaders {
    uint64_t pipelines[SHADER_POINTS];        /* handles; 0: unknown */
    uint64_t sets[SHADER_POINTS][BOUND_SETS]; /* handles; 0: unknown */
    /* Pushed descriptors, which stand in place of the set of that number; BOUND_SETS: none. */
    struct held_set pushed[SHADER_POINTS];
    uint32_t pushed_set[SHADER_POINTS];
    struct pushed_constants constants[SHADER_POINTS];
};

/* Returns `*bound`, which is created if it is NULL. Returns NULL if memory runs out: nothing is
 * known then. */
struct bound_shaders *bound_shaders_change(struct bound_shaders **bound);
/* Accepts NULL. */
void bound_shaders_free(struct bound_shaders *bound);

void bound_shaders_bind_set(struct bound_shaders *bound, enum shader_point point, uint32_t set,
                            uint64_t handle);
/* Notes that descriptors are pushed to a set. Returns what the set holds so far; NULL: the set is
 * not followed. */
struct held_set *bound_shaders_push(struct bound_shaders *bound, enum shader_point point,
                                    uint32_t set);
/* Finds descriptors as descriptor_sets_find() does. */
uint32_t bound_shaders_find(const struct bound_shaders *bound, struct descriptor_sets *sets,
                            enum shader_point point, uint32_t set, uint32_t binding,
                            struct held_descriptor *found, uint32_t count);
/* The values become those of the bind points whose stages are named, and are unknown for the
 * others: their layout is another one. */
void bound_shaders_push_constants(struct bound_shaders *bound, VkShaderStageFlags stages,
                                  uint32_t offset, uint32_t size, const void *values);
/* The stages of a bind point; 0: it has none of the points. */
VkShaderStageFlags shader_stages_of(VkPipelineBindPoint bind_point);
/* Whether one of the stages belongs to a bind point. */
bool shader_point_has(enum shader_point point, VkShaderStageFlags stages);

#endif
