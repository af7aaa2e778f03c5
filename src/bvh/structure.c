/* SPDX-License-Identifier: Apache-2.0 */
/* The layout of structures, and the validation of untrusted ones. */
#include "src/bvh/structure.h"

#include "src/bvh/input/displacement.h"

struct instance_record *structure_instance(const struct structure_header *header, uint64_t index)
{
    uint8_t *records = structure_records(header);
    return (void *)(records + index * structure_record_size(header->kind));
}

uint32_t structure_leaf_limit(enum structure_kind kind)
{
    return structure_is_top(kind) ? 1 : LEAF_RECORDS;
}

/* At most 1.25 times the size with the fewest nodes: see the head of structure.h. Each leaf of a
 * TLAS has one instance, so n instances need n/3 to 2n/3 nodes. */
uint32_t structure_node_capacity(enum structure_kind kind, uint32_t records)
{
    uint64_t nodes = (uint64_t)records * 28 / 100;
    if (structure_record_size(kind) == sizeof(struct aabb_record))
        nodes = (uint64_t)records * 27 / 100;
    if (structure_is_top(kind))
        nodes = (uint64_t)records * 2 / 3;
    return (uint32_t)nodes + (records != 0);
}

static uint64_t aligned(uint64_t size)
{
    return (size + BUILDER_ALIGNMENT - 1) & ~(uint64_t)(BUILDER_ALIGNMENT - 1);
}

/* A 32-bit count times a size below 256 cannot wrap. */
void structure_lay_out(struct structure_header *header, enum structure_kind kind,
                       uint32_t geometry_count, uint32_t record_capacity, uint32_t node_capacity,
                       bool has_micromaps)
{
    *header = (struct structure_header){
        .magic = STRUCTURE_MAGIC,
        .version = STRUCTURE_VERSION,
        .kind = kind,
        .geometry_count = geometry_count,
        .record_capacity = record_capacity,
        .node_capacity = node_capacity,
        .micromap_count = has_micromaps ? geometry_count : 0,
    };
    header->geometries = aligned(sizeof(*header));
    header->records =
        header->geometries + aligned((uint64_t)geometry_count * sizeof(struct structure_geometry));
    header->nodes =
        header->records + aligned((uint64_t)record_capacity * structure_record_size(kind));
    header->size = header->nodes + aligned((uint64_t)node_capacity * sizeof(struct wide_node)) +
                   aligned((uint64_t)header->micromap_count * sizeof(uint64_t));
}

static bool layout_is_well_formed(const struct structure_header *header, uint64_t size)
{
    if (size < sizeof(*header) || header->magic != STRUCTURE_MAGIC ||
        header->version != STRUCTURE_VERSION || header->kind >= STRUCTURE_KINDS ||
        header->record_capacity > BUILDER_MAX_PRIMITIVES ||
        header->record_count > header->record_capacity ||
        header->node_count > header->node_capacity ||
        (header->record_count == 0) != (header->node_count == 0))
        return false;
    struct structure_header expected;
    structure_lay_out(&expected, header->kind, header->geometry_count, header->record_capacity,
                      header->node_capacity, header->micromap_count > 0);
    return header->micromap_count == expected.micromap_count && header->size == expected.size &&
           header->size <= size && header->geometries == expected.geometries &&
           header->records == expected.records && header->nodes == expected.nodes;
}

static bool place_is_well_formed(const struct structure_header *header, uint32_t geometry,
                                 uint32_t primitive)
{
    return geometry < header->geometry_count &&
           primitive < structure_geometries(header)[geometry].primitive_count;
}

/* Traversal does not rely on the contents of an instance. All other records store their numbers at
 * the same offset. Any `index` of a displaced part is valid. */
static bool record_is_well_formed(const struct structure_header *header, uint32_t index)
{
    const uint8_t *records = structure_records(header);
    const struct triangle_record *record =
        (const void *)(records + (uint64_t)index * structure_record_size(header->kind));
    if (structure_is_displaced(header->kind) &&
        structure_part(header->kind, record)->level > DISPLACEMENT_MAX_LEVEL)
        return false;
    return structure_is_top(header->kind) ||
           place_is_well_formed(header, record->geometry, record->primitive);
}

/* Walks the tree depth-first with the stack of a traversal. Rejects a tree that overflows the stack
 * or is deeper than any build. Each node and record must occur once and in order, so the walk
 * terminates and nothing is shared. */
static bool tree_is_well_formed(const struct structure_header *header)
{
    const struct wide_node *nodes = structure_nodes(header);
    struct {
        uint32_t index, depth;
    } stack[TRACE_STACK], now;
    uint32_t waiting = 0, seen_nodes = 0;
    uint64_t seen_records = 0;
    stack[0].index = stack[0].depth = 0;
    waiting = header->node_count > 0;
    while (waiting > 0) {
        now = stack[--waiting];
        if (now.index != seen_nodes++ || now.depth++ == TREE_DEPTH_LIMIT)
            return false;
        for (uint32_t lane = NODE_WIDTH; lane-- > 0;) {
            uint32_t child = nodes[now.index].child[lane];
            if (child == CHILD_EMPTY)
                continue;
            if (child & LEAF_BIT) {
                uint64_t end = (uint64_t)leaf_first(child) + leaf_count(child);
                if (end > header->record_count)
                    return false;
                seen_records += leaf_count(child);
            } else if (child >= header->node_count || child <= now.index ||
                       waiting == TRACE_STACK) {
                return false;
            } else {
                stack[waiting].index = child;
                stack[waiting++].depth = now.depth;
            }
        }
    }
    return seen_nodes == header->node_count && seen_records == header->record_count;
}

bool structure_is_well_formed(const struct structure_header *header, uint64_t size)
{
    if (!layout_is_well_formed(header, size))
        return false;
    for (uint32_t i = 0; i < header->record_count; i++)
        if (!record_is_well_formed(header, i))
            return false;
    return tree_is_well_formed(header);
}
