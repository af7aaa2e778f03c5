/* SPDX-License-Identifier: Apache-2.0 */
/* Collapses a binary tree into nodes of eight children at least cost, by dynamic programming from
 * the leaves up. After Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs", 2017, section 3.1, with an additional price per node, which trades cost
 * for memory. */
#include "src/bvh/records.h"
#include "src/bvh/tree/tree.h"

static float least(float a, float b)
{
    return a < b ? a : b;
}

/* In the unit of the root, in which areas do not overflow. */
static float slot_area(const struct build_state *state, uint32_t slot)
{
    struct box box = state->tree[slot].bounds;
    box.lower[3] = box.upper[3] = 0; /* products of the numbers, subnormal floats, are slow */
    return box_half_area_in(box, state->unit);
}

/* Sets sums[k] to the least cost of k + 1 roots, of which each child of the node gets at least
 * one. */
static void share_roots(const struct build_state *state, uint32_t slot, float sums[NODE_WIDTH])
{
    const struct collapse_cost *left = &state->costs[slot + 1];
    const struct collapse_cost *right = &state->costs[tree_right(&state->tree[slot])];
    float padded[2 * NODE_WIDTH];
    float4 low = float4_all(INFINITY), high = low;
    for (uint32_t i = 0; i < NODE_WIDTH; i++)
        padded[i] = INFINITY;
    memcpy(padded + NODE_WIDTH, right->roots, sizeof(right->roots));
    for (uint32_t i = 0; i < NODE_WIDTH - 1; i++) { /* the left child gets i + 1 roots */
        float4 cost = float4_all(left->roots[i]);
        low = float4_min(cost + float4_load(padded + NODE_WIDTH - 1 - i), low);
        high = float4_min(cost + float4_load(padded + NODE_WIDTH + 3 - i), high);
    }
    memcpy(sums, &low, sizeof(low));
    memcpy(sums + 4, &high, sizeof(high));
}

/* Visits slots from last to first, since children follow their parents. Unused slots are leaves
 * without primitives, of cost 0. */
void collapse_compute_costs(struct build_state *state, uint32_t begin, uint32_t end,
                            float node_price)
{
    uint32_t limit = structure_leaf_limit(state->kind);
    for (uint32_t slot = end; slot-- > begin;) {
        const struct tree_node *node = &state->tree[slot];
        struct collapse_cost *cost = &state->costs[slot];
        uint32_t right = tree_right(node), count = tree_count(node);
        if (count == 0)
            continue;
        float area = slot_area(state, slot), as_leaf = area * (float)count;
        if (right == 0) {
            for (uint32_t i = 0; i < NODE_WIDTH - 1; i++)
                cost->roots[i] = as_leaf;
            continue;
        }
        float sums[NODE_WIDTH];
        share_roots(state, slot, sums);
        float as_node = area + node_price + sums[NODE_WIDTH - 1];
        cost->roots[0] = count <= limit ? least(as_leaf, as_node) : as_node;
        for (uint32_t i = 1; i < NODE_WIDTH - 1; i++)
            cost->roots[i] = least(cost->roots[i - 1], sums[i]);
    }
}

static bool collapse_is_leaf(const struct build_state *state, uint32_t slot)
{
    const struct tree_node *node = &state->tree[slot];
    uint32_t count = tree_count(node);
    return tree_right(node) == 0 ||
           (count <= structure_leaf_limit(state->kind) &&
            state->costs[slot].roots[0] == slot_area(state, slot) * (float)count);
}

/* Returns how many of `roots` the left child gets if the subtree of a node is split among both
 * children. */
static uint32_t roots_on_left(const struct build_state *state, uint32_t slot, uint32_t roots)
{
    const float *l = state->costs[slot + 1].roots;
    const float *r = state->costs[tree_right(&state->tree[slot])].roots;
    uint32_t best = 1;
    for (uint32_t left = 2; left < roots; left++)
        if (l[left - 1] + r[roots - left - 1] < l[best - 1] + r[roots - best - 1])
            best = left;
    return best;
}

static uint32_t best_child_count(const struct build_state *state, uint32_t slot)
{
    float sums[NODE_WIDTH];
    uint32_t count = NODE_WIDTH;
    share_roots(state, slot, sums);
    while (count > 2 && sums[count - 2] == sums[count - 1])
        count--;
    return count;
}

struct forest {
    uint32_t slot, roots;
};

/* Returns the number of roots, and the roots, of the subtree below a slot that becomes a node. */
static uint32_t collapse_open(const struct build_state *state, uint32_t slot,
                              uint32_t roots[NODE_WIDTH])
{
    struct forest waiting[NODE_WIDTH + 1];
    uint32_t count = 0, found = 0;
    waiting[count++] = (struct forest){slot, best_child_count(state, slot)};
    while (count > 0) {
        struct forest now = waiting[--count];
        const float *cost = state->costs[now.slot].roots;
        if (now.slot != slot)
            while (now.roots > 1 && cost[now.roots - 1] == cost[now.roots - 2])
                now.roots--;
        if (now.roots == 1) {
            roots[found++] = now.slot;
            continue;
        }
        uint32_t left = roots_on_left(state, now.slot, now.roots);
        waiting[count++] = (struct forest){tree_right(&state->tree[now.slot]), now.roots - left};
        waiting[count++] = (struct forest){now.slot + 1, left};
    }
    return found;
}

/* ---- Converts the binary tree to nodes of eight children, parents first.
 *
 * Several threads compute the costs of parts of the tree and count the nodes of each part. One
 * thread visits the nodes above the parts, which determines the number of every node. Then the
 * parts are written in any order.
 *
 * If the nodes exceed the capacity of the structure, each node is given a price, which grows with
 * each attempt. If that does not suffice, which happens only for contrived inputs, parts of at most
 * `packed` primitives become full trees by position, and `packed` grows until the nodes fit. */

#define NO_SLOT 0xffffffffu /* a packed part, which has no tree nodes */
#define PRICES 4            /* number of prices to try before parts are packed */

/* A part of the tree: primitives [first, first + count). */
struct part {
    uint32_t slot, first, count;
};

struct waiting_part {
    struct part part;
    uint32_t node, lane; /* the child slot that receives the index of the part */
};

/* The part that one thread costs or emits. */
#define SHARED_PART 4096u /* maximum primitives */
struct shared_part {
    struct part part;
    uint32_t node, nodes; /* number of the first node; node count */
};

struct emission {
    struct build_state *state;
    struct wide_node *nodes; /* NULL: count the nodes only */
    uint32_t capacity, leaf_limit, packed;
    float price;
    bool is_shared;
    struct shared_part *parts; /* in the order of the tree */
    uint32_t part_count;
};

static bool part_is_leaf(const struct emission *emission, const struct part *part)
{
    const struct build_state *state = emission->state;
    if (part->slot == NO_SLOT)
        return part->count <= emission->leaf_limit;
    return state->has_bounds ? collapse_is_leaf(state, part->slot)
                             : tree_right(&state->tree[part->slot]) == 0;
}

static struct part make_part(const struct emission *emission, uint32_t slot, uint32_t first)
{
    uint32_t count = tree_count(&emission->state->tree[slot]);
    return (struct part){count <= emission->packed ? NO_SLOT : slot, first, count};
}

/* Without areas: opens the root with the most primitives until there are eight. */
static uint32_t open_by_count(const struct build_state *state, uint32_t slot, uint32_t packed,
                              uint32_t roots[NODE_WIDTH])
{
    uint32_t count = 1;
    roots[0] = slot;
    while (count < NODE_WIDTH) {
        uint32_t largest = 0;
        for (uint32_t i = 1; i < count; i++)
            if (tree_count(&state->tree[roots[i]]) > tree_count(&state->tree[roots[largest]]))
                largest = i;
        const struct tree_node *node = &state->tree[roots[largest]];
        if (tree_right(node) == 0 || tree_count(node) <= packed)
            break;
        memmove(&roots[largest + 2], &roots[largest + 1], (count - largest - 1) * sizeof(roots[0]));
        roots[largest + 1] = tree_right(node);
        roots[largest]++;
        count++;
    }
    return count;
}

/* The children of a packed part are full trees; the last child takes the rest. n records need n/28
 * nodes and a few more. */
static uint32_t open_packed(const struct emission *emission, const struct part *part,
                            struct part children[NODE_WIDTH])
{
    uint32_t each = emission->leaf_limit, count = 0;
    while ((uint64_t)each * NODE_WIDTH < part->count)
        each *= NODE_WIDTH;
    for (uint32_t done = 0; done < part->count; done += each) {
        uint32_t left = part->count - done;
        children[count++] = (struct part){NO_SLOT, part->first + done, left < each ? left : each};
    }
    return count;
}

/* Returns the children in the order of their primitives. */
static uint32_t open_part(const struct emission *emission, const struct part *part,
                          struct part children[NODE_WIDTH])
{
    if (part->slot == NO_SLOT)
        return open_packed(emission, part, children);
    if (part_is_leaf(emission, part)) { /* only the root can be a leaf here */
        children[0] = *part;
        return 1;
    }
    uint32_t roots[NODE_WIDTH], first = part->first;
    uint32_t count = emission->state->has_bounds
                         ? collapse_open(emission->state, part->slot, roots)
                         : open_by_count(emission->state, part->slot, emission->packed, roots);
    for (uint32_t i = 0; i < count; i++) {
        children[i] = make_part(emission, roots[i], first);
        first += children[i].count;
    }
    return count;
}

static void clear_lane(struct wide_node *node, uint32_t lane)
{
    node->child[lane] = CHILD_EMPTY;
    for (int axis = 0; axis < 3; axis++) {
        node->lower[axis][lane] = INFINITY;
        node->upper[axis][lane] = -INFINITY;
    }
}

static void write_bounds(struct wide_node *node, uint32_t lane, const struct box *bounds)
{
    for (int axis = 0; axis < 3; axis++) {
        node->lower[axis][lane] = bounds->lower[axis];
        node->upper[axis][lane] = bounds->upper[axis];
    }
}

/* Writes one node except the indices of its inner children; pushes those children onto the
 * stack. */
static uint32_t emit_node(const struct emission *emission, const struct part *part, uint32_t index,
                          struct waiting_part *waiting, uint32_t waiting_count)
{
    struct wide_node *node = emission->nodes ? &emission->nodes[index] : NULL;
    struct part children[NODE_WIDTH];
    uint32_t count = open_part(emission, part, children);
    for (uint32_t lane = NODE_WIDTH; node && lane-- > count;)
        clear_lane(node, lane);
    for (uint32_t lane = count; lane-- > 0;) {
        const struct part *child = &children[lane];
        if (node && child->slot != NO_SLOT && emission->state->has_bounds)
            write_bounds(node, lane, &emission->state->tree[child->slot].bounds);
        if (!part_is_leaf(emission, child))
            waiting[waiting_count++] = (struct waiting_part){*child, index, lane};
        else if (node)
            node->child[lane] = leaf_child(child->first, child->count);
    }
    return waiting_count;
}

#define NO_ROOM 0xffffffffu

/* Emits the nodes of a part from number `index` on. Returns the number after the last node, or
 * NO_ROOM. If the emission is shared, this function skips shared parts: counting lists them, and
 * writing numbers them. */
static uint32_t emit_nodes(struct emission *emission, struct part root, uint32_t index)
{
    struct waiting_part waiting[TRACE_STACK];
    struct shared_part *next = emission->parts;
    uint32_t waiting_count = 0;
    waiting[waiting_count++] = (struct waiting_part){root, 0, NODE_WIDTH};
    while (waiting_count > 0) {
        struct waiting_part now = waiting[--waiting_count];
        if (index >= emission->capacity)
            return NO_ROOM;
        if (emission->nodes && now.lane < NODE_WIDTH)
            emission->nodes[now.node].child[now.lane] = index;
        bool is_left_out = emission->is_shared && now.part.count <= SHARED_PART;
        if (!is_left_out) {
            waiting_count = emit_node(emission, &now.part, index++, waiting, waiting_count);
        } else if (!emission->nodes) {
            emission->parts[emission->part_count++].part = now.part;
        } else {
            next->node = index;
            index += next++->nodes;
        }
    }
    return index <= emission->capacity ? index : NO_ROOM;
}

static void count_parts(void *context, uint32_t begin, uint32_t end)
{
    const struct emission *whole = context;
    struct emission emission = *whole;
    emission.is_shared = false;
    emission.nodes = NULL;
    emission.capacity = NO_ROOM;
    for (uint32_t i = begin; i < end; i++)
        whole->parts[i].nodes = emit_nodes(&emission, whole->parts[i].part, 0);
}

static void write_parts(void *context, uint32_t begin, uint32_t end)
{
    const struct emission *whole = context;
    struct emission emission = *whole;
    emission.is_shared = false;
    for (uint32_t i = begin; i < end; i++)
        emit_nodes(&emission, whole->parts[i].part, whole->parts[i].node);
}

/* Returns false if the nodes do not fit. The refs are no longer needed when nodes are emitted;
 * their memory, which is larger, holds the parts. */
static bool emit_all(struct emission *emission)
{
    struct workers *workers = &emission->state->workers;
    struct part root = make_part(emission, 0, 0);
    if (emission->is_shared) {
        struct emission listing = *emission;
        listing.nodes = NULL;
        listing.part_count = 0;
        emit_nodes(&listing, root, 0);
        emission->part_count = listing.part_count;
        workers_each(workers, emission->part_count, 1, count_parts, emission);
    }
    uint32_t end = emit_nodes(emission, root, 0);
    if (end == NO_ROOM)
        return false;
    workers_each(workers, emission->part_count, 1, write_parts, emission);
    emission->state->header->node_count = end;
    return true;
}

static void cost_parts(void *context, uint32_t begin, uint32_t end)
{
    const struct emission *emission = context;
    for (uint32_t i = begin; i < end; i++) {
        const struct part *part = &emission->parts[i].part;
        collapse_compute_costs(emission->state, part->slot, part->slot + 2 * part->count - 1,
                               emission->price);
    }
}

/* Lists the parts to be costed, in the order of the tree. */
static void list_cost_parts(struct emission *emission)
{
    const struct tree_node *tree = emission->state->tree;
    uint32_t waiting[TREE_DEPTH_LIMIT + 1], count = 0;
    emission->part_count = 0;
    waiting[count++] = 0;
    while (count > 0) {
        uint32_t slot = waiting[--count], primitives = tree_count(&tree[slot]);
        if (primitives <= SHARED_PART) {
            emission->parts[emission->part_count++].part = (struct part){slot, 0, primitives};
            continue;
        }
        waiting[count++] = tree_right(&tree[slot]);
        waiting[count++] = slot + 1;
    }
}

/* Costs the parts, then the slots above them. */
static void cost_all(struct emission *emission)
{
    struct build_state *state = emission->state;
    uint32_t end = 2 * state->ref_count - 1;
    if (emission->is_shared) {
        list_cost_parts(emission);
        workers_each(&state->workers, emission->part_count, 1, cost_parts, emission);
        for (uint32_t i = emission->part_count; i-- > 0;) {
            const struct part *part = &emission->parts[i].part;
            collapse_compute_costs(state, part->slot + 2 * part->count - 1, end, emission->price);
            end = part->slot;
        }
    }
    collapse_compute_costs(state, 0, end, emission->price);
}

/* Prices are multiples of the root's area per primitive. The first price adds up
 * to a tenth to the SAH cost of meshes and saves up to half of the nodes. Rays are as fast: a leaf
 * of four triangles is tested in the time of a leaf of one. */
static bool emit_by_cost(struct emission *emission)
{
    struct build_state *state = emission->state;
    emission->price = 8 * box_half_area_in(state->bounds, state->unit) / (float)state->ref_count;
    for (int i = 0; i < PRICES; i++) {
        cost_all(emission);
        if (emit_all(emission))
            return true;
        emission->price *= 12;
    }
    return false;
}

void tree_emit(struct build_state *state)
{
    struct structure_header *header = state->header;
    struct emission emission = {
        .state = state,
        .nodes = structure_nodes(header),
        .capacity = structure_node_capacity(state->kind, state->ref_count),
        .leaf_limit = structure_leaf_limit(state->kind),
        .is_shared = !workers_are_alone(&state->workers) && state->ref_count > SHARED_PART,
        .parts = (void *)state->refs,
    };
    state->unit = box_unit(state->bounds);
    if (!state->has_bounds || !emit_by_cost(&emission)) {
        emission.packed = NODE_WIDTH * emission.leaf_limit;
        while (!emit_all(&emission))
            emission.packed *= 2;
    }
    memset(&emission.nodes[header->node_count], 0,
           (header->node_capacity - header->node_count) * sizeof(struct wide_node));
    if (!state->has_bounds || state->has_clamped || emission.packed > 0) {
        bounds_update(header, &state->input->resolver, &state->workers);
        return;
    }
    for (int axis = 0; axis < 3; axis++) {
        header->lower[axis] = state->bounds.lower[axis];
        header->upper[axis] = state->bounds.upper[axis];
    }
}
