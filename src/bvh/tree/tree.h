/* SPDX-License-Identifier: Apache-2.0 */
/* The data that a build keeps in its scratch: sources, references to primitives, and a binary tree
 * over them.
 *
 * The slots of tree nodes are fixed: the node of range [begin, end) at slot s has its left child at
 * s + 1 and its right child at s + 2 * (primitives on the left). Threads can therefore build parts
 * of the tree in any order and get the same bytes, and the slot of a node determines its range. */
#ifndef ASSAY_BVH_TREE_TREE_H
#define ASSAY_BVH_TREE_TREE_H

#include "src/bvh/input/source.h"
#include "src/bvh/structure.h"
#include "src/bvh/vector.h"
#include "src/bvh/workers.h"

/* Lane 3 of `lower` holds the primitive's number; the mark keeps the lane from being a subnormal
 * float, which slows down arithmetic. Lane 3 of `upper` is 0. */
#define REF_MARK 0x40000000u
struct primitive_ref {
    float4 lower, upper;
};

static inline uint32_t ref_primitive(const struct primitive_ref *ref)
{
    return float_bits(ref->lower[3]) & ~REF_MARK;
}

/* Lane 3 of `lower` holds the slot of the right child as bits, or 0 for a leaf. Lane 3 of `upper`
 * holds the count of primitives as bits. A leaf with several primitives leaves slots unused; these
 * are marked as leaves, too. */
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

/* A part of the tree that is yet to be split. The bounds of its node are valid. */
struct tree_task {
    struct box centers; /* bounds of lower + upper, which is twice the center */
    uint32_t slot, begin, end, depth;
};
#define TREE_TASK_SIZE 4096u /* minimum primitives of a task for another thread */

#define PREPARE_CHUNK 4096u

struct build_state;
struct tree_halves {
    struct box bounds[2], centers[2];
    uint32_t middle;
};

/* Splits the range of a task and moves its refs to their sides. Returns false if the range becomes
 * a leaf. */
typedef bool tree_splitter(struct build_state *state, const struct tree_task *task,
                           struct tree_halves *halves);

struct build_state {
    const struct builder_input *input;
    enum structure_kind kind;
    struct structure_header *header; /* header of the structure being built */
    struct workers workers;
    pthread_mutex_t lock; /* guards the members that several threads change */
    struct source *sources;
    uint32_t *chunk_counts; /* number of refs of each PREPARE_CHUNK primitives */
    struct primitive_ref *refs;
    uint32_t primitive_count, ref_count;
    uint32_t record_capacity; /* capacity of the structure, at least primitive_count */
    struct box bounds, centers;
    float4 unit; /* box_unit() of the bounds */
    bool has_clamped;
    struct tree_node *tree;
    /* The tree's nodes have bounds; in Morton order a later pass computes them. */
    bool has_bounds;
    struct collapse_cost *costs;
    /* For Morton order and sweeps. */
    struct sort_pair *pairs, *pairs_spare;
    struct primitive_ref *refs_spare;
    float *areas;
    tree_splitter *split_range; /* of the quality; not for pairs, nor below SPLIT_DEPTH_LIMIT */
    /* Tasks for any thread; the latest is taken first. */
    struct tree_task *tasks;
    uint32_t task_count, tasks_running;
    pthread_cond_t task_wakeup; /* used with `lock` */
};

/* prepare.c: reads every primitive; fills the refs, the bounds and the report. */
enum builder_result tree_prepare(struct build_state *state, struct builder_report *report);

/* split_tasks.c: builds the whole tree from the root down. A split must not depend on the order
 * of refs, unless only preceding splits determine that order. Ranges of at least `shared`
 * primitives are split one at a time by a splitter that uses all threads; smaller ranges by one
 * thread each. */
void tree_split_all(struct build_state *state, tree_splitter *splitter, uint32_t shared);

/* Leaves a task to a free thread if the task is large enough; returns false otherwise. Tasks have
 * no primitives in common, so the scratch has room for every possible task. */
bool tree_share_task(struct build_state *state, const struct tree_task *task);
/* Runs the shared tasks, and the tasks that they share in turn, on all threads. */
typedef void tree_task_runner(struct build_state *state, struct tree_task task);
void tree_run_tasks(struct build_state *state, tree_task_runner *run);

/* One function per quality. Afterwards the refs, or the pairs in Morton order, are in the order of
 * the tree. */
void tree_build_morton(struct build_state *state);
void tree_build_binned(struct build_state *state);
void tree_build_sweep(struct build_state *state);

/* split_sorted.c: sorts by key, stable. */
void sort_pairs(struct sort_pair *pairs, struct sort_pair *spare, uint32_t count);
/* As sort_pairs(), on all threads. `tallies` has SORT_TALLIES elements. */
#define SORT_PIECES 64u
#define SORT_DIGITS 256u
#define SORT_TALLIES (SORT_PIECES * SORT_DIGITS)

/* The cost of a split in units of testing a primitive: less than that of a node, which replaces up
 * to seven splits. */
#define NODE_COST 0.5f
/* The maximum number of primitives that the area heuristic may leave unsplit. emit.c merges them
 * into larger leaves. */
static inline uint32_t tree_split_limit(enum structure_kind kind)
{
    return structure_is_top(kind) ? 1 : 2;
}

/* split_tasks.c: splits by the highest bit in which the primitives' numbers differ. */
void tree_split_numbers(struct build_state *state, const struct tree_task *task,
                        struct tree_halves *halves);
/* records.c: writes the records of the structure. */
void tree_write_records(struct build_state *state);

/* emit.c: chooses which nodes of the binary tree become nodes of eight and which become leaves.
 * The choice minimizes the SAH cost if each node costs `node_price` (an area) in addition to its
 * own area. */
struct collapse_cost {
    float roots[NODE_WIDTH - 1]; /* roots[i]: least cost of a subtree with at most i + 1 roots */
};

/* Computes the costs of slots [begin, end). Their subtrees must lie within the range or have costs
 * already. */
void collapse_compute_costs(struct build_state *state, uint32_t begin, uint32_t end,
                            float node_price);

/* emit.c: writes the nodes, with their bounds if the tree has them. */
void tree_emit(struct build_state *state);

/* ---- counts the findings of reading primitives */

/* Primitives may be reported in any order; `first` becomes the lowest place. */
void report_place(uint64_t *count, struct builder_place *first, struct builder_place place);
void report_state(struct builder_report *report, enum source_state found,
                  struct builder_place place);
void report_merge(struct builder_report *report, const struct builder_report *more);

#endif
