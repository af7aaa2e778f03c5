/* SPDX-License-Identifier: Apache-2.0 */
/* Properties of a structure, for tools. */
#include "src/bvh/bounds.h"
#include "src/bvh/structure.h"

VkAccelerationStructureTypeKHR builder_type(const void *structure)
{
    const struct structure_header *header = structure;
    return structure_is_top(header->kind) ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                          : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
}

bool builder_bounds(const void *structure, float lower[3], float upper[3])
{
    const struct structure_header *header = structure;
    memcpy(lower, header->lower, sizeof(header->lower));
    memcpy(upper, header->upper, sizeof(header->upper));
    return header->record_count > 0;
}

/* In double, in which areas of float boxes cannot overflow. */
static double lane_area(const struct wide_node *node, uint32_t lane)
{
    double e[3];
    for (int axis = 0; axis < 3; axis++)
        e[axis] = (double)node->upper[axis][lane] - node->lower[axis][lane];
    return e[0] * (e[1] + e[2]) + e[1] * e[2];
}

static double root_area(const struct structure_header *header)
{
    double e[3];
    for (int axis = 0; axis < 3; axis++)
        e[axis] = (double)header->upper[axis] - header->lower[axis];
    return e[0] * (e[1] + e[2]) + e[1] * e[2];
}

struct measured_node {
    uint32_t index, depth;
};

void builder_measure(const void *structure, struct builder_statistics *statistics)
{
    const struct structure_header *header = structure;
    *statistics =
        (struct builder_statistics){.nodes = header->node_count, .active = header->record_count};
    if (header->node_count == 0)
        return;
    double whole = root_area(header), sum = whole;
    struct measured_node waiting[TRACE_STACK];
    uint32_t count = 1;
    waiting[0] = (struct measured_node){0, 1};
    while (count > 0) {
        struct measured_node now = waiting[--count];
        const struct wide_node *node = &structure_nodes(header)[now.index];
        if (now.depth > statistics->depth)
            statistics->depth = now.depth;
        for (uint32_t lane = 0; lane < NODE_WIDTH; lane++) {
            uint32_t child = node->child[lane];
            if (child == CHILD_EMPTY)
                continue;
            bool is_leaf = child & LEAF_BIT;
            statistics->leaves += is_leaf;
            sum += lane_area(node, lane) * (is_leaf ? leaf_count(child) : 1);
            if (!is_leaf)
                waiting[count++] = (struct measured_node){child, now.depth + 1};
        }
    }
    statistics->sah = sum / whole;
}
