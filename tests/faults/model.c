/* SPDX-License-Identifier: Apache-2.0 */
/* The application's calls, and what the model knows of its objects. */
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include "model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

static void (*const all_calls[])(struct calls *calls) = {
#define CALL(name) call_##name,
    CALLS(CALL)
#undef CALL
};

static const char *const call_names[] = {
#define CALL(name) #name,
    CALLS(CALL)
#undef CALL
};

/* ---- calls */

void model_call(struct model *model, enum call_code code, const uint8_t *bytes, size_t count)
{
    struct calls *calls = &model->calls;
    if (model->step_count == STEPS_MAX || count > STEP_BYTES)
        abort();
    struct step *step = &model->steps[model->step_count++];
    *step = (struct step){.code = code, .count = (uint8_t)count};
    memcpy(step->bytes, bytes, count);
    calls->at = step->bytes;
    calls->end = step->bytes + count;
    calls->status = VK_SUCCESS;
    all_calls[code](calls);
    model->is_lost |= calls->status == VK_ERROR_DEVICE_LOST;
}

bool model_has_succeeded(const struct model *model)
{
    return model->calls.status == VK_SUCCESS;
}

void model_print(const struct model *model)
{
    for (uint32_t i = 0; i < model->step_count; i++) {
        const struct step *step = &model->steps[i];
        fprintf(stderr, "%4u %s", i, call_names[step->code]);
        for (uint8_t j = 0; j < step->count; j++)
            fprintf(stderr, " %u", step->bytes[j]);
        fputc('\n', stderr);
    }
}

uint8_t model_below(struct model *model, uint32_t count)
{
    return (uint8_t)random_below(&model->random, count);
}

bool model_is_alive(const struct model *model, enum kind kind, uint32_t slot)
{
    return model->calls.slots[kind][slot].is_alive;
}

bool model_structure_is_usable(const struct model *model, uint32_t slot)
{
    const struct model_structure *structure = &model->structures[slot];
    const struct model_buffer *buffer = &model->buffers[structure->buffer];
    return model_is_alive(model, STRUCTURES, slot) &&
           model_is_alive(model, BUFFERS, structure->buffer) && buffer->is_bound &&
           buffer->serial == structure->buffer_serial;
}

uint8_t model_pick_structure(struct model *model)
{
    const uint8_t first = model_below(model, SLOTS_MAX);
    for (uint8_t i = 0; i < SLOTS_MAX; i++)
        if (model_structure_is_usable(model, (first + i) % SLOTS_MAX))
            return (first + i) % SLOTS_MAX;
    return SLOTS_MAX;
}

uint8_t model_pick_commands_in(struct model *model, enum model_state state, uint8_t begin,
                               uint8_t end)
{
    const uint8_t first = model_below(model, end - begin);
    for (uint8_t i = 0; i < end - begin; i++) {
        const uint8_t slot = (uint8_t)(begin + (first + i) % (end - begin));
        if (model_is_alive(model, COMMAND_BUFFERS, slot) && model->commands[slot].state == state)
            return slot;
    }
    return SLOTS_MAX;
}

/* ---- waits and invalidation */

void model_wait_idle(struct model *model)
{
    static const uint8_t operands[QUEUES] = {3, 1, 2};
    bool is_pending = false;
    for (uint32_t i = 0; i < RECORDED; i++)
        is_pending |= model->commands[i].is_pending;
    if (!is_pending)
        return;
    MODEL_CALL(model, wait_idle, operands[model->queue]);
    if (!model_has_succeeded(model) && !model->is_lost)
        MODEL_CALL(model, wait_idle, operands[model->queue]);
    for (uint32_t i = 0; i < RECORDED; i++)
        model->commands[i].is_pending = false;
}

void model_invalidate(struct model *model, uint32_t slot, enum model_state state)
{
    model->commands[slot] = (struct model_commands){.state = state};
    for (uint32_t i = 0; i < PRIMARIES; i++)
        if (model->commands[i].secondary_set >> slot & 1)
            model->commands[i] = (struct model_commands){.state = UNUSABLE};
}

void model_invalidate_users(struct model *model, uint32_t structure)
{
    for (uint32_t i = 0; i < RECORDED; i++)
        if (model->commands[i].used_set >> structure & 1)
            model_invalidate(model, i, UNUSABLE);
}

void model_invalidate_users_of_buffer(struct model *model, uint32_t buffer)
{
    for (uint32_t i = 0; i < SLOTS_MAX; i++)
        if (model->structures[i].buffer == buffer)
            model_invalidate_users(model, i);
}

/* ---- the whole */

static unsigned char *map(size_t size)
{
    void *bytes = mmap(NULL, size, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (bytes == MAP_FAILED)
        abort();
    return bytes;
}

void model_begin(struct model *model, const struct calls *opened, uint32_t queue, uint64_t seed)
{
    *model = (struct model){.calls = *opened, .random = {seed}, .queue = queue};
    model->calls.host = map(HOST_SIZE);
    model->calls.result = map(RESULT_SIZE);
    calls_prepare(&model->calls);
    for (uint32_t i = 0; i < FIRST_OWN_BUFFER; i++) {
        model->buffers[i] = (struct model_buffer){.memory = i, .is_bound = true};
        model->structures[i] = (struct model_structure){
            .buffer = STORAGE, .offset = places[i], .allows_update = i == 0};
    }
    MODEL_CALL(model, destroy_structure, TOP_LEVEL);
}

void model_update_all(struct model *model)
{
    if (model->is_lost)
        return;
    model_wait_idle(model);
    for (uint8_t i = 0; i < SLOTS_MAX; i++) {
        if (!model_structure_is_usable(model, i) || !model->structures[i].allows_update)
            continue;
        MODEL_CALL(model, reset_commands, 0);
        MODEL_CALL(model, begin, 0);
        model_invalidate(model, 0, RECORDING);
        model_build(model, 0, i, true);
        MODEL_CALL(model, end, 0);
        model->mistakes += !model->structures[i].is_built;
        model_submit_slot(model, 0);
        model_wait_idle(model);
    }
}

void model_end(struct model *model)
{
    munmap(model->calls.host, HOST_SIZE);
    munmap(model->calls.result, RESULT_SIZE);
}
