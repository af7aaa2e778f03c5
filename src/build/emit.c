/* SPDX-License-Identifier: Apache-2.0 */
/* From the binary tree to nodes of four, parents first.
 *
 * Several threads weigh parts of the tree and count their nodes, one goes through the nodes above
 * those and so numbers them all, then parts are written in any order.
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

/* What one thread weighs and emits. */
struct emit_part {
    struct part part;
    uint32_t node, nodes; /* the first one's number; how many */
};

struct emission {
    struct build_state *state;
    struct wide_node *nodes; /* NULL: they are only counted */
    uint32_t capacity, leaf_limit, packed;
    float price;
    struct emit_part *parts; /* in order; who meets one leaves it to others */
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
    uint32_t count = 1, whole = packed; /* parts of at most `whole` aren't opened */
    if (tree_count(&state->tree[slot]) > EMIT_PART && whole < EMIT_PART)
        whole = EMIT_PART;
    roots[0] = slot;
    while (count < NODE_WIDTH) {
        uint32_t largest = 0;
        for (uint32_t i = 1; i < count; i++)
            if (tree_count(&state->tree[roots[i]]) > tree_count(&state->tree[roots[largest]]))
                largest = i;
        const struct tree_node *node = &state->tree[roots[largest]];
        if (tree_right(node) == 0 || tree_count(node) <= whole)
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

/* Of the list, the one that begins where `part` does; lists and trees are in the same order. */
static struct emit_part *find_part(const struct emission *emission, const struct part *part,
                                   struct emit_part **next)
{
    const struct emit_part *end = emission->parts + emission->part_count;
    if (part->slot == NO_SLOT)
        return NULL;
    while (*next < end && (*next)->part.slot < part->slot)
        ++*next;
    return *next < end && (*next)->part.slot == part->slot ? *next : NULL;
}

/* Nodes from number `index` on for a part of the tree; returns the number after them. */
static uint32_t emit_nodes(const struct emission *emission, struct part root, uint32_t index)
{
    struct waiting_part waiting[TRACE_STACK];
    struct emit_part *next = emission->parts;
    uint32_t waiting_count = 0;
    waiting[waiting_count++] = (struct waiting_part){root, 0, NODE_WIDTH};
    while (waiting_count > 0) {
        struct waiting_part now = waiting[--waiting_count];
        struct emit_part *others = find_part(emission, &now.part, &next);
        if (index >= emission->capacity)
            return NO_ROOM;
        if (emission->nodes && now.lane < NODE_WIDTH)
            emission->nodes[now.node].child[now.lane] = index;
        if (others) {
            others->node = index;
            index += others->nodes;
            continue;
        }
        waiting_count = emit_node(emission, &now.part, index++, waiting, waiting_count);
    }
    return index <= emission->capacity ? index : NO_ROOM;
}

static void count_parts(void *context, uint32_t begin, uint32_t end)
{
    const struct emission *whole = context;
    struct emission emission = *whole;
    emission.nodes = NULL;
    emission.part_count = 0;
    emission.capacity = NO_ROOM;
    for (uint32_t i = begin; i < end; i++) {
        struct part part = whole->parts[i].part;
        if (whole->state->has_bounds)
            collapse_weigh(whole->state, part.slot, part.slot + 2 * part.count - 1, whole->price);
        whole->parts[i].nodes = emit_nodes(&emission, part, 0);
    }
}

static void write_parts(void *context, uint32_t begin, uint32_t end)
{
    const struct emission *whole = context;
    struct emission emission = *whole;
    emission.part_count = 0;
    for (uint32_t i = begin; i < end; i++)
        emit_nodes(&emission, whole->parts[i].part, whole->parts[i].node);
}

/* Slots that are above all parts. */
static void weigh_top(const struct emission *emission)
{
    uint32_t end = 2 * emission->state->ref_count - 1;
    for (uint32_t i = emission->part_count; i-- > 0;) {
        const struct part *part = &emission->parts[i].part;
        collapse_weigh(emission->state, part->slot + 2 * part->count - 1, end, emission->price);
        end = part->slot;
    }
    collapse_weigh(emission->state, 0, end, emission->price);
}

/* False: no room. */
static bool emit_all(struct emission *emission)
{
    struct workers *workers = &emission->state->workers;
    workers_each(workers, emission->part_count, 1, count_parts, emission);
    if (emission->state->has_bounds)
        weigh_top(emission);
    uint32_t end = emit_nodes(emission, make_part(emission, 0, 0), 0);
    if (end == NO_ROOM)
        return false;
    workers_each(workers, emission->part_count, 1, write_parts, emission);
    emission->state->header->node_count = end;
    return true;
}

/* Those that may become packed alone aren't worth it. Refs aren't needed any more where nodes are
 * emitted: their memory, of more bytes each, has room for the parts. */
static void find_parts(struct emission *emission)
{
    const struct build_state *state = emission->state;
    struct part waiting[TREE_DEPTH_LIMIT + 1];
    uint32_t count = 0;
    emission->parts = (void *)state->refs;
    waiting[count++] = (struct part){0, 0, state->ref_count};
    while (count > 0) {
        struct part now = waiting[--count];
        if (now.count <= EMIT_PART) {
            if (now.count > NODE_WIDTH * emission->leaf_limit)
                emission->parts[emission->part_count++] = (struct emit_part){.part = now};
            continue;
        }
        uint32_t right = tree_right(&state->tree[now.slot]);
        uint32_t left_count = (right - now.slot) / 2;
        waiting[count++] = (struct part){right, now.first + left_count, now.count - left_count};
        waiting[count++] = (struct part){now.slot + 1, now.first, left_count};
    }
}

/* Prices are multiples of a primitive's share of the root's area. The first costs meshes less than
 * 1% of SAH cost and saves a tenth of the nodes; separate triangles, which leaves of two suit
 * badly, need the second. */
static bool emit_by_cost(struct emission *emission)
{
    struct build_state *state = emission->state;
    emission->price = 8 * box_half_area(state->bounds) / (float)state->ref_count;
    for (int i = 0; i < PRICES; i++) {
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
    };
    if (!workers_are_alone(&state->workers) && state->ref_count > EMIT_PART)
        find_parts(&emission);
    if (!state->has_bounds || !emit_by_cost(&emission)) {
        emission.packed = NODE_WIDTH * emission.leaf_limit;
        while (!emit_all(&emission)) {
            emission.packed *= NODE_WIDTH;
            emission.part_count = 0;
        }
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
