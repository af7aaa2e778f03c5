/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that set the state which a dispatch of the layer's own disturbs. */
#include "layer/snapshots/copies/compute_state.h"

#include <stdlib.h>
#include <string.h>

#include "observers.h"
#include "src/base/readable.h"

/* The state of a command buffer without builds so far. Returns NULL without memory. */
static struct compute_state *early_state_of(struct command_buffer *command_buffer)
{
    struct compute_state *state = command_buffer->early_bindings;
    if (!state)
        command_buffer->early_bindings = state = malloc(sizeof(*state));
    if (!state)
        command_buffer->work_failed = true;
    else if (!command_buffer->has_early_bindings)
        *state = (struct compute_state){0};
    command_buffer->has_early_bindings = state;
    return state;
}

struct compute_state *compute_state_of(const struct layer_device *device, VkCommandBuffer handle)
{
    struct command_buffer *command_buffer = command_buffers_find(device->command_buffers, handle);
    if (!command_buffer)
        return NULL;
    struct journal *journal = command_buffer->journal;
    struct recording *recording = journal ? journal->work : NULL;
    return recording ? &recording->compute : early_state_of(command_buffer);
}

void snapshots_bind_pipeline(struct layer_device *device, VkCommandBuffer handle,
                             VkPipelineBindPoint point, VkPipeline pipeline)
{
    struct compute_state *state =
        point == VK_PIPELINE_BIND_POINT_COMPUTE ? compute_state_of(device, handle) : NULL;
    if (state) {
        state->pipeline = pipeline;
        state->shader = VK_NULL_HANDLE;
    }
}

void snapshots_bind_shaders(struct layer_device *device, VkCommandBuffer handle, uint32_t count,
                            const VkShaderStageFlagBits *stages, const VkShaderEXT *shaders)
{
    for (uint32_t i = 0; i < count; i++) {
        struct compute_state *state =
            stages[i] == VK_SHADER_STAGE_COMPUTE_BIT ? compute_state_of(device, handle) : NULL;
        if (!state)
            continue;
        state->pipeline = VK_NULL_HANDLE;
        state->shader = shaders ? shaders[i] : VK_NULL_HANDLE;
    }
}

/* Moves a layout behind all others. Returns false if there are too many layouts. */
static bool note_layout(struct compute_state *state, VkPipelineLayout layout)
{
    uint32_t at = 0;
    while (at < state->pushed_count && state->pushed[at] != layout)
        at++;
    if (at == CONSTANT_LAYOUTS)
        return false;
    if (at == state->pushed_count)
        state->pushed_count++;
    for (; at + 1 < state->pushed_count; at++)
        state->pushed[at] = state->pushed[at + 1];
    state->pushed[at] = layout;
    return true;
}

void snapshots_push(struct layer_device *device, VkCommandBuffer handle, VkPipelineLayout layout,
                    VkShaderStageFlags stages, uint32_t offset, uint32_t size, const void *values)
{
    struct compute_state *state = compute_state_of(device, handle);
    if (!state)
        return;
    if (offset % 4 || size % 4 || offset > sizeof(state->constants) ||
        size > sizeof(state->constants) - offset ||
        !readable(readable_cache_of_thread(), values, size) || !note_layout(state, layout)) {
        state->is_partial = true;
        return;
    }
    memcpy((char *)state->constants + offset, values, size);
    for (uint32_t word = offset / 4; word < (offset + size) / 4; word++) {
        state->stages[word] = stages;
        state->layouts[word] = layout;
    }
}

void snapshots_push_2(struct layer_device *device, VkCommandBuffer handle,
                      const VkPushConstantsInfo *info)
{
    snapshots_push(device, handle, info->layout, info->stageFlags, info->offset, info->size,
                   info->pValues);
}

/* ---- restoring */

/* Pushes consecutive words for the same stages together. */
static void restore_constants(const struct recorder *recorder, const struct compute_state *state,
                              VkPipelineLayout layout)
{
    uint32_t end;
    for (uint32_t begin = 0; begin < CONSTANT_WORDS; begin = end) {
        VkShaderStageFlags stages = state->stages[begin];
        end = begin + 1;
        if (!stages || state->layouts[begin] != layout)
            continue;
        while (end < CONSTANT_WORDS && state->stages[end] == stages &&
               state->layouts[end] == layout)
            end++;
        recorder->device->snapshots->next.CmdPushConstants(recorder->handle, layout, stages,
                                                           begin * 4, (end - begin) * 4,
                                                           &state->constants[begin]);
    }
}

void compute_state_restore(const struct recorder *recorder)
{
    static const VkShaderStageFlagBits stage = VK_SHADER_STAGE_COMPUTE_BIT;
    const struct compute_state *state = &recorder->recording->compute;
    const VkuDeviceDispatchTable *next = &recorder->device->snapshots->next;
    if (state->pipeline)
        next->CmdBindPipeline(recorder->handle, VK_PIPELINE_BIND_POINT_COMPUTE, state->pipeline);
    if (state->shader)
        next->CmdBindShadersEXT(recorder->handle, 1, &stage, &state->shader);
    for (uint32_t i = 0; i < state->pushed_count; i++)
        restore_constants(recorder, state, state->pushed[i]);
}
