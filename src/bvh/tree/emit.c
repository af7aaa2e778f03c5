/* SPDX-License-Identifier: Apache-2.0 */
/* From the binary tree to nodes of four, parents first.
 *
 * Several threads weigh parts of the tree and count their nodes; one goes through what is above,
 * and so numbers them all; then parts are written in any order.
 *
 * Where that takes more nodes than the structure has room for, nodes are given a price, which
 * grows; and where that isn't enough, which only contrived inputs reach, parts of at most `packed`
 * primitives become full trees by position, and `packed` grows until all fits. */
#include "src/bvh/bounds.h"
#include "src/bvh/tree/tree.h"

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

/* What one thread weighs or emits. */
#define SHARED_PART 4096u /* primitives at most */
struct shared_part {
    struct part part;
    uint32_t node, nodes; /* the first one's number; how many */
};

struct emission {
    struct build_state *state;
    struct wide_node *nodes; /* NULL: they are only counted */
    uint32_t capacity, leaf_limit, packed;
    float price;
    bool is_shared;
    struct shared_part *parts; /* in order */
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

/* One node, but for the numbers of its children that are nodes; those are put on the stack. */
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

/* Nodes from number `index` on for a part of the tree; returns the number after them. Where it is
 * shared, shared parts are left out; those are listed while nodes are counted, and numbered while
 * nodes are written. */
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

/* False: no room. Refs aren't needed any more where nodes are emitted: their memory, of more bytes
 * each, has room for the parts. */
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

static void weigh_parts(void *context, uint32_t begin, uint32_t end)
{
    const struct emission *emission = context;
    for (uint32_t i = begin; i < end; i++) {
        const struct part *part = &emission->parts[i].part;
        collapse_weigh(emission->state, part->slot, part->slot + 2 * part->count - 1,
                       emission->price);
    }
}

/* In order. */
static void list_weighed(struct emission *emission)
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

/* Parts, then the slots above them. */
static void weigh_all(struct emission *emission)
{
    struct build_state *state = emission->state;
    uint32_t end = 2 * state->ref_count - 1;
    if (emission->is_shared) {
        list_weighed(emission);
        workers_each(&state->workers, emission->part_count, 1, weigh_parts, emission);
        for (uint32_t i = emission->part_count; i-- > 0;) {
            const struct part *part = &emission->parts[i].part;
            collapse_weigh(state, part->slot + 2 * part->count - 1, end, emission->price);
            end = part->slot;
        }
    }
    collapse_weigh(state, 0, end, emission->price);
}

/* Prices are multiples of a primitive's share of the root's area. The first costs meshes less than
 * 1% of SAH cost and saves a tenth of the nodes; separate triangles, which leaves of two suit
 * badly, need the second. */
static bool emit_by_cost(struct emission *emission)
{
    struct build_state *state = emission->state;
    emission->price = 8 * box_half_area(state->bounds) / (float)state->ref_count;
    for (int i = 0; i < PRICES; i++) {
        weigh_all(emission);
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
    if (!state->has_bounds || !emit_by_cost(&emission)) {
        emission.packed = NODE_WIDTH * emission.leaf_limit;
        while (!emit_all(&emission))
            emission.packed *= NODE_WIDTH;
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
