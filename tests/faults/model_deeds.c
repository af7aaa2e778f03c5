/* SPDX-License-Identifier: Apache-2.0 */
/* What the application does: a few calls each, where they are valid. */
#include "model.h"

#include <string.h>

/* ---- objects */

static uint8_t some_own_buffer(struct model *model)
{
    return (uint8_t)(FIRST_OWN_BUFFER + model_below(model, SLOTS_MAX - FIRST_OWN_BUFFER));
}

static void create_buffer(struct model *model)
{
    const uint8_t slot = some_own_buffer(model);
    const uint8_t memory = model_is_alive(model, MEMORIES, OWN_MEMORY) ? OWN_MEMORY : STORAGE;
    if (model_is_alive(model, BUFFERS, slot))
        return;
    MODEL_CALL(model, create_buffer, slot, MEBIBYTE);
    if (!model_is_alive(model, BUFFERS, slot))
        return;
    MODEL_CALL(model, bind_buffer, slot, memory);
    model->buffers[slot] = (struct model_buffer){
        .serial = model->buffers[slot].serial + 1,
        .memory = memory,
        .is_bound = model_has_succeeded(model),
    };
    MODEL_CALL(model, name_object, 0, 0, slot);
}

static void destroy_buffer(struct model *model)
{
    const uint8_t slot = some_own_buffer(model);
    if (!model_is_alive(model, BUFFERS, slot))
        return;
    model_wait_idle(model);
    model_invalidate_users_of_buffer(model, slot);
    MODEL_CALL(model, destroy_buffer, slot);
}

/* The memory of most own buffers goes at once. */
static void change_memory(struct model *model)
{
    if (!model_is_alive(model, MEMORIES, OWN_MEMORY)) {
        MODEL_CALL(model, allocate_memory, OWN_MEMORY, 0, MEBIBYTE);
        return;
    }
    if (!random_one_in(&model->random, 4))
        return;
    model_wait_idle(model);
    for (uint32_t i = FIRST_OWN_BUFFER; i < SLOTS_MAX; i++) {
        if (model->buffers[i].memory != OWN_MEMORY)
            continue;
        model_invalidate_users_of_buffer(model, i);
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
    const uint8_t slot = model_below(model, SLOTS_MAX), offset = places[model_below(model, PLACES)];
    const uint8_t buffer = random_one_in(&model->random, 2) ? STORAGE : some_own_buffer(model);
    const bool is_generic = random_one_in(&model->random, 4);
    if (model_is_alive(model, STRUCTURES, slot) || !model_is_alive(model, BUFFERS, buffer) ||
        !model->buffers[buffer].is_bound || !place_is_free(model, buffer, offset))
        return;
    MODEL_CALL(model, create_structure, slot, buffer, 0, offset, SMALL, is_generic ? 2 : 0);
    if (!model_is_alive(model, STRUCTURES, slot))
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
    const uint8_t slot = model_below(model, SLOTS_MAX);
    if (!model_is_alive(model, STRUCTURES, slot))
        return;
    model_wait_idle(model);
    model_invalidate_users(model, slot);
    MODEL_CALL(model, destroy_structure, slot);
}

/* ---- recording */

static void begin(struct model *model)
{
    const uint8_t slot = model_below(model, RECORDED);
    const enum model_state state = model->commands[slot].state;
    if (!model_is_alive(model, COMMAND_BUFFERS, slot) || state == RECORDING)
        return;
    model_wait_idle(model);
    if (state == UNUSABLE || random_one_in(&model->random, 4)) {
        MODEL_CALL(model, reset_commands, slot, model_below(model, 2));
        model_invalidate(model, slot, model_has_succeeded(model) ? INITIAL : UNUSABLE);
        if (!model_has_succeeded(model))
            return;
    }
    MODEL_CALL(model, begin, slot, slot < PRIMARIES ? 0 : SIMULTANEOUS_USE);
    model_invalidate(model, slot, model_has_succeeded(model) ? RECORDING : UNUSABLE);
}

static void end(struct model *model)
{
    const uint8_t slot = model_pick_commands_in(model, RECORDING, 0, RECORDED);
    if (slot == SLOTS_MAX)
        return;
    MODEL_CALL(model, end, slot);
    if (model_has_succeeded(model))
        model->commands[slot].state = EXECUTABLE;
    else
        model_invalidate(model, slot, UNUSABLE);
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

void model_build(struct model *model, uint8_t commands, uint8_t structure, bool is_update)
{
    uint8_t bytes[STEP_BYTES] = {0};
    const uint8_t count = build_operands(model, commands, structure, is_update, bytes);
    model_call(model, CALL_build, bytes, count);
    note_build(model, commands, structure, is_update);
}

static void build_one(struct model *model)
{
    const uint8_t commands = model_pick_commands_in(model, RECORDING, 0, RECORDED);
    const uint8_t structure = model_pick_structure(model);
    if (commands == SLOTS_MAX || structure == SLOTS_MAX)
        return;
    const struct model_structure *to_build = &model->structures[structure];
    const bool was_built =
        to_build->is_built || model->commands[commands].built_set >> structure & 1;
    model_build(model, commands, structure,
                to_build->allows_update && was_built && random_one_in(&model->random, 2));
}

/* A clone, of a structure that has been built in the same command buffer. */
static void copy(struct model *model)
{
    const uint8_t commands = model_pick_commands_in(model, RECORDING, 0, RECORDED);
    const uint8_t src = model_pick_structure(model), dst = model_pick_structure(model);
    if (commands == SLOTS_MAX || src == SLOTS_MAX || dst == src ||
        !(model->commands[commands].built_set >> src & 1) ||
        model->structures[src].allows_update != model->structures[dst].allows_update)
        return;
    MODEL_CALL(model, copy_structure, commands, src, dst);
    note_build(model, commands, dst, false);
}

static void execute(struct model *model)
{
    const uint8_t primary = model_pick_commands_in(model, RECORDING, 0, PRIMARIES);
    const uint8_t secondary = model_pick_commands_in(model, EXECUTABLE, PRIMARIES, RECORDED);
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
    const uint8_t commands = model_pick_commands_in(model, RECORDING, 0, RECORDED);
    if (commands == SLOTS_MAX)
        return;
    MODEL_CALL(model, barrier, commands, model_below(model, 2));
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

void model_submit_slot(struct model *model, uint8_t slot)
{
    const uint8_t queue = (uint8_t)(model->queue << 4);
    if (random_one_in(&model->random, 2))
        MODEL_CALL(model, submit, 0, slot, queue);
    else
        MODEL_CALL(model, submit2, 0, slot, queue);
    if (!model_has_succeeded(model))
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
    const uint8_t slot = model_pick_commands_in(model, EXECUTABLE, 0, PRIMARIES);
    if (slot == SLOTS_MAX || !can_submit(model, slot))
        return;
    if (model->commands[slot].is_pending)
        model_wait_idle(model);
    model_submit_slot(model, slot);
}

/* ---- mistakes: each is one finding, at the call */

static void plant(struct model *model)
{
    const uint8_t commands = model_pick_commands_in(model, RECORDING, 0, RECORDED);
    const uint8_t structure = model_pick_structure(model);
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
    model_invalidate(model, commands, UNUSABLE);
    MODEL_CALL(model, end, commands);
}

void model_step(struct model *model)
{
    static const struct {
        void (*deed)(struct model *model);
        unsigned weight;
    } deeds[] = {{create_buffer, 1},
                 {destroy_buffer, 1},
                 {change_memory, 1},
                 {create_structure, 2},
                 {destroy_structure, 1},
                 {begin, 3},
                 {end, 2},
                 {build_one, 6},
                 {copy, 1},
                 {execute, 2},
                 {record_other, 1},
                 {submit, 4},
                 {model_wait_idle, 1},
                 {plant, 1}};
    enum { WEIGHTS = 27 };
    unsigned i = 0, at = model_below(model, WEIGHTS);
    for (; at >= deeds[i].weight; i++)
        at -= deeds[i].weight;
    deeds[i].deed(model);
}
