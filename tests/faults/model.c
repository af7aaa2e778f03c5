/* SPDX-License-Identifier: Apache-2.0 */
/* The application's calls, and what comes of them. */
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include "model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum {
    FIRST_OWN_BUFFER = 3, /* those before are of the ordinary scene, and stay */
    OWN_MEMORY = 3,
    STORAGE = 1,   /* the scene's buffer of structures */
    TOP_LEVEL = 2, /* the scene's, which the model does without */
    PRIMARIES = 3,
    RECORDED = 5, /* primaries, then secondaries */
    MEBIBYTE = 3, /* operands */
    SMALL = 1,
    SIMULTANEOUS_USE = 4,
    UPDATE = 4,
    HAS_FLAGS = 128,
    ALLOW_UPDATE = 1,
};

/* Operands of take_offset(): 0, 64 KiB, 256 KiB. */
static const uint8_t places[] = {0, 10, 18};
enum { PLACES = 3 };

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

static bool has_succeeded(const struct model *model)
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

static uint8_t below(struct model *model, uint32_t count)
{
    return (uint8_t)random_below(&model->random, count);
}

static bool is_alive(const struct model *model, enum kind kind, uint32_t slot)
{
    return model->calls.slots[kind][slot].is_alive;
}

bool model_structure_is_usable(const struct model *model, uint32_t slot)
{
    const struct model_structure *structure = &model->structures[slot];
    const struct model_buffer *buffer = &model->buffers[structure->buffer];
    return is_alive(model, STRUCTURES, slot) && is_alive(model, BUFFERS, structure->buffer) &&
           buffer->is_bound && buffer->serial == structure->buffer_serial;
}

/* A random usable structure; SLOTS_MAX: there is none. */
static uint8_t pick_structure(struct model *model)
{
    const uint8_t first = below(model, SLOTS_MAX);
    for (uint8_t i = 0; i < SLOTS_MAX; i++)
        if (model_structure_is_usable(model, (first + i) % SLOTS_MAX))
            return (first + i) % SLOTS_MAX;
    return SLOTS_MAX;
}

/* A random command buffer below `end` in that state; SLOTS_MAX: there is none. */
static uint8_t pick_commands_in(struct model *model, enum model_state state, uint8_t begin,
                                uint8_t end)
{
    const uint8_t first = below(model, end - begin);
    for (uint8_t i = 0; i < end - begin; i++) {
        const uint8_t slot = (uint8_t)(begin + (first + i) % (end - begin));
        if (is_alive(model, COMMAND_BUFFERS, slot) && model->commands[slot].state == state)
            return slot;
    }
    return SLOTS_MAX;
}

/* ---- waits and invalidation */

static void wait_idle(struct model *model)
{
    static const uint8_t operands[QUEUES] = {3, 1, 2};
    bool is_pending = false;
    for (uint32_t i = 0; i < RECORDED; i++)
        is_pending |= model->commands[i].is_pending;
    if (!is_pending)
        return;
    MODEL_CALL(model, wait_idle, operands[model->queue]);
    if (!has_succeeded(model) && !model->is_lost)
        MODEL_CALL(model, wait_idle, operands[model->queue]);
    for (uint32_t i = 0; i < RECORDED; i++)
        model->commands[i].is_pending = false;
}

/* It can no longer be used as it was recorded, nor can primaries that execute it. */
static void invalidate(struct model *model, uint32_t slot, enum model_state state)
{
    model->commands[slot] = (struct model_commands){.state = state};
    for (uint32_t i = 0; i < PRIMARIES; i++)
        if (model->commands[i].secondary_set >> slot & 1)
            model->commands[i] = (struct model_commands){.state = UNUSABLE};
}

static void invalidate_users(struct model *model, uint32_t structure)
{
    for (uint32_t i = 0; i < RECORDED; i++)
        if (model->commands[i].used_set >> structure & 1)
            invalidate(model, i, UNUSABLE);
}

static void invalidate_users_of_buffer(struct model *model, uint32_t buffer)
{
    for (uint32_t i = 0; i < SLOTS_MAX; i++)
        if (model->structures[i].buffer == buffer)
            invalidate_users(model, i);
}

/* ---- objects */

static void create_buffer(struct model *model)
{
    const uint8_t slot = (uint8_t)(FIRST_OWN_BUFFER + below(model, SLOTS_MAX - FIRST_OWN_BUFFER));
    const uint8_t memory = is_alive(model, MEMORIES, OWN_MEMORY) ? OWN_MEMORY : STORAGE;
    if (is_alive(model, BUFFERS, slot))
        return;
    MODEL_CALL(model, create_buffer, slot, MEBIBYTE);
    if (!is_alive(model, BUFFERS, slot))
        return;
    MODEL_CALL(model, bind_buffer, slot, memory);
    model->buffers[slot] = (struct model_buffer){
        .serial = model->buffers[slot].serial + 1,
        .memory = memory,
        .is_bound = has_succeeded(model),
    };
    MODEL_CALL(model, name_object, 0, 0, slot);
}

static void destroy_buffer(struct model *model)
{
    const uint8_t slot = (uint8_t)(FIRST_OWN_BUFFER + below(model, SLOTS_MAX - FIRST_OWN_BUFFER));
    if (!is_alive(model, BUFFERS, slot))
        return;
    wait_idle(model);
    invalidate_users_of_buffer(model, slot);
    MODEL_CALL(model, destroy_buffer, slot);
}

/* The memory of most own buffers goes at once. */
static void change_memory(struct model *model)
{
    if (!is_alive(model, MEMORIES, OWN_MEMORY)) {
        MODEL_CALL(model, allocate_memory, OWN_MEMORY, 0, MEBIBYTE);
        return;
    }
    if (!random_one_in(&model->random, 4))
        return;
    wait_idle(model);
    for (uint32_t i = FIRST_OWN_BUFFER; i < SLOTS_MAX; i++) {
        if (model->buffers[i].memory != OWN_MEMORY)
            continue;
        invalidate_users_of_buffer(model, i);
        model->buffers[i].is_bound = false;
    }
    MODEL_CALL(model, free_memory, OWN_MEMORY);
}

static bool place_is_free(const struct model *model, uint32_t buffer, uint8_t offset)
{
    for (uint32_t i = 0; i < SLOTS_MAX; i++) {
        const struct model_structure *structure = &model->structures[i];
        if (model_structure_is_usable(model, i) && structure->offset == offset &&
            model->buffers[structure->buffer].memory == model->buffers[buffer].memory)
            return false;
    }
    return true;
}

static void create_structure(struct model *model)
{
    const uint8_t slot = below(model, SLOTS_MAX), offset = places[below(model, PLACES)];
    const uint8_t buffer =
        random_one_in(&model->random, 2)
            ? STORAGE
            : (uint8_t)(FIRST_OWN_BUFFER + below(model, SLOTS_MAX - FIRST_OWN_BUFFER));
    const bool is_generic = random_one_in(&model->random, 4);
    if (is_alive(model, STRUCTURES, slot) || !is_alive(model, BUFFERS, buffer) ||
        !model->buffers[buffer].is_bound || !place_is_free(model, buffer, offset))
        return;
    MODEL_CALL(model, create_structure, slot, buffer, 0, offset, SMALL, is_generic ? 2 : 0);
    if (!is_alive(model, STRUCTURES, slot))
        return;
    model->structures[slot] = (struct model_structure){
        .buffer = buffer,
        .buffer_serial = model->buffers[buffer].serial,
        .offset = offset,
        .allows_update = random_one_in(&model->random, 2),
    };
    MODEL_CALL(model, get_structure_address, slot);
    MODEL_CALL(model, name_object, 1, 0, 0, slot);
}

static void destroy_structure(struct model *model)
{
    const uint8_t slot = below(model, SLOTS_MAX);
    if (!is_alive(model, STRUCTURES, slot))
        return;
    wait_idle(model);
    invalidate_users(model, slot);
    MODEL_CALL(model, destroy_structure, slot);
}

/* ---- recording */

static void begin(struct model *model)
{
    const uint8_t slot = below(model, RECORDED);
    const enum model_state state = model->commands[slot].state;
    if (!is_alive(model, COMMAND_BUFFERS, slot) || state == RECORDING)
        return;
    wait_idle(model);
    if (state == UNUSABLE || random_one_in(&model->random, 4)) {
        MODEL_CALL(model, reset_commands, slot, below(model, 2));
        invalidate(model, slot, has_succeeded(model) ? INITIAL : UNUSABLE);
        if (!has_succeeded(model))
            return;
    }
    MODEL_CALL(model, begin, slot, slot < PRIMARIES ? 0 : SIMULTANEOUS_USE);
    invalidate(model, slot, has_succeeded(model) ? RECORDING : UNUSABLE);
}

static void end(struct model *model)
{
    const uint8_t slot = pick_commands_in(model, RECORDING, 0, RECORDED);
    if (slot == SLOTS_MAX)
        return;
    MODEL_CALL(model, end, slot);
    if (has_succeeded(model))
        model->commands[slot].state = EXECUTABLE;
    else
        invalidate(model, slot, UNUSABLE);
}

/* The operands of one build: boxes, or triangles. */
static uint8_t build_operands(struct model *model, uint8_t commands, uint8_t structure,
                              bool is_update, uint8_t *bytes)
{
    const bool allows = model->structures[structure].allows_update;
    uint8_t count = 0;
    bytes[count++] = commands;
    bytes[count++] = 0; /* one build */
    bytes[count++] = (uint8_t)((is_update ? UPDATE : 0) | (allows ? HAS_FLAGS : 0));
    if (allows) {
        const uint8_t flags[] = {ALLOW_UPDATE, 0, 0, 0};
        memcpy(bytes + count, flags, sizeof(flags));
        count += sizeof(flags);
    }
    bytes[count++] = structure;
    if (is_update)
        bytes[count++] = structure;
    return count;
}

static void note_build(struct model *model, uint8_t commands, uint8_t structure, bool is_update)
{
    struct model_commands *recorded = &model->commands[commands];
    const uint32_t bit = 1u << structure;
    recorded->used_set |= bit;
    if (is_update && !(recorded->built_set & bit))
        recorded->needed_set |= bit;
    recorded->built_set |= bit;
}

static void build(struct model *model, uint8_t commands, uint8_t structure, bool is_update)
{
    uint8_t bytes[STEP_BYTES] = {0};
    const uint8_t count = build_operands(model, commands, structure, is_update, bytes);
    model_call(model, CALL_build, bytes, count);
    note_build(model, commands, structure, is_update);
}

static void build_one(struct model *model)
{
    const uint8_t commands = pick_commands_in(model, RECORDING, 0, RECORDED);
    const uint8_t structure = pick_structure(model);
    if (commands == SLOTS_MAX || structure == SLOTS_MAX)
        return;
    const struct model_structure *to_build = &model->structures[structure];
    const bool was_built =
        to_build->is_built || model->commands[commands].built_set >> structure & 1;
    build(model, commands, structure,
          to_build->allows_update && was_built && random_one_in(&model->random, 2));
}

/* A clone, of a structure that has been built in the same command buffer. */
static void copy(struct model *model)
{
    const uint8_t commands = pick_commands_in(model, RECORDING, 0, RECORDED);
    const uint8_t src = pick_structure(model), dst = pick_structure(model);
    if (commands == SLOTS_MAX || src == SLOTS_MAX || dst == src ||
        !(model->commands[commands].built_set >> src & 1) ||
        model->structures[src].allows_update != model->structures[dst].allows_update)
        return;
    MODEL_CALL(model, copy_structure, commands, src, dst);
    note_build(model, commands, dst, false);
}

static void execute(struct model *model)
{
    const uint8_t primary = pick_commands_in(model, RECORDING, 0, PRIMARIES);
    const uint8_t secondary = pick_commands_in(model, EXECUTABLE, PRIMARIES, RECORDED);
    if (primary == SLOTS_MAX || secondary == SLOTS_MAX)
        return;
    struct model_commands *of = &model->commands[primary];
    const struct model_commands *executed = &model->commands[secondary];
    MODEL_CALL(model, execute, primary, secondary);
    of->needed_set |= executed->needed_set & ~of->built_set;
    of->used_set |= executed->used_set;
    of->built_set |= executed->built_set;
    of->secondary_set |= 1u << secondary;
}

static void record_other(struct model *model)
{
    const uint8_t commands = pick_commands_in(model, RECORDING, 0, RECORDED);
    if (commands == SLOTS_MAX)
        return;
    MODEL_CALL(model, barrier, commands, below(model, 2));
    MODEL_CALL(model, label, commands, 2 + 4);
    MODEL_CALL(model, fill_buffer, commands, STORAGE, 15);
}

/* ---- submissions */

static bool can_submit(const struct model *model, uint32_t slot)
{
    for (uint32_t i = 0; i < SLOTS_MAX; i++)
        if (model->commands[slot].needed_set >> i & 1 && !model->structures[i].is_built)
            return false;
    return true;
}

static void submit_slot(struct model *model, uint8_t slot)
{
    const uint8_t queue = (uint8_t)(model->queue << 4);
    if (random_one_in(&model->random, 2))
        MODEL_CALL(model, submit, 0, slot, queue);
    else
        MODEL_CALL(model, submit2, 0, slot, queue);
    if (!has_succeeded(model))
        return;
    struct model_commands *submitted = &model->commands[slot];
    submitted->is_pending = true;
    for (uint32_t i = 0; i < SLOTS_MAX; i++) {
        if (submitted->secondary_set >> i & 1)
            model->commands[i].is_pending = true;
        if (submitted->built_set >> i & 1)
            model->structures[i].is_built = true;
    }
}

static void submit(struct model *model)
{
    const uint8_t slot = pick_commands_in(model, EXECUTABLE, 0, PRIMARIES);
    if (slot == SLOTS_MAX || !can_submit(model, slot))
        return;
    if (model->commands[slot].is_pending)
        wait_idle(model);
    submit_slot(model, slot);
}

static void wait(struct model *model)
{
    wait_idle(model);
}

/* ---- mistakes: each is one finding, at the call */

static void plant(struct model *model)
{
    const uint8_t commands = pick_commands_in(model, RECORDING, 0, RECORDED);
    const uint8_t structure = pick_structure(model);
    uint8_t bytes[STEP_BYTES] = {0};
    if (!model->plants || commands == SLOTS_MAX || structure == SLOTS_MAX)
        return;
    uint8_t count = build_operands(model, commands, structure, false, bytes);
    if (random_one_in(&model->random, 2)) {
        bytes[count + 3] = 1; /* a stride of 28 */
        count += 4;
    } else {
        bytes[count + 6] = 255; /* no build */
        count += 7;
    }
    model->mistakes++;
    model_call(model, CALL_build, bytes, count);
    invalidate(model, commands, UNUSABLE);
    MODEL_CALL(model, end, commands);
}

/* ---- the whole */

void model_step(struct model *model)
{
    static void (*const deeds[])(struct model * model) = {
        create_buffer,
        destroy_buffer,
        change_memory,
        create_structure,
        create_structure,
        destroy_structure,
        begin,
        begin,
        begin,
        end,
        end,
        build_one,
        build_one,
        build_one,
        build_one,
        build_one,
        build_one,
        copy,
        execute,
        execute,
        record_other,
        submit,
        submit,
        submit,
        submit,
        wait,
        plant,
    };
    deeds[below(model, sizeof(deeds) / sizeof(deeds[0]))](model);
}

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
    wait_idle(model);
    for (uint8_t i = 0; i < SLOTS_MAX; i++) {
        if (!model_structure_is_usable(model, i) || !model->structures[i].allows_update)
            continue;
        MODEL_CALL(model, reset_commands, 0);
        MODEL_CALL(model, begin, 0);
        invalidate(model, 0, RECORDING);
        build(model, 0, i, true);
        MODEL_CALL(model, end, 0);
        model->mistakes += !model->structures[i].is_built;
        submit_slot(model, 0);
        wait_idle(model);
    }
}

void model_end(struct model *model)
{
    munmap(model->calls.host, HOST_SIZE);
    munmap(model->calls.result, RESULT_SIZE);
}
