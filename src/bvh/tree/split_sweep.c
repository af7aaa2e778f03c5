/* SPDX-License-Identifier: Apache-2.0 */
/* Quality high: the surface area heuristic over every plane between two centers. MacDonald and
 * Booth, "Heuristics for ray tracing using space subdivision", 1990. */
#include "src/bvh/tree/tree.h"

struct sweep_split {
    float cost;
    uint32_t axis, left; /* number of primitives on the left; 0 if no plane was found */
};

/* Maps a float to an unsigned number of the same order. */
static uint32_t sortable(float x)
{
    uint32_t bits = float_bits(x);
    return bits ^ (bits >> 31 ? 0xffffffffu : 0x80000000u);
}

static void sort_axis(struct build_state *state, const struct tree_task *task, uint32_t axis)
{
    for (uint32_t i = task->begin; i < task->end; i++) {
        const struct primitive_ref *ref = &state->refs[i];
        state->pairs[i] = (struct sort_pair){sortable(ref->lower[axis] + ref->upper[axis]), i};
    }
    sort_pairs(state->pairs + task->begin, state->pairs_spare + task->begin,
               task->end - task->begin);
}

static void sweep_axis(struct build_state *state, const struct tree_task *task, uint32_t axis,
                       float4 unit, struct sweep_split *best)
{
    const struct sort_pair *pairs = state->pairs;
    if (pairs[task->begin].key == pairs[task->end - 1].key) /* no plane separates the centers */
        return;
    struct box side = box_empty();
    for (uint32_t i = task->end - 1; i > task->begin; i--) {
        const struct primitive_ref *ref = &state->refs[pairs[i].index];
        box_add(&side, ref->lower, ref->upper);
        state->areas[i] = box_half_area_in(side, unit);
    }
    side = box_empty();
    for (uint32_t i = task->begin + 1; i < task->end; i++) {
        const struct primitive_ref *ref = &state->refs[pairs[i - 1].index];
        box_add(&side, ref->lower, ref->upper);
        float cost = box_half_area_in(side, unit) * (float)(i - task->begin) +
                     state->areas[i] * (float)(task->end - i);
        if (cost < best->cost)
            *best = (struct sweep_split){cost, axis, i - task->begin};
    }
}

/* Sorts the refs along the axis of the split and computes the bounds of both sides. */
static void apply_split(struct build_state *state, const struct tree_task *task,
                        const struct sweep_split *split, struct tree_halves *halves)
{
    if (split->axis != 2) /* axis 2 was sorted last */
        sort_axis(state, task, split->axis);
    for (uint32_t i = task->begin; i < task->end; i++)
        state->refs_spare[i] = state->refs[state->pairs[i].index];
    memcpy(state->refs + task->begin, state->refs_spare + task->begin,
           (task->end - task->begin) * sizeof(*state->refs));
    halves->middle = task->begin + split->left;
    for (int side = 0; side < 2; side++) {
        uint32_t begin = side == 0 ? task->begin : halves->middle;
        uint32_t end = side == 0 ? halves->middle : task->end;
        halves->bounds[side] = halves->centers[side] = box_empty();
        for (uint32_t i = begin; i < end; i++)
            box_add(&halves->bounds[side], state->refs[i].lower, state->refs[i].upper);
    }
}

static bool split_range(struct build_state *state, const struct tree_task *task,
                        struct tree_halves *halves)
{
    uint32_t count = task->end - task->begin, limit = structure_leaf_limit(state->kind);
    struct box bounds = state->tree[task->slot].bounds;
    float4 unit = box_unit(bounds);
    struct sweep_split best = {.cost = INFINITY};
    for (uint32_t axis = 0; axis < 3; axis++) {
        sort_axis(state, task, axis);
        sweep_axis(state, task, axis, unit, &best);
    }
    float area = box_half_area_in(bounds, unit);
    if (count <= limit && !(best.cost + NODE_COST * area < (float)count * area))
        return false;
    if (best.left == 0)
        tree_split_numbers(state, task, halves);
    else
        apply_split(state, task, &best, halves);
    return true;
}

void tree_build_sweep(struct build_state *state)
{
    tree_split_all(state, split_range, UINT32_MAX);
    state->has_bounds = true;
}
