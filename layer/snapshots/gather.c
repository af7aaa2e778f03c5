/* SPDX-License-Identifier: Apache-2.0 */
/* Gathering by a compute shader, and the state of the command buffer that it disturbs. */
#include "snapshots/gather.h"

#include <stdlib.h>
#include <string.h>

#include "snapshots/compute_state.h"
#include "snapshots/staging.h"

static const uint32_t code[] = {
#include "gather_comp.h"
};

/* As the shader has them. */
struct constants {
    uint64_t addresses, ranges, target;
    uint32_t count, range_count, words, typed;
};
_Static_assert(sizeof(VkAccelerationStructureInstanceKHR) == 4 * 16 &&
                   sizeof(VkAccelerationStructureMatrixMotionInstanceNV) == 4 * 28 &&
                   sizeof(VkAccelerationStructureSRTMotionInstanceNV) == 4 * 36,
               "words of elements that have types");

enum { GROUP = 64, GROUPS_MAX = 65535, RANGE_SIZE = 16, SPARE_RANGES = 16 };

struct gather {
    const struct layer_device *device;
    pthread_mutex_t lock; /* held while the rest is made */
    VkPipelineLayout layout;
    VkPipeline pipeline;
};

VkResult gather_create(const struct layer_device *device, struct gather **gather)
{
    *gather = calloc(1, sizeof(**gather));
    if (!*gather)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*gather)->device = device;
    pthread_mutex_init(&(*gather)->lock, NULL);
    return VK_SUCCESS;
}

void gather_destroy(struct gather *gather)
{
    if (!gather)
        return;
    const VkuDeviceDispatchTable *next = &gather->device->snapshots->next;
    if (gather->layout)
        next->DestroyPipelineLayout(gather->device->handle, gather->layout, NULL);
    if (gather->pipeline)
        next->DestroyPipeline(gather->device->handle, gather->pipeline, NULL);
    pthread_mutex_destroy(&gather->lock);
    free(gather);
}

static VkResult create_layout(const struct layer_device *device, VkPipelineLayout *layout)
{
    const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                                       .size = sizeof(struct constants)};
    const VkPipelineLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range,
    };
    return device->snapshots->next.CreatePipelineLayout(device->handle, &info, NULL, layout);
}

static bool make(struct gather *gather)
{
    const struct layer_device *device = gather->device;
    const struct own_device own = snapshots_own_device(device->snapshots);
    pthread_mutex_lock(&gather->lock);
    VkResult result = VK_SUCCESS;
    if (!gather->layout)
        result = create_layout(device, &gather->layout);
    if (result == VK_SUCCESS && !gather->pipeline)
        result = own_compute_create(&own, code, sizeof(code), gather->layout, &gather->pipeline);
    pthread_mutex_unlock(&gather->lock);
    return result == VK_SUCCESS;
}

/* ---- where the shader may read */

struct ranges {
    uint64_t (*at)[2];
    uint32_t count, capacity;
};

static void add_range(void *user, uint64_t begin, uint64_t end)
{
    struct ranges *ranges = user;
    if (ranges->count < ranges->capacity) {
        ranges->at[ranges->count][0] = begin;
        ranges->at[ranges->count][1] = end;
    }
    ranges->count++;
}

static uint64_t address_of(const struct recorder *recorder, const struct snapshot *snapshot)
{
    const struct staging_chunk *chunk =
        (const struct staging_chunk *)recorder->recording->chunks[snapshot->chunk];
    return chunk->buffer.address + snapshot->offset;
}

/* As they are now; what is left of the list begins behind all addresses. */
static void write_ranges(struct resources *resources, unsigned char *bytes, uint64_t size)
{
    struct ranges ranges = {.at = (void *)bytes, .capacity = (uint32_t)(size / RANGE_SIZE)};
    resources_find_ranges(resources, add_range, &ranges);
    if (ranges.count < ranges.capacity)
        memset(ranges.at[ranges.count], 0xff, (ranges.capacity - ranges.count) * RANGE_SIZE);
}

/* There may be more by the time the command executes. */
static bool list_ranges(struct recorder *recorder, struct snapshot *list)
{
    struct resources *resources = recorder->device->resources;
    struct ranges ranges = {0};
    resources_find_ranges(resources, add_range, &ranges);
    if (!recorder_reserve(recorder, (2ull * ranges.count + SPARE_RANGES) * RANGE_SIZE, list))
        return false;
    write_ranges(resources, recorder->recording->chunks[list->chunk]->bytes + list->offset,
                 list->size);
    return true;
}

void gather_renew_ranges(const struct layer_device *device, const struct execution *execution)
{
    bool has_any = execution->recording->has_gatherings && !execution->is_repeated;
    uint32_t child = 0;
    for (const struct recorded_item *item = NULL; (item = execution_next(execution, item));) {
        const struct snapshot *list = item->build ? &item->build->gathering.ranges : NULL;
        if (item->kind == ITEM_EXECUTE)
            gather_renew_ranges(device, execution->children[child++]);
        else if (has_any && list && list->size)
            write_ranges(device->resources, execution->bases[list->chunk] + list->offset,
                         list->size);
    }
}

/* ---- the command */

static void wait_for_addresses(const struct recorder *recorder)
{
    const VkMemoryBarrier memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                    .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                    .dstAccessMask = VK_ACCESS_SHADER_READ_BIT};
    recorder->device->snapshots->next.CmdPipelineBarrier(
        recorder->handle, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0,
        1, &memory, 0, NULL, 0, NULL);
}

/* Only backend cpu dispatches where that is conditional: it needs the data, as builds follow no
 * condition. */
static void end_condition(const struct recorder *recorder)
{
    if (recorder->recording->compute.is_conditional)
        recorder->device->snapshots->next.CmdEndConditionalRenderingEXT(recorder->handle);
}

static void begin_condition(const struct recorder *recorder)
{
    const struct compute_state *state = &recorder->recording->compute;
    const VkConditionalRenderingBeginInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_CONDITIONAL_RENDERING_BEGIN_INFO_EXT,
        .buffer = state->condition.buffer,
        .offset = state->condition.offset,
        .flags = state->condition_flags,
    };
    if (state->is_conditional)
        recorder->device->snapshots->next.CmdBeginConditionalRenderingEXT(recorder->handle, &info);
}

static void dispatch(const struct recorder *recorder, const struct constants *constants)
{
    const VkuDeviceDispatchTable *next = &recorder->device->snapshots->next;
    const struct gather *gather = recorder->device->snapshots->gather;
    end_condition(recorder);
    next->CmdBindPipeline(recorder->handle, VK_PIPELINE_BIND_POINT_COMPUTE, gather->pipeline);
    next->CmdPushConstants(recorder->handle, gather->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                           sizeof(*constants), constants);
    next->CmdDispatch(recorder->handle, (constants->count + GROUP - 1) / GROUP, 1, 1);
    begin_condition(recorder);
    compute_state_restore(recorder);
}

/* Whether a dispatch there changes nothing of what the application does: all state that it disturbs
 * is known and can be restored, nothing counts it and no condition can leave it out. */
static bool may_dispatch(const struct recorder *recorder)
{
    const struct command_buffer *command_buffer = recorder->command_buffer;
    const struct compute_state *state = &recorder->recording->compute;
    if (recorder->device->cpu)
        return true;
    return recorder->device->snapshots->has_addresses && !command_buffer->work_lost &&
           !command_buffer->inherits_conditions && !state->is_partial && !state->queries &&
           !state->is_conditional && (command_buffer->pool->queue_flags & VK_QUEUE_COMPUTE_BIT);
}

bool recorder_gather(struct recorder *recorder, const struct snapshot *addresses,
                     struct gathering *gathering)
{
    const uint32_t count = (uint32_t)(addresses->size / sizeof(uint64_t));
    const uint32_t size = gathering->is_typed ? sizeof(VkAccelerationStructureMotionInstanceDataNV)
                                              : sizeof(VkAccelerationStructureInstanceKHR);
    if (!count)
        return false;
    if (!may_dispatch(recorder)) {
        recorder->left_out = LEFT_OUT_PLACE;
        return false;
    }
    if (count > (uint32_t)GROUP * GROUPS_MAX || !make(recorder->device->snapshots->gather)) {
        recorder_lose(recorder);
        return false;
    }
    if (!list_ranges(recorder, &gathering->ranges) ||
        !recorder_reserve(recorder, (uint64_t)count * size, &gathering->elements))
        return false;
    const struct constants constants = {
        .addresses = address_of(recorder, addresses),
        .ranges = address_of(recorder, &gathering->ranges),
        .target = address_of(recorder, &gathering->elements),
        .count = count,
        .range_count = (uint32_t)(gathering->ranges.size / RANGE_SIZE),
        .words = size / 4,
        .typed = gathering->is_typed,
    };
    wait_for_addresses(recorder);
    dispatch(recorder, &constants);
    recorder->has_dispatched = true;
    recorder->recording->has_gatherings = true;
    gathering->addresses = *addresses;
    gathering->count = count;
    return true;
}
