/* SPDX-License-Identifier: Apache-2.0 */
/* From the binary tree to nodes of four, parents first.
 *
 * A node's children are found by opening, again and again, the largest child that can be opened
 * (Wald, Benthin, Boulos, "Getting Rid of Packets", 2008). Where that takes more nodes than the
 * structure has room for, which only contrived inputs do, parts of at most `packed` primitives
 * become full trees by position; `packed` grows until all fits. */
#include "build/bounds.h"
#include "build/tree.h"

#define NO_SLOT 0xffffffffu /* a part without tree nodes: packed */

/* A part of the tree: primitives [first, first + count). */
struct part {
    uint32_t slot, first, count;
    float size; /* which to open first */
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
    if (part->slot == NO_SLOT)
        return part->count <= emission->leaf_limit;
    return tree_right(&emission->state->tree[part->slot]) == 0;
}

static struct part make_part(const struct emission *emission, uint32_t slot, uint32_t first,
                             uint32_t count)
{
    struct part part = {slot, first, count, (float)count};
    if (part_is_leaf(emission, &part))
        part.size = -1;
    else if (count <= emission->packed) /* is no longer opened into its parent */
        part = (struct part){NO_SLOT, first, count, -1};
    else if (emission->state->has_bounds)
        part.size = box_half_area(emission->state->tree[slot].bounds);
    return part;
}

/* Replaces the part by its two halves: one in its place, one at the end. */
static void open_part(const struct emission *emission, struct part *parts, uint32_t index,
                      uint32_t end)
{
    struct part part = parts[index];
    uint32_t right = tree_right(&emission->state->tree[part.slot]);
    uint32_t on_left = (right - part.slot) / 2;
    parts[index] = make_part(emission, part.slot + 1, part.first, on_left);
    parts[end] = make_part(emission, right, part.first + on_left, part.count - on_left);
}

static uint32_t open_tree_part(const struct emission *emission, struct part part,
                               struct part children[NODE_WIDTH])
{
    children[0] = part;
    open_part(emission, children, 0, 1);
    uint32_t count = 2;
    while (count < NODE_WIDTH) {
        uint32_t largest = 0;
        for (uint32_t i = 1; i < count; i++)
            if (children[i].size > children[largest].size)
                largest = i;
        if (children[largest].size < 0)
            break;
        open_part(emission, children, largest, count++);
    }
    return count;
}

/* Children of full trees, the last of what is left: n records take n/12 nodes and a few. */
static uint32_t open_packed_part(const struct emission *emission, struct part part,
                                 struct part children[NODE_WIDTH])
{
    uint32_t each = emission->leaf_limit, count = 0;
    while ((uint64_t)each * NODE_WIDTH < part.count)
        each *= NODE_WIDTH;
    for (uint32_t done = 0; done < part.count; done += each) {
        uint32_t left = part.count - done;
        children[count++] =
            (struct part){NO_SLOT, part.first + done, left < each ? left : each, -1};
    }
    return count;
}

static uint32_t open_children(const struct emission *emission, struct part part,
                              struct part children[NODE_WIDTH])
{
    if (part_is_leaf(emission, &part)) { /* the root alone */
        children[0] = part;
        return 1;
    }
    if (part.slot == NO_SLOT)
        return open_packed_part(emission, part, children);
    return open_tree_part(emission, part, children);
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
    struct part root = make_part(emission, 0, 0, state->ref_count);
    waiting[waiting_count++] = (struct waiting_part){root, 0, NODE_WIDTH};
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
        uint32_t count = open_children(emission, now.part, children);
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

void tree_emit(struct build_state *state)
{
    struct structure_header *header = state->header;
    struct emission emission = {
        .state = state,
        .nodes = structure_nodes(header),
        .capacity = structure_node_capacity(state->kind, state->ref_count),
        .leaf_limit = structure_leaf_limit(state->kind),
    };
    while (!emit_nodes(&emission))
        emission.packed = emission.packed == 0 ? 4 * LEAF_RECORDS : 4 * emission.packed;
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
