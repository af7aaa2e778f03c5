/* SPDX-License-Identifier: Apache-2.0 */
/* Stable sorting by 32-bit keys: radix sort for long arrays, insertion sort for short ones. */
#include "src/bvh/tree/tree.h"

#define DIGIT_BITS 8 /* log2 of SORT_DIGITS */
#define INSERTION_LIMIT 48u

static void insertion_sort(struct sort_pair *pairs, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        struct sort_pair pair = pairs[i];
        uint32_t j = i;
        for (; j > 0 && pairs[j - 1].key > pair.key; j--)
            pairs[j] = pairs[j - 1];
        pairs[j] = pair;
    }
}

/* Sorts from the lowest digit up, alternating between the two arrays; copies the result back if it
 * ends in `spare`. Skips digits that all keys share. */
static void radix_sort(struct sort_pair *pairs, struct sort_pair *spare, uint32_t count)
{
    uint32_t tallies[32 / DIGIT_BITS][SORT_DIGITS] = {{0}};
    for (uint32_t i = 0; i < count; i++)
        for (int digit = 0; digit < 32 / DIGIT_BITS; digit++)
            tallies[digit][pairs[i].key >> digit * DIGIT_BITS & (SORT_DIGITS - 1)]++;
    struct sort_pair *from = pairs, *to = spare;
    for (int digit = 0; digit < 32 / DIGIT_BITS; digit++) {
        uint32_t *tally = tallies[digit], start = 0;
        int shift = digit * DIGIT_BITS;
        if (tally[from[0].key >> shift & (SORT_DIGITS - 1)] == count)
            continue;
        for (uint32_t value = 0; value < SORT_DIGITS; value++) {
            uint32_t next = start + tally[value];
            tally[value] = start;
            start = next;
        }
        for (uint32_t i = 0; i < count; i++)
            to[tally[from[i].key >> shift & (SORT_DIGITS - 1)]++] = from[i];
        struct sort_pair *swap = from;
        from = to;
        to = swap;
    }
    if (from != pairs)
        memcpy(pairs, from, count * sizeof(*pairs));
}

void sort_pairs(struct sort_pair *pairs, struct sort_pair *spare, uint32_t count)
{
    if (count <= INSERTION_LIMIT)
        insertion_sort(pairs, count);
    else
        radix_sort(pairs, spare, count);
}

/* One pass over a digit. Each piece of the input counts its values. A value of a piece goes after
 * all smaller values of all pieces, and after the same value of the preceding pieces. */
struct digit_pass {
    const struct sort_pair *from;
    struct sort_pair *to;
    /* SORT_DIGITS per piece: first counts, then the position of the next pair with that value. */
    uint32_t *tallies;
    uint32_t count, piece;
    int shift;
};

static uint32_t *tally_of(const struct digit_pass *pass, uint32_t begin)
{
    return pass->tallies + (uint64_t)(begin / pass->piece) * SORT_DIGITS;
}

static void tally_piece(void *context, uint32_t begin, uint32_t end)
{
    const struct digit_pass *pass = context;
    uint32_t *tally = tally_of(pass, begin);
    memset(tally, 0, SORT_DIGITS * sizeof(*tally));
    for (uint32_t i = begin; i < end; i++)
        tally[pass->from[i].key >> pass->shift & (SORT_DIGITS - 1)]++;
}

static void move_piece(void *context, uint32_t begin, uint32_t end)
{
    const struct digit_pass *pass = context;
    uint32_t *tally = tally_of(pass, begin);
    for (uint32_t i = begin; i < end; i++)
        pass->to[tally[pass->from[i].key >> pass->shift & (SORT_DIGITS - 1)]++] = pass->from[i];
}

static void place_pieces(const struct digit_pass *pass)
{
    uint32_t start = 0;
    for (uint32_t value = 0; value < SORT_DIGITS; value++)
        for (uint32_t begin = 0; begin < pass->count; begin += pass->piece) {
            uint32_t *tally = &tally_of(pass, begin)[value], next = start + *tally;
            *tally = start;
            start = next;
        }
}

static void sort_pairs_shared(struct workers *workers, struct sort_pair *pairs,
                              struct sort_pair *spare, uint32_t count, uint32_t *tallies)
{
    struct digit_pass pass = {.from = pairs, .to = spare, .tallies = tallies, .count = count};
    pass.piece = (count + SORT_PIECES - 1) / SORT_PIECES;
    for (; pass.shift < 32; pass.shift += DIGIT_BITS) { /* an even number of passes */
        workers_each(workers, count, pass.piece, tally_piece, &pass);
        place_pieces(&pass);
        workers_each(workers, count, pass.piece, move_piece, &pass);
        struct sort_pair *sorted = pass.to;
        pass.to = pass.from == pairs ? pairs : spare;
        pass.from = sorted;
    }
}

/* ---- Quality fast: sorts primitives in Morton order and splits ranges at the highest differing
 * bit. Lauterbach et al., "Fast BVH Construction on GPUs", 2009. Ranges with one code are halved.
 */

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

/* ---- Quality high: the surface area heuristic over every plane between two centers. MacDonald and
 * Booth, "Heuristics for ray tracing using space subdivision", 1990. */

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
    uint32_t count = task->end - task->begin, limit = tree_split_limit(state->kind);
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
