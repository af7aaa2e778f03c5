/* SPDX-License-Identifier: Apache-2.0 */
/* What a build holds in its scratch: sources, references to primitives, and a binary tree over
 * them.
 *
 * The tree's nodes have fixed places: that of range [begin, end) at slot s has its left child at
 * s + 1 and its right child at s + 2 * (primitives on the left). So threads can build parts of it
 * in any order and get the same bytes, and a node's range follows from its place. */
#ifndef ASSAY_BVH_TREE_TREE_H
#define ASSAY_BVH_TREE_TREE_H

#include "src/bvh/input/source.h"
#include "src/bvh/structure.h"
#include "src/bvh/vector.h"
#include "src/bvh/workers.h"

/* Bounds are clamped to this size, so that sums and differences of two stay finite; where that
 * changed any, the tree's bounds are computed anew from the records (`has_clamped`). */
#define TREE_COORDINATE_LIMIT 4e37f

/* Lane 3 of `lower` holds the primitive's number, marked so that it is no subnormal float, with
 * which arithmetic is slow; lane 3 of `upper` is 0. */
#define REF_MARK 0x40000000u
struct primitive_ref {
    float4 lower, upper;
};

static inline uint32_t ref_primitive(const struct primitive_ref *ref)
{
    return float_bits(ref->lower[3]) & ~REF_MARK;
}

/* Lane 3 of lower: the slot of the right child, as bits; 0: a leaf. Lane 3 of upper: the count of
 * primitives, as bits. A leaf of several leaves slots unused; those are marked as leaves, too. */
struct tree_node {
    struct box bounds;
};

static inline uint32_t tree_right(const struct tree_node *node)
{
    return float_bits(node->bounds.lower[3]);
}

static inline uint32_t tree_count(const struct tree_node *node)
{
    return float_bits(node->bounds.upper[3]);
}

static inline void tree_set_inner(struct tree_node *node, uint32_t right, uint32_t count)
{
    node->bounds.lower[3] = float_from_bits(right);
    node->bounds.upper[3] = float_from_bits(count);
}

static inline void tree_set_leaf(struct tree_node *node, uint32_t count)
{
    tree_set_inner(node, 0, count);
    for (uint32_t i = 1; i < 2 * count - 1; i++)
        tree_set_inner(node + i, 0, 0);
}

struct sort_pair {
    uint32_t key, index;
};

/* A part of the tree that waits to be split; its node's bounds are known. */
struct tree_task {
    struct box centers; /* of lower + upper: twice the centers */
    uint32_t slot, begin, end, depth;
};
#define TREE_TASK_SIZE 4096u /* primitives that are worth handing to another thread */

#define PREPARE_CHUNK 4096u

struct build_state;
struct tree_halves {
    struct box bounds[2], centers[2];
    uint32_t middle;
};

/* Splits a task's range and puts its refs on their sides; false: a leaf. */
typedef bool tree_splitter(struct build_state *state, const struct tree_task *task,
                           struct tree_halves *halves);

struct build_state {
    const struct builder_input *input;
    enum structure_kind kind;
    struct structure_header *header; /* of the structure being built */
    struct workers workers;
    pthread_mutex_t lock; /* of what several threads add to */
    struct source *sources;
    uint32_t *chunk_counts; /* refs of each PREPARE_CHUNK primitives */
    struct primitive_ref *refs;
    uint32_t primitive_count, ref_count;
    uint32_t record_capacity; /* of the structure: at least as many */
    struct box bounds, centers;
    bool has_clamped;
    struct tree_node *tree;
    bool has_bounds; /* of the tree's nodes: Morton order leaves them to a later pass */
    struct collapse_cost *costs;
    /* Morton order and sweeps */
    struct sort_pair *pairs, *pairs_spare;
    struct primitive_ref *refs_spare;
    float *areas;
    tree_splitter *split_range; /* of the quality */
    /* tasks of several threads, the latest first */
    struct tree_task *tasks;
    uint32_t task_count, tasks_running;
    pthread_cond_t task_wakeup; /* with `lock` */
};

/* prepare.c: reads every primitive and fills refs, bounds and the report */
enum builder_result tree_prepare(struct build_state *state, struct builder_report *report);
uint32_t tree_geometry_of(const struct build_state *state, uint32_t primitive);

/* split_tasks.c: the whole tree from the root down. Splits must not depend on the order of refs,
 * unless only the calls before them do. Ranges of at least `shared` primitives are
 * split one by one, by a splitter that uses all threads; those below by one thread each. */
void tree_split_all(struct build_state *state, tree_splitter *split_range, uint32_t shared);

/* Leaves a task to whichever thread is free, if that is worth it. Tasks have no primitives in
 * common: the scratch has room for all there can be. */
bool tree_share_task(struct build_state *state, const struct tree_task *task);
/* Runs the tasks that have been handed on, and those that they hand on, on all threads. */
typedef void tree_task_runner(struct build_state *state, struct tree_task task);
void tree_run_tasks(struct build_state *state, tree_task_runner *run);

/* One for each quality; refs, or pairs in Morton order, end in the tree's order. */
void tree_build_morton(struct build_state *state);
void tree_build_binned(struct build_state *state);
void tree_build_sweep(struct build_state *state);

/* sort.c: stable, by key */
void sort_pairs(struct sort_pair *pairs, struct sort_pair *spare, uint32_t count);
/* The same on all threads; `tallies` has SORT_TALLIES elements. */
#define SORT_PIECES 64u
#define SORT_DIGITS 256u
#define SORT_TALLIES (SORT_PIECES * SORT_DIGITS)
void sort_pairs_shared(struct workers *workers, struct sort_pair *pairs, struct sort_pair *spare,
                       uint32_t count, uint32_t *tallies);

/* split_tasks.c: what splits by cost have in common; false: a leaf */
/* Of a split, in units of testing a primitive: half of what a node of four costs, since such a node
 * takes the place of up to three splits. */
#define NODE_COST 0.5f
bool tree_split_pair(struct build_state *state, const struct tree_task *task,
                     struct tree_halves *halves);
/* By the highest bit in which primitives' numbers differ */
void tree_split_numbers(struct build_state *state, const struct tree_task *task,
                        struct tree_halves *halves);
/* records.c: writes the structure's records and its geometries */
void tree_write_records(struct build_state *state);

/* collapse.c: which nodes of the binary tree become nodes of four, and which become leaves: the
 * choice of least SAH cost where each node costs `node_price` (an area) on top of its own area. */
struct collapse_cost {
    float roots[3]; /* of a node's part with 1, 2, 3 roots at most */
};

/* For slots [begin, end); the parts below them are among them or have been weighed. */
void collapse_weigh(struct build_state *state, uint32_t begin, uint32_t end, float node_price);
bool collapse_is_leaf(const struct build_state *state, uint32_t slot);
/* The roots of the part below a node that becomes a node of four; returns their count. */
uint32_t collapse_open(const struct build_state *state, uint32_t slot, uint32_t roots[NODE_WIDTH]);

/* emit.c: writes nodes; their bounds, too, where the tree has them */
void tree_emit(struct build_state *state);

#endif
