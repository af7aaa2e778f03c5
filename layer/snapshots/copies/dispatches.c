/* SPDX-License-Identifier: Apache-2.0 */
/* Pipelines of the layer's own, and dispatches that leave the command buffer's state unchanged:
 * commands set again what a dispatch disturbs. */
#include "layer/snapshots/copies/copies.h"

#include <stdlib.h>
#include <string.h>

#include "copy_comp.h"
#include "gather_comp.h"
#include "guard_comp.h"
#include "layer/snapshots/marks.h"
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

void snapshots_push(struct layer_device *device, VkCommandBuffer handle,
                    const VkPushConstantsInfo *info)
{
    const uint32_t offset = info->offset, size = info->size;
    struct compute_state *state = compute_state_of(device, handle);
    if (!state)
        return;
    if (offset % 4 || size % 4 || offset > sizeof(state->constants) ||
        size > sizeof(state->constants) - offset ||
        !readable(readable_cache_of_thread(), info->pValues, size) ||
        !note_layout(state, info->layout)) {
        state->is_partial = true;
        return;
    }
    memcpy((char *)state->constants + offset, info->pValues, size);
    for (uint32_t word = offset / 4; word < (offset + size) / 4; word++) {
        state->stages[word] = info->stageFlags;
        state->layouts[word] = info->layout;
    }
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

static void compute_state_restore(const struct recorder *recorder)
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

/* ---- pipelines and dispatches */

static const struct {
    const uint32_t *words;
    size_t size;
} codes[SHADER_COUNT] = {
    [SHADER_COPY] = {copy_comp, sizeof(copy_comp)},
    [SHADER_GATHER] = {gather_comp, sizeof(gather_comp)},
    [SHADER_GUARD] = {guard_comp, sizeof(guard_comp)},
};

struct own_shaders {
    const struct layer_device *device;
    pthread_mutex_t lock;    /* guards the members below; held while they are created */
    VkPipelineLayout layout; /* used by all pipelines */
    VkPipeline pipelines[SHADER_COUNT];
};

/* ---- pipelines */

VkResult own_shaders_create(const struct layer_device *device, struct own_shaders **shaders)
{
    *shaders = calloc(1, sizeof(**shaders));
    if (!*shaders)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*shaders)->device = device;
    pthread_mutex_init(&(*shaders)->lock, NULL);
    return VK_SUCCESS;
}

void own_shaders_destroy(struct own_shaders *shaders)
{
    if (!shaders)
        return;
    const VkuDeviceDispatchTable *next = &shaders->device->snapshots->next;
    for (int i = 0; i < SHADER_COUNT; i++)
        if (shaders->pipelines[i])
            next->DestroyPipeline(shaders->device->handle, shaders->pipelines[i], NULL);
    if (shaders->layout)
        next->DestroyPipelineLayout(shaders->device->handle, shaders->layout, NULL);
    pthread_mutex_destroy(&shaders->lock);
    free(shaders);
}

static VkResult create_layout(const struct layer_device *device, VkPipelineLayout *layout)
{
    const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                                       .size = SHADER_CONSTANTS_MAX};
    const VkPipelineLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range,
    };
    return device->snapshots->next.CreatePipelineLayout(device->handle, &info, NULL, layout);
}

static bool make_pipeline(struct snapshots *snapshots, enum own_shader shader)
{
    struct own_shaders *shaders = snapshots->shaders;
    const struct own_device own = snapshots_own_device(snapshots);
    VkPipeline *pipeline = &shaders->pipelines[shader];
    pthread_mutex_lock(&shaders->lock);
    VkResult result = VK_SUCCESS;
    if (!shaders->layout)
        result = create_layout(shaders->device, &shaders->layout);
    if (result == VK_SUCCESS && !*pipeline)
        result = own_compute_create(&own, codes[shader].words, codes[shader].size, shaders->layout,
                                    pipeline);
    pthread_mutex_unlock(&shaders->lock);
    return result == VK_SUCCESS;
}

bool dispatches_prepare(const struct recorder *recorder, enum own_shader shader)
{
    struct snapshots *snapshots = recorder->device->snapshots;
    struct mapped_words *gate = &recorder->recording->gate;
    return (gate->words || words_take(snapshots->words, gate)) && make_pipeline(snapshots, shader);
}

/* ---- conditional rendering: it applies to dispatches, but not to builds and copies */

static void end_condition(const struct recorder *recorder)
{
    if (recorder->recording->compute.condition.kind != CONDITION_NONE)
        recorder->device->snapshots->next.CmdEndConditionalRenderingEXT(recorder->handle);
}

static void begin_condition(const struct recorder *recorder)
{
    const VkuDeviceDispatchTable *next = &recorder->device->snapshots->next;
    const struct condition *condition = &recorder->recording->compute.condition;
    const VkConditionalRenderingBeginInfoEXT in_buffer = {
        .sType = VK_STRUCTURE_TYPE_CONDITIONAL_RENDERING_BEGIN_INFO_EXT,
        .buffer = condition->buffer,
        .offset = condition->offset,
        .flags = condition->flags,
    };
    const VkConditionalRenderingBeginInfo2EXT at_address = {
        .sType = VK_STRUCTURE_TYPE_CONDITIONAL_RENDERING_BEGIN_INFO_2_EXT,
        .addressRange = condition->range,
        .addressFlags = condition->address_flags,
        .flags = condition->flags,
    };
    if (condition->kind == CONDITION_IN_BUFFER)
        next->CmdBeginConditionalRenderingEXT(recorder->handle, &in_buffer);
    if (condition->kind == CONDITION_AT_ADDRESS)
        next->CmdBeginConditionalRendering2EXT(recorder->handle, &at_address);
}

/* ---- dispatches */

/* Allowed if all state that a dispatch disturbs is known and can be restored, no query counts the
 * dispatch, and no condition of a primary command buffer can discard it. Backend cpu needs the
 * data, so there only addresses and a compute queue are required. */
bool dispatches_are_allowed(const struct recorder *recorder)
{
    const struct command_buffer *command_buffer = recorder->command_buffer;
    const struct compute_state *state = &recorder->recording->compute;
    if (!recorder->device->snapshots->has_addresses ||
        !(command_buffer->pool->queue_flags & VK_QUEUE_COMPUTE_BIT))
        return false;
    return recorder->device->snapshots->are_for_backend ||
           (!command_buffer->work_failed && !command_buffer->inherits_conditions &&
            !state->is_partial && !state->queries);
}

void dispatches_add(struct recorder *recorder, enum own_shader shader, const void *constants,
                    uint32_t size, uint32_t groups)
{
    const VkuDeviceDispatchTable *next = &recorder->device->snapshots->next;
    const struct own_shaders *shaders = recorder->device->snapshots->shaders;
    recorder_start_copies(recorder);
    if (!recorder->has_dispatched)
        end_condition(recorder);
    recorder->has_dispatched = true;
    next->CmdBindPipeline(recorder->handle, VK_PIPELINE_BIND_POINT_COMPUTE,
                          shaders->pipelines[shader]);
    next->CmdPushConstants(recorder->handle, shaders->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, size,
                           constants);
    next->CmdDispatch(recorder->handle, groups, 1, 1);
}

void dispatches_end(const struct recorder *recorder)
{
    if (!recorder->has_dispatched)
        return;
    begin_condition(recorder);
    compute_state_restore(recorder);
}
