/* SPDX-License-Identifier: Apache-2.0 */
/* Quality fast: sorts primitives in Morton order and splits ranges at the highest differing bit.
 * Lauterbach et al., "Fast BVH Construction on GPUs", 2009. Ranges with one code are halved. */
#include "src/bvh/tree/tree.h"

#define AXIS_BITS 10

/* Inserts two zero bits before each of ten bits. */
static uint32_t spread_bits(uint32_t x)
{
    x = (x | x << 16) & 0x030000ff;
    x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
}

/* The scale is 0 for an axis without extent, and at most FLT_MAX for a subnormal extent. */
static float4 cell_scale(struct box centers)
{
    float4 extent = centers.upper - centers.lower, scale = {0, 0, 0, 0};
    for (int axis = 0; axis < 3; axis++)
        if (extent[axis] > 0)
            scale[axis] = fminf((float)(1 << AXIS_BITS) * (1 - 0x1p-16f) / extent[axis], FLT_MAX);
    return scale;
}

static void make_codes(void *context, uint32_t begin, uint32_t end)
{
    struct build_state *state = context;
    const float4 base = state->centers.lower, scale = cell_scale(state->centers);
    for (uint32_t i = begin; i < end; i++) {
        const struct primitive_ref *ref = &state->refs[i];
        int4 cell = __builtin_convertvector((ref->lower + ref->upper - base) * scale, int4);
        uint32_t code = spread_bits((uint32_t)cell[0]) << 2 | spread_bits((uint32_t)cell[1]) << 1 |
                        spread_bits((uint32_t)cell[2]);
        state->pairs[i] = (struct sort_pair){code, ref_primitive(ref)};
    }
}

/* Returns the first position whose code has the highest bit in which the ends of the range
 * differ. */
static uint32_t find_middle(const struct sort_pair *pairs, uint32_t begin, uint32_t end)
{
    uint32_t first = pairs[begin].key, differing = first ^ pairs[end - 1].key;
    if (differing == 0)
        return begin + (end - begin) / 2;
    uint32_t bit = 31 - (uint32_t)__builtin_clz(differing);
    uint32_t low = begin, high = end - 1; /* the bit is clear at low, set at high */
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if ((pairs[middle].key ^ first) >> bit)
            high = middle;
        else
            low = middle;
    }
    return high;
}

/* Codes have 30 bits, and ranges of equal codes are halved: no path is longer than 30 + 29. */
static void split_part(struct build_state *state, struct tree_task task)
{
    struct {
        uint32_t slot, begin, end;
    } waiting[TREE_DEPTH_LIMIT], now = {task.slot, task.begin, task.end};
    uint32_t count = 0, limit = structure_leaf_limit(state->kind);
    for (;;) {
        uint32_t size = now.end - now.begin;
        if (size > limit) {
            uint32_t middle = find_middle(state->pairs, now.begin, now.end);
            uint32_t right = now.slot + 2 * (middle - now.begin);
            tree_set_inner(&state->tree[now.slot], right, size);
            struct tree_task other = {.slot = right, .begin = middle, .end = now.end};
            if (size < TREE_TASK_SIZE || !tree_share_task(state, &other)) {
                waiting[count].slot = right;
                waiting[count].begin = middle;
                waiting[count++].end = now.end;
            }
            now.slot++;
            now.end = middle;
            continue;
        }
        tree_set_leaf(&state->tree[now.slot], size);
        if (count == 0)
            return;
        now = waiting[--count];
    }
}

#define MORTON_CHUNK 16384u

void tree_build_morton(struct build_state *state)
{
    struct workers *workers = &state->workers;
    uint32_t count = state->ref_count;
    workers_each(workers, count, MORTON_CHUNK, make_codes, state);
    if (workers_are_alone(workers) || count < SORT_TALLIES)
        sort_pairs(state->pairs, state->pairs_spare, count);
    else /* the tree, 64 bytes per primitive, is not yet written */
        sort_pairs_shared(workers, state->pairs, state->pairs_spare, count, (void *)state->tree);
    split_part(state, (struct tree_task){.end = count});
    tree_run_tasks(state, split_part);
    state->has_bounds = false;
}
