/* SPDX-License-Identifier: Apache-2.0 */
/* Pipelines of the layer's own, and dispatches that leave the command buffer's state unchanged. */
#include "layer/snapshots/copies/dispatches.h"

#include <stdlib.h>

#include "layer/snapshots/copies/compute_state.h"
#include "layer/snapshots/words.h"

static const uint32_t copy_code[] = {
#include "copy_comp.h"
};
static const uint32_t gather_code[] = {
#include "gather_comp.h"
};
static const uint32_t guard_code[] = {
#include "guard_comp.h"
};

static const struct {
    const uint32_t *words;
    size_t size;
} codes[SHADER_COUNT] = {
    [SHADER_COPY] = {copy_code, sizeof(copy_code)},
    [SHADER_GATHER] = {gather_code, sizeof(gather_code)},
    [SHADER_GUARD] = {guard_code, sizeof(guard_code)},
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
