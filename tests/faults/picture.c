/* SPDX-License-Identifier: Apache-2.0 */
#include "model.h"

#include <inttypes.h>
#include <stdio.h>

#include "layer/layer.h"

struct comparison {
    const struct model *model;
    struct layer_device *device;
    bool may_be_unknown;
    unsigned differences;
};

static void expect(struct comparison *comparison, const char *what, uint32_t slot,
                   uint64_t expected, uint64_t found)
{
    if (found == expected)
        return;
    comparison->differences++;
    fprintf(stderr, "%s %" PRIu32 ": %#" PRIx64 " expected, the layer has %#" PRIx64 "\n", what,
            slot, expected, found);
}

/* Returns whether the layer knows that the object exists. */
static bool expect_alive(struct comparison *comparison, const char *what, enum kind kind,
                         uint32_t slot, enum tristate alive)
{
    const bool is_alive = comparison->model->calls.slots[kind][slot].is_alive;
    if (!comparison->may_be_unknown || alive != UNKNOWN)
        expect(comparison, what, slot, is_alive ? YES : NO, alive);
    return alive == YES;
}

static void compare_buffer(struct comparison *comparison, uint32_t slot)
{
    const struct model_buffer *buffer = &comparison->model->buffers[slot];
    struct buffer_facts facts;
    resources_look_up_buffer(comparison->device->resources,
                             HANDLE_OF(VkBuffer, &comparison->model->calls.slots[BUFFERS][slot]),
                             &facts);
    if (expect_alive(comparison, "buffer", BUFFERS, slot, facts.alive) &&
        !(comparison->may_be_unknown && facts.status == ADDRESS_UNKNOWN))
        expect(comparison, "binding of buffer", slot,
               buffer->is_bound ? ADDRESS_IN_BUFFER : ADDRESS_UNBOUND, facts.status);
}

static void compare_structure(struct comparison *comparison, uint32_t slot)
{
    const struct model *model = comparison->model;
    const struct model_structure *structure = &model->structures[slot];
    const bool is_usable = model_structure_is_usable(model, slot);
    const struct model_buffer *buffer = &model->buffers[structure->buffer];
    struct accel_facts facts;
    resources_look_up_accel(
        comparison->device->resources,
        HANDLE_OF(VkAccelerationStructureKHR, &model->calls.slots[STRUCTURES][slot]), &facts);
    if (!expect_alive(comparison, "structure", STRUCTURES, slot, facts.alive) ||
        (comparison->may_be_unknown && (!facts.details_known || facts.backed == UNKNOWN)))
        return;
    expect(comparison, "backing of structure", slot, is_usable ? YES : NO, facts.backed);
    expect(comparison, "size of structure", slot, 1 << 16, facts.size);
    if (is_usable && !(comparison->may_be_unknown && !facts.memory))
        expect(comparison, "memory of structure", slot,
               model->calls.slots[MEMORIES][buffer->memory].handle,
               (uint64_t)(uintptr_t)facts.memory);
}

static void compare_commands(struct comparison *comparison, uint32_t slot)
{
    static const enum command_buffer_state states[] = {
        COMMAND_BUFFER_INITIAL, COMMAND_BUFFER_RECORDING, COMMAND_BUFFER_EXECUTABLE};
    const struct model *model = comparison->model;
    const VkCommandBuffer handle =
        HANDLE_OF(VkCommandBuffer, &model->calls.slots[COMMAND_BUFFERS][slot]);
    struct command_buffers *all = comparison->device->command_buffers;
    struct command_buffer_facts facts;
    command_buffers_facts(all, command_buffers_find(all, handle), handle, &facts);
    if (!expect_alive(comparison, "command buffer", COMMAND_BUFFERS, slot, facts.alive) ||
        (comparison->may_be_unknown && facts.state == COMMAND_BUFFER_UNKNOWN))
        return;
    if (model->commands[slot].state != UNUSABLE)
        expect(comparison, "state of command buffer", slot, states[model->commands[slot].state],
               facts.state);
}

/* Whether a living object has the handle of one that was destroyed. Drivers may use handles again:
 * backend cpu does so for structures of generic type at the same place. */
static bool handle_is_used_again(const struct model *model, int kind, uint32_t slot)
{
    const struct slot *slots = model->calls.slots[kind];
    bool found = false;
    for (uint32_t i = 0; !slots[slot].is_alive && i < slot_counts[kind]; i++)
        found |= slots[i].is_alive && slots[i].handle == slots[slot].handle;
    return found;
}

unsigned picture_compare(const struct model *model, bool may_be_unknown)
{
    struct comparison comparison = {
        .model = model,
        .device = layer_find_device(model->calls.device),
        .may_be_unknown = may_be_unknown,
    };
    static void (*const compare[KINDS])(struct comparison * comparison, uint32_t slot) = {
        [BUFFERS] = compare_buffer,
        [STRUCTURES] = compare_structure,
        [COMMAND_BUFFERS] = compare_commands,
    };
    for (int kind = 0; kind < KINDS; kind++)
        for (uint32_t slot = 0; compare[kind] && slot < slot_counts[kind]; slot++)
            if (model->calls.slots[kind][slot].handle && !handle_is_used_again(model, kind, slot))
                compare[kind](&comparison, slot);
    return comparison.differences;
}
