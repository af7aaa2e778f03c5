/* SPDX-License-Identifier: Apache-2.0 */
/* Collapses a binary tree into nodes of four children at least cost, by dynamic programming from
 * the leaves up. After Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs", 2017, section 3.1, with an additional price per node, which trades cost
 * for memory. */
#include "src/bvh/tree/tree.h"

static float least(float a, float b)
{
    return a < b ? a : b;
}

/* Visits slots from last to first, since children follow their parents. Unused slots are leaves
 * without primitives, of cost 0. Areas come from clamped bounds (4e37); they may be infinite but
 * never NaN. */
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
        float area = box_half_area(node->bounds), as_leaf = area * (float)count;
        if (right == 0) {
            cost->roots[0] = cost->roots[1] = cost->roots[2] = as_leaf;
            continue;
        }
        const float *l = state->costs[slot + 1].roots, *r = state->costs[right].roots;
        float two = l[0] + r[0];
        float three = least(l[0] + r[1], l[1] + r[0]);
        float four = least(least(l[0] + r[2], l[2] + r[0]), l[1] + r[1]);
        float as_node = area + node_price + least(four, least(three, two));
        cost->roots[0] = count <= limit ? least(as_leaf, as_node) : as_node;
        cost->roots[1] = least(cost->roots[0], two);
        cost->roots[2] = least(cost->roots[1], three);
    }
}

bool collapse_is_leaf(const struct build_state *state, uint32_t slot)
{
    const struct tree_node *node = &state->tree[slot];
    uint32_t count = tree_count(node);
    return tree_right(node) == 0 ||
           (count <= structure_leaf_limit(state->kind) &&
            state->costs[slot].roots[0] == box_half_area(node->bounds) * (float)count);
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
    const float *l = state->costs[slot + 1].roots;
    const float *r = state->costs[tree_right(&state->tree[slot])].roots;
    float two = l[0] + r[0], three = least(l[0] + r[1], l[1] + r[0]);
    float four = least(least(l[0] + r[2], l[2] + r[0]), l[1] + r[1]);
    return four < three && four < two ? 4 : three < two ? 3 : 2;
}

struct forest {
    uint32_t slot, roots;
};

uint32_t collapse_open(const struct build_state *state, uint32_t slot, uint32_t roots[NODE_WIDTH])
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
