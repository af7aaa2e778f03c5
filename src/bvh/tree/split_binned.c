/* SPDX-License-Identifier: Apache-2.0 */
/* Quality balanced: splits at the bin boundary with the least cost by the surface area heuristic.
 * Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007. */
#include "src/bvh/tree/tree.h"

#define BINS_MAX 16u

struct bins {
    struct box box[BINS_MAX][3]; /* per axis */
    int4 count[BINS_MAX];        /* one lane per axis */
};

/* Maps a center to its bin, 0 to count - 1: the scale is slightly less than count / extent. */
struct binning {
    float4 base, scale;
    uint32_t count;
};

struct split {
    float cost; /* sum over both sides of area times primitives, in the units of `area` */
    float area; /* area of the node */
    uint32_t axis, bin;
};

static struct binning make_binning(const struct tree_task *task)
{
    struct binning binning = {.base = task->centers.lower};
    uint32_t wanted = 4 + (task->end - task->begin) / 16;
    binning.count = wanted < BINS_MAX ? wanted : BINS_MAX;
    float4 extent = task->centers.upper - task->centers.lower;
    float4 scale = float4_all((float)binning.count * (1 - 0x1p-16f)) / extent;
    /* A subnormal extent puts (nearly) all centers in bin 0; without the limit it would give
     * infinity times 0. */
    binning.scale = float4_min(scale, float4_all(FLT_MAX));
    binning.base[3] = binning.scale[3] = 0;
    return binning;
}

static inline int4 bin_of(const struct binning *binning, const struct primitive_ref *ref)
{
    float4 place = (ref->lower + ref->upper - binning->base) * binning->scale;
    return __builtin_convertvector(place, int4);
}

static void clear_bins(struct bins *bins, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        bins->box[i][0] = bins->box[i][1] = bins->box[i][2] = box_empty();
        bins->count[i] = (int4){0, 0, 0, 0};
    }
}

static ALWAYS_INLINE void fill_bins(struct bins *bins, const struct binning *binning,
                                    const struct primitive_ref *refs, uint32_t count)
{
    clear_bins(bins, binning->count);
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

/* Returns half the areas of three boxes, one per lane. */
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

/* Finds the best plane of all axes. An empty side has infinite area and no primitives: its cost is
 * NaN, which never compares as less. */
static struct split find_split(const struct bins *bins, uint32_t count, struct box bounds)
{
    float4 unit = box_unit(bounds), right_cost[BINS_MAX];
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
    struct split split = {.cost = INFINITY, .area = box_half_area_in(bounds, unit)};
    for (uint32_t axis = 0; axis < 3; axis++)
        if (best[axis] < split.cost) {
            split.cost = best[axis];
            split.axis = axis;
            split.bin = (uint32_t)best_bin[axis];
        }
    return split;
}

/* Exchanges the refs on the wrong sides from both ends (Hoare 1962). Returns the middle. */
static ALWAYS_INLINE uint32_t partition(struct primitive_ref *refs, uint32_t begin, uint32_t end,
                                        const struct binning *binning, const struct split *split,
                                        struct box centers[2])
{
    int plane = (int)split->bin;
    int4 planes = {plane, plane, plane, plane};
    unsigned bit = 1u << split->axis;
    struct box left = box_empty(), right = box_empty();
    struct primitive_ref *low = refs + begin, *high = refs + end;
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
    centers[0] = left;
    centers[1] = right;
    return (uint32_t)(low - refs);
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

/* Ranges of at least this size are binned and partitioned in pieces by all threads. Each side has
 * the same refs as with one thread, but in another order. */
#define SHARED_SPLIT 65536u
#define PIECES 64u

struct shared_split {
    struct build_state *state;
    const struct tree_task *task;
    const struct binning *binning;
    const struct split *split;
    struct bins *bins;
    struct tree_halves *halves;
    /* lefts: the number of refs at the beginning of each piece that belong on the left. */
    uint32_t lefts[PIECES];
};

struct span {
    uint32_t begin, end;
};

static struct span span_of(const struct shared_split *shared, uint32_t piece)
{
    uint64_t count = shared->task->end - shared->task->begin;
    return (struct span){shared->task->begin + (uint32_t)(count * piece / PIECES),
                         shared->task->begin + (uint32_t)(count * (piece + 1) / PIECES)};
}

static void fill_piece(void *context, uint32_t begin, uint32_t end)
{
    const struct shared_split *shared = context;
    uint32_t first = span_of(shared, begin).begin, last = span_of(shared, end - 1).end;
    struct bins bins;
    fill_bins(&bins, shared->binning, shared->state->refs + first, last - first);
    pthread_mutex_lock(&shared->state->lock);
    for (uint32_t i = 0; i < shared->binning->count; i++) {
        merge_boxes(shared->bins->box[i], bins.box[i]);
        shared->bins->count[i] += bins.count[i];
    }
    pthread_mutex_unlock(&shared->state->lock);
}

static void fill_bins_shared(struct build_state *state, const struct tree_task *task,
                             const struct binning *binning, struct bins *bins)
{
    struct shared_split shared = {.state = state, .task = task, .binning = binning, .bins = bins};
    clear_bins(bins, binning->count);
    workers_each(&state->workers, PIECES, 1, fill_piece, &shared);
}

static void partition_piece(void *context, uint32_t begin, uint32_t end)
{
    struct shared_split *shared = context;
    for (uint32_t piece = begin; piece < end; piece++) {
        struct span span = span_of(shared, piece);
        struct box centers[2];
        shared->lefts[piece] = partition(shared->state->refs, span.begin, span.end, shared->binning,
                                         shared->split, centers) -
                               span.begin;
        pthread_mutex_lock(&shared->state->lock);
        for (int side = 0; side < 2; side++)
            box_add(&shared->halves->centers[side], centers[side].lower, centers[side].upper);
        pthread_mutex_unlock(&shared->state->lock);
    }
}

/* wrong_right() returns the refs of a piece that lie before the middle and belong on the right;
 * wrong_left() those that lie after the middle and belong on the left. */
static struct span wrong_right(const struct shared_split *shared, uint32_t piece)
{
    struct span span = span_of(shared, piece);
    uint32_t middle = shared->halves->middle;
    span.begin += shared->lefts[piece];
    span.end = span.end < middle ? span.end : middle;
    return span.begin < span.end ? span : (struct span){0, 0};
}

static struct span wrong_left(const struct shared_split *shared, uint32_t piece)
{
    struct span span = span_of(shared, piece);
    uint32_t middle = shared->halves->middle;
    span.end = span.begin + shared->lefts[piece];
    span.begin = span.begin > middle ? span.begin : middle;
    return span.begin < span.end ? span : (struct span){0, 0};
}

/* Exchanges the n-th misplaced ref before the middle, counted through all pieces, with the n-th
 * after the middle. */
static void exchange_piece(void *context, uint32_t begin, uint32_t end)
{
    const struct shared_split *shared = context;
    struct primitive_ref *refs = shared->state->refs;
    for (uint32_t piece = begin; piece < end; piece++) {
        struct span from = wrong_right(shared, piece);
        uint32_t skip = 0;
        for (uint32_t i = 0; i < piece; i++)
            skip += wrong_right(shared, i).end - wrong_right(shared, i).begin;
        for (uint32_t i = 0; from.begin < from.end; i++) {
            struct span to = wrong_left(shared, i);
            uint32_t skipped = to.end - to.begin < skip ? to.end - to.begin : skip;
            skip -= skipped;
            to.begin += skipped;
            for (; from.begin < from.end && to.begin < to.end; from.begin++, to.begin++) {
                struct primitive_ref swap = refs[from.begin];
                refs[from.begin] = refs[to.begin];
                refs[to.begin] = swap;
            }
        }
    }
}

static void partition_shared(struct build_state *state, const struct tree_task *task,
                             const struct binning *binning, const struct split *split,
                             struct tree_halves *halves)
{
    struct shared_split shared = {
        .state = state, .task = task, .binning = binning, .split = split, .halves = halves};
    halves->centers[0] = halves->centers[1] = box_empty();
    workers_each(&state->workers, PIECES, 1, partition_piece, &shared);
    halves->middle = task->begin;
    for (uint32_t piece = 0; piece < PIECES; piece++)
        halves->middle += shared.lefts[piece];
    workers_each(&state->workers, PIECES, 1, exchange_piece, &shared);
}

static bool split_range(struct build_state *state, const struct tree_task *task,
                        struct tree_halves *halves)
{
    uint32_t count = task->end - task->begin, limit = tree_split_limit(state->kind);
    struct bins bins;
    struct binning binning = make_binning(task);
    bool is_shared = count >= SHARED_SPLIT && !workers_are_alone(&state->workers);
    if (is_shared)
        fill_bins_shared(state, task, &binning, &bins);
    else
        fill_bins(&bins, &binning, state->refs + task->begin, count);
    struct split split = find_split(&bins, binning.count, state->tree[task->slot].bounds);
    bool is_cheaper = split.cost + NODE_COST * split.area < (float)count * split.area;
    if (count <= limit && !is_cheaper)
        return false;
    if (split.bin == 0) {
        tree_split_numbers(state, task, halves);
        return true;
    }
    take_bounds(&bins, binning.count, &split, halves);
    if (is_shared)
        partition_shared(state, task, &binning, &split, halves);
    else
        halves->middle =
            partition(state->refs, task->begin, task->end, &binning, &split, halves->centers);
    return true;
}

void tree_build_binned(struct build_state *state)
{
    tree_split_all(state, split_range, SHARED_SPLIT);
    state->has_bounds = true;
}
