/* SPDX-License-Identifier: Apache-2.0 */
/* Bounds of records and nodes, and sizes of structures. */
#include "src/bvh/records.h"

/* One float beyond the rounded value: the rounding of the double sum can hide the direction of the
 * error. */
struct box bounds_of_sphere(const float center[3], float radius)
{
    struct box box = box_empty();
    for (int i = 0; i < 3; i++) {
        box.lower[i] = nextafterf(rounded_down((double)center[i] - radius), -INFINITY);
        box.upper[i] = nextafterf(rounded_up((double)center[i] + radius), INFINITY);
    }
    return box;
}

static struct box record_bounds(const struct structure_header *header,
                                const struct builder_resolver *resolver, uint32_t index)
{
    const uint8_t *records = structure_records(header);
    const void *record = records + (uint64_t)index * structure_record_size(header->kind);
    const void *blas = NULL;
    if (structure_is_top(header->kind)) {
        const struct instance_record *instance = record;
        blas = resolver->find(resolver->context, instance->instance.accelerationStructureReference);
    }
    return bounds_of_record(header->kind, record, blas);
}

static float least_of(float4 v)
{
    float4 w = float4_min(v, __builtin_shufflevector(v, v, 2, 3, 0, 1));
    return w[0] < w[1] ? w[0] : w[1];
}

static float greatest_of(float4 v)
{
    float4 w = float4_max(v, __builtin_shufflevector(v, v, 2, 3, 0, 1));
    return w[0] > w[1] ? w[0] : w[1];
}

static struct box node_bounds(const struct wide_node *node)
{
    struct box box;
    for (int axis = 0; axis < 3; axis++) {
        const float *lower = node->lower[axis], *upper = node->upper[axis];
        box.lower[axis] = least_of(float4_min(float4_load(lower), float4_load(lower + 4)));
        box.upper[axis] = greatest_of(float4_max(float4_load(upper), float4_load(upper + 4)));
    }
    box.lower[3] = box.upper[3] = 0;
    return box;
}

static struct box child_bounds(const struct structure_header *header,
                               const struct builder_resolver *resolver, uint32_t child)
{
    struct box box = box_empty();
    if (child == CHILD_EMPTY)
        return box;
    if (!(child & LEAF_BIT))
        return node_bounds(&structure_nodes(header)[child]);
    uint32_t first = leaf_first(child), count = leaf_count(child);
    for (uint32_t i = 0; i < count; i++) {
        struct box one = record_bounds(header, resolver, first + i);
        box_add(&box, one.lower, one.upper);
    }
    return box;
}

struct update {
    const struct structure_header *header;
    const struct builder_resolver *resolver;
};

/* Updates the nodes of [begin, end) whose children are all below `limit`. Children follow their
 * parents, so the loop runs from the last node to the first. */
static void update_nodes(const struct update *update, uint32_t begin, uint32_t end, uint32_t limit)
{
    struct wide_node *nodes = structure_nodes(update->header);
    int4 limits = {(int)limit, (int)limit, (int)limit, (int)limit};
    for (uint32_t index = end; index-- > begin;) {
        struct wide_node *node = &nodes[index];
        int4 children[2];
        memcpy(children, node->child, sizeof(children)); /* leaves are negative */
        if (int4_mask((children[0] < limits) & (children[1] < limits)) != 0xf)
            continue;
        for (uint32_t lane = 0; lane < NODE_WIDTH; lane++) {
            struct box box = child_bounds(update->header, update->resolver, node->child[lane]);
            for (int axis = 0; axis < 3; axis++) {
                node->lower[axis][lane] = box.lower[axis];
                node->upper[axis][lane] = box.upper[axis];
            }
        }
    }
}

/* Skips the nodes with children beyond the chunk, and their ancestors; update_path() computes their
 * bounds later. */
static void update_chunk(void *context, uint32_t begin, uint32_t end)
{
    update_nodes(context, begin, end, end);
}

/* Updates the nodes of the chunk at `begin` whose subtrees extend beyond its end. A subtree is
 * contiguous, so these nodes are ancestors of node `end`. */
static void update_path(const struct update *update, uint32_t begin, uint32_t end)
{
    const struct wide_node *nodes = structure_nodes(update->header);
    uint32_t path[TREE_DEPTH_LIMIT], count = 0;
    for (uint32_t index = 0; index < end;) {
        uint32_t next = 0;
        if (index >= begin)
            path[count++] = index;
        for (uint32_t lane = 0; lane < NODE_WIDTH; lane++) {
            uint32_t child = nodes[index].child[lane];
            if (!(child & LEAF_BIT) && child <= end && child > next)
                next = child;
        }
        index = next;
    }
    for (; count > 0; count--)
        update_nodes(update, path[count - 1], path[count - 1] + 1, LEAF_BIT - 1);
}

#define NODE_CHUNK 4096u

void bounds_update(struct structure_header *header, const struct builder_resolver *resolver,
                   struct workers *workers)
{
    struct update update = {header, resolver};
    struct wide_node *nodes = structure_nodes(header);
    uint32_t count = header->node_count;
    if (workers_are_alone(workers)) {
        update_nodes(&update, 0, count, count);
    } else {
        workers_each(workers, count, NODE_CHUNK, update_chunk, &update);
        for (uint32_t end = count / NODE_CHUNK * NODE_CHUNK; end > 0; end -= NODE_CHUNK)
            if (end < count)
                update_path(&update, end - NODE_CHUNK, end);
    }
    struct box root = count > 0 ? node_bounds(&nodes[0]) : box_empty();
    for (int axis = 0; axis < 3; axis++) {
        header->lower[axis] = root.lower[axis];
        header->upper[axis] = root.upper[axis];
    }
}

/* ---- properties of a structure, for tools */

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
