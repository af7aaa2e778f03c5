/* SPDX-License-Identifier: Apache-2.0 */
/* Quality balanced: splits where the surface area heuristic over a few bins is least.
 * Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007. */
#include "build/tree.h"

#define BINS_MAX 16u
/* Of a split, in units of testing a primitive: half of what a node of four costs, since such a node
 * takes the place of up to three splits. */
#define NODE_COST 0.5f

struct bins {
    struct box box[BINS_MAX][3]; /* of each axis */
    int4 count[BINS_MAX];        /* a lane for each axis */
};

/* From a center to its bin: 0 to count - 1, since the scale is a bit less than count / extent. */
struct binning {
    float4 base, scale;
    uint32_t count;
};

struct split {
    float cost; /* area times primitives, both sides, in the units of `area` */
    float area; /* of the node itself */
    uint32_t axis, bin;
};

static struct binning make_binning(const struct tree_task *task)
{
    struct binning binning = {.base = task->centers.lower};
    uint32_t wanted = 4 + (task->end - task->begin) / 16;
    binning.count = wanted < BINS_MAX ? wanted : BINS_MAX;
    float4 extent = task->centers.upper - task->centers.lower;
    float4 scale = float4_all((float)binning.count * (1 - 0x1p-16f)) / extent;
    /* A subnormal extent: all in bin 0, or nearly, rather than infinity times 0. */
    binning.scale = float4_min(scale, float4_all(FLT_MAX));
    binning.base[3] = binning.scale[3] = 0;
    return binning;
}

static inline int4 bin_of(const struct binning *binning, const struct primitive_ref *ref)
{
    float4 place = (ref->lower + ref->upper - binning->base) * binning->scale;
    return __builtin_convertvector(place, int4);
}

static void fill_bins(struct bins *bins, const struct binning *binning,
                      const struct primitive_ref *refs, uint32_t count)
{
    for (uint32_t i = 0; i < binning->count; i++) {
        bins->box[i][0] = bins->box[i][1] = bins->box[i][2] = box_empty();
        bins->count[i] = (int4){0, 0, 0, 0};
    }
    for (uint32_t i = 0; i < count; i++) {
        int4 bin = bin_of(binning, &refs[i]);
        float4 lower = refs[i].lower, upper = refs[i].upper;
        box_add(&bins->box[bin[0]][0], lower, upper);
        box_add(&bins->box[bin[1]][1], lower, upper);
        box_add(&bins->box[bin[2]][2], lower, upper);
        bins->count[bin[0]][0]++;
        bins->count[bin[1]][1]++;
        bins->count[bin[2]][2]++;
    }
}

/* Half the areas of three boxes, one a lane, in units in which the node's longest side is 1: no
 * product overflows, and what underflows is too small to matter. */
static inline float4 half_areas(const struct box box[3], float4 unit)
{
    float4 a = (box[0].upper - box[0].lower) * unit;
    float4 b = (box[1].upper - box[1].lower) * unit;
    float4 c = (box[2].upper - box[2].lower) * unit;
    float4 ab_xy = __builtin_shufflevector(a, b, 0, 4, 1, 5); /* ax bx ay by */
    float4 x = __builtin_shufflevector(ab_xy, c, 0, 1, 4, 7);
    float4 y = __builtin_shufflevector(ab_xy, c, 2, 3, 5, 7);
    float4 ab_z = __builtin_shufflevector(a, b, 2, 6, 2, 6);
    float4 z = __builtin_shufflevector(ab_z, c, 0, 1, 6, 7);
    return x * (y + z) + y * z;
}

static inline void merge_boxes(struct box to[3], const struct box from[3])
{
    for (int axis = 0; axis < 3; axis++)
        box_add(&to[axis], from[axis].lower, from[axis].upper);
}

static float4 area_unit(struct box bounds)
{
    float4 extent = bounds.upper - bounds.lower;
    float longest = fmaxf(extent[0], fmaxf(extent[1], extent[2]));
    return float4_all(longest > 0x1p-126f ? 1 / longest : 0x1p126f);
}

/* The best plane of all axes. An empty side has infinite area and no primitives: its cost is NaN,
 * which is less than nothing. */
static struct split find_split(const struct bins *bins, uint32_t count, struct box bounds)
{
    float4 unit = area_unit(bounds), right_cost[BINS_MAX];
    struct box side[3] = {box_empty(), box_empty(), box_empty()};
    int4 sum = {0, 0, 0, 0};
    for (uint32_t i = count - 1; i > 0; i--) {
        merge_boxes(side, bins->box[i]);
        sum += bins->count[i];
        right_cost[i] = half_areas(side, unit) * __builtin_convertvector(sum, float4);
    }
    side[0] = side[1] = side[2] = box_empty();
    sum = (int4){0, 0, 0, 0};
    float4 best = float4_all(INFINITY);
    int4 best_bin = {0, 0, 0, 0};
    for (uint32_t i = 1; i < count; i++) {
        merge_boxes(side, bins->box[i - 1]);
        sum += bins->count[i - 1];
        float4 cost = right_cost[i] + half_areas(side, unit) * __builtin_convertvector(sum, float4);
        int4 better = cost < best, bin = {(int)i, (int)i, (int)i, (int)i};
        best = float4_min(cost, best);
        best_bin = (better & bin) | (~better & best_bin);
    }
    bounds.lower *= unit;
    bounds.upper *= unit;
    struct split split = {.cost = INFINITY, .area = box_half_area(bounds)};
    for (uint32_t axis = 0; axis < 3; axis++)
        if (best[axis] < split.cost) {
            split.cost = best[axis];
            split.axis = axis;
            split.bin = (uint32_t)best_bin[axis];
        }
    return split;
}

/* Exchanges what lies on the wrong sides, from both ends (Hoare 1962). */
static void partition(struct build_state *state, const struct tree_task *task,
                      const struct binning *binning, const struct split *split,
                      struct tree_halves *halves)
{
    int plane = (int)split->bin;
    int4 planes = {plane, plane, plane, plane};
    unsigned bit = 1u << split->axis;
    struct box left = box_empty(), right = box_empty();
    struct primitive_ref *low = state->refs + task->begin, *high = state->refs + task->end;
    for (;;) {
        float4 center;
        for (; low < high && int4_mask(bin_of(binning, low) < planes) & bit; low++) {
            center = low->lower + low->upper;
            box_add(&left, center, center);
        }
        for (; low < high && !(int4_mask(bin_of(binning, high - 1) < planes) & bit); high--) {
            center = high[-1].lower + high[-1].upper;
            box_add(&right, center, center);
        }
        if (low >= high)
            break;
        struct primitive_ref swap = *low;
        *low = high[-1];
        high[-1] = swap;
    }
    halves->middle = (uint32_t)(low - state->refs);
    halves->centers[0] = left;
    halves->centers[1] = right;
}

static void take_bounds(const struct bins *bins, uint32_t count, const struct split *split,
                        struct tree_halves *halves)
{
    for (uint32_t side = 0; side < 2; side++) {
        uint32_t begin = side == 0 ? 0 : split->bin, end = side == 0 ? split->bin : count;
        halves->bounds[side] = box_empty();
        for (uint32_t i = begin; i < end; i++) {
            const struct box *box = &bins->box[i][split->axis];
            box_add(&halves->bounds[side], box->lower, box->upper);
        }
    }
}

/* False: a leaf. */
static bool split_range(struct build_state *state, const struct tree_task *task,
                        struct tree_halves *halves)
{
    uint32_t count = task->end - task->begin, limit = structure_leaf_limit(state->kind);
    if (count == 1)
        return false;
    if (task->depth >= SPLIT_DEPTH_LIMIT) {
        tree_halve(state, task, halves);
        return count > limit;
    }
    struct bins bins;
    struct binning binning = make_binning(task);
    fill_bins(&bins, &binning, state->refs + task->begin, count);
    struct split split = find_split(&bins, binning.count, state->tree[task->slot].bounds);
    bool is_cheaper = split.cost + NODE_COST * split.area < (float)count * split.area;
    if (count <= limit && !is_cheaper)
        return false;
    if (split.bin == 0) {
        tree_halve(state, task, halves);
        return true;
    }
    take_bounds(&bins, binning.count, &split, halves);
    partition(state, task, &binning, &split, halves);
    return true;
}

void tree_build_binned(struct build_state *state)
{
    tree_split_all(state, split_range);
    state->has_bounds = true;
}
