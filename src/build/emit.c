/* SPDX-License-Identifier: Apache-2.0 */
/* From the binary tree to nodes of four, parents first.
 *
 * Where that takes more nodes than the structure has room for, nodes are given a price, which
 * grows; and where that isn't enough, which only contrived inputs reach, parts of at most `packed`
 * primitives become full trees by position, and `packed` grows until all fits. */
#include "build/bounds.h"
#include "build/tree.h"

#define NO_SLOT 0xffffffffu /* a part without tree nodes: packed */
#define PRICES 4            /* that are tried before parts are packed */

/* A part of the tree: primitives [first, first + count). */
struct part {
    uint32_t slot, first, count;
};

struct waiting_part {
    struct part part;
    uint32_t node, lane; /* where its index goes */
};

struct emission {
    struct build_state *state;
    struct wide_node *nodes;
    uint32_t node_count, capacity, leaf_limit, packed;
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

/* Without areas, the largest by count is opened, again and again. */
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

/* Children of full trees, the last of what is left: n records take n/6 nodes and a few. */
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

/* Children in the order of their primitives. */
static uint32_t open_part(const struct emission *emission, const struct part *part,
                          struct part children[NODE_WIDTH])
{
    if (part->slot == NO_SLOT)
        return open_packed(emission, part, children);
    if (part_is_leaf(emission, part)) { /* the root alone */
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

/* False: no room. */
static bool emit_nodes(struct emission *emission)
{
    const struct build_state *state = emission->state;
    struct waiting_part waiting[TRACE_STACK];
    uint32_t waiting_count = 0;
    waiting[waiting_count++] = (struct waiting_part){make_part(emission, 0, 0), 0, NODE_WIDTH};
    emission->node_count = 0;
    while (waiting_count > 0) {
        struct waiting_part now = waiting[--waiting_count];
        if (emission->node_count == emission->capacity)
            return false;
        uint32_t index = emission->node_count++;
        if (now.lane < NODE_WIDTH)
            emission->nodes[now.node].child[now.lane] = index;
        struct wide_node *node = &emission->nodes[index];
        struct part children[NODE_WIDTH];
        uint32_t count = open_part(emission, &now.part, children);
        for (uint32_t lane = NODE_WIDTH; lane-- > count;)
            clear_lane(node, lane);
        for (uint32_t lane = count; lane-- > 0;) {
            const struct part *child = &children[lane];
            if (child->slot != NO_SLOT && state->has_bounds)
                write_bounds(node, lane, &state->tree[child->slot].bounds);
            if (part_is_leaf(emission, child))
                node->child[lane] = leaf_child(child->first, child->count);
            else
                waiting[waiting_count++] = (struct waiting_part){*child, index, lane};
        }
    }
    return true;
}

/* Prices are multiples of a primitive's share of the root's area. The first costs meshes less than
 * 1% of SAH cost and saves a tenth of the nodes; separate triangles, which leaves of two suit
 * badly, need the second. */
static bool emit_by_cost(struct emission *emission)
{
    struct build_state *state = emission->state;
    float price = 8 * box_half_area(state->bounds) / (float)state->ref_count;
    for (int i = 0; i < PRICES; i++) {
        collapse_weigh(state, price);
        if (emit_nodes(emission))
            return true;
        price *= 12;
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
    };
    if (!state->has_bounds || !emit_by_cost(&emission)) {
        emission.packed = NODE_WIDTH * emission.leaf_limit;
        while (!emit_nodes(&emission))
            emission.packed *= NODE_WIDTH;
    }
    header->node_count = emission.node_count;
    memset(&emission.nodes[header->node_count], 0,
           (header->node_capacity - header->node_count) * sizeof(struct wide_node));
    if (!state->has_bounds || state->has_clamped || emission.packed > 0) {
        bounds_update(header, &state->input->resolver);
        return;
    }
    for (int axis = 0; axis < 3; axis++) {
        header->lower[axis] = state->bounds.lower[axis];
        header->upper[axis] = state->bounds.upper[axis];
    }
}
