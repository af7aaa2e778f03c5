/* SPDX-License-Identifier: Apache-2.0 */
/* The layout of structures: validation of untrusted ones, and copies. */
#include "src/bvh/structure.h"

#include <string.h>

#include "src/bvh/input/displacement.h"

#define STRUCTURE_MAGIC 0x59535341u /* "ASSY" */
#define STRUCTURE_VERSION 2u
#define LEAF_RECORDS 4u

#define STRUCTURE_KINDS 10u

#define HAS_NUMBERS_OF_TRIANGLES(type)                                                             \
    _Static_assert(                                                                                \
        offsetof(struct type, geometry) == offsetof(struct triangle_record, geometry) &&           \
            offsetof(struct type, primitive) == offsetof(struct triangle_record, primitive),       \
        "layout")
HAS_NUMBERS_OF_TRIANGLES(aabb_record);
HAS_NUMBERS_OF_TRIANGLES(sphere_record);
HAS_NUMBERS_OF_TRIANGLES(swept_record);

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
 * TLAS has one instance, so n instances need n/7 to n/3 nodes. */
uint32_t structure_node_capacity(enum structure_kind kind, uint32_t records)
{
    uint64_t nodes = (uint64_t)records * 9 / 100;
    if (structure_record_size(kind) == sizeof(struct aabb_record))
        nodes = (uint64_t)records * 8 / 100;
    if (structure_is_top(kind))
        nodes = (uint64_t)records / 3;
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

/* ---- copies of structures: clone, compact, serialize, deserialize */

uint64_t builder_size(const void *structure)
{
    return ((const struct structure_header *)structure)->size;
}

static void lay_out_compacted(const struct structure_header *header,
                              struct structure_header *compacted)
{
    structure_lay_out(compacted, header->kind, header->geometry_count, header->record_count,
                      header->node_count, header->micromap_count > 0);
}

uint64_t builder_compacted_size(const void *structure)
{
    struct structure_header compacted;
    lay_out_compacted(structure, &compacted);
    return compacted.size;
}

enum builder_result builder_clone(const void *source, void *target, uint64_t target_size)
{
    uint64_t size = builder_size(source);
    if (target_size < size)
        return BUILDER_TOO_SMALL;
    memmove(target, source, size);
    return BUILDER_OK;
}

enum builder_result builder_compact(const void *source, void *target, uint64_t target_size)
{
    const struct structure_header *from = source;
    struct structure_header *to = target;
    if (target_size < builder_compacted_size(source))
        return BUILDER_TOO_SMALL;
    lay_out_compacted(from, to);
    to->flags = from->flags;
    to->record_count = from->record_count;
    to->node_count = from->node_count;
    memcpy(to->lower, from->lower, sizeof(to->lower));
    memcpy(to->upper, from->upper, sizeof(to->upper));
    uint64_t records = from->record_count * structure_record_size(from->kind);
    memset((uint8_t *)to + sizeof(*to), 0, to->size - sizeof(*to));
    memcpy(structure_geometries(to), structure_geometries(from),
           from->geometry_count * sizeof(struct structure_geometry));
    memcpy(structure_records(to), structure_records(from), records);
    memcpy(structure_nodes(to), structure_nodes(from), from->node_count * sizeof(struct wide_node));
    memcpy(structure_micromaps(to), structure_micromaps(from),
           from->micromap_count * sizeof(uint64_t));
    return BUILDER_OK;
}

uint64_t builder_reference_count(const void *structure)
{
    const struct structure_header *header = structure;
    return structure_is_top(header->kind) ? header->record_count : 0;
}

uint64_t builder_serialized_size(const void *structure)
{
    return sizeof(struct serialized_header) +
           builder_reference_count(structure) * sizeof(uint64_t) + builder_size(structure);
}

enum builder_result builder_serialize(const void *structure, const struct builder_uuids *uuids,
                                      void *bytes, uint64_t size)
{
    struct serialized_header header = {
        .serialized_size = builder_serialized_size(structure),
        .deserialized_size = builder_size(structure),
        .reference_count = builder_reference_count(structure),
    };
    if (size < header.serialized_size)
        return BUILDER_TOO_SMALL;
    memcpy(header.driver, uuids->driver, sizeof(header.driver));
    memcpy(header.compatibility, uuids->compatibility, sizeof(header.compatibility));
    memcpy(bytes, &header, sizeof(header));
    uint8_t *to = (uint8_t *)bytes + sizeof(header);
    for (uint64_t i = 0; i < header.reference_count; i++) {
        const struct instance_record *record = structure_instance(structure, i);
        memcpy(to, &record->instance.accelerationStructureReference, sizeof(uint64_t));
        to += sizeof(uint64_t);
    }
    memcpy(to, structure, header.deserialized_size);
    return BUILDER_OK;
}

bool builder_read_header(const void *bytes, const struct builder_uuids *uuids,
                         struct builder_serialized *serialized)
{
    struct serialized_header header;
    memcpy(&header, bytes, sizeof(header));
    uint64_t rest = header.serialized_size - sizeof(header);
    *serialized = (struct builder_serialized){header.serialized_size, header.deserialized_size,
                                              header.reference_count};
    return memcmp(header.driver, uuids->driver, VK_UUID_SIZE) == 0 &&
           memcmp(header.compatibility, uuids->compatibility, VK_UUID_SIZE) == 0 &&
           header.serialized_size >= sizeof(header) && header.deserialized_size <= rest &&
           header.reference_count == (rest - header.deserialized_size) / sizeof(uint64_t) &&
           (rest - header.deserialized_size) % sizeof(uint64_t) == 0;
}

enum builder_result builder_deserialize(const void *bytes, uint64_t size,
                                        const struct builder_uuids *uuids, void *structure,
                                        uint64_t structure_size)
{
    struct builder_serialized header;
    if (size < sizeof(struct serialized_header) || !builder_read_header(bytes, uuids, &header) ||
        header.size > size)
        return BUILDER_INCOMPATIBLE;
    if (structure_size < header.structure_size)
        return BUILDER_TOO_SMALL;
    const uint8_t *references = (const uint8_t *)bytes + sizeof(struct serialized_header);
    memcpy(structure, references + header.reference_count * sizeof(uint64_t),
           header.structure_size);
    if (!structure_is_well_formed(structure, header.structure_size) ||
        builder_size(structure) != header.structure_size ||
        builder_reference_count(structure) != header.reference_count)
        return BUILDER_INCOMPATIBLE;
    for (uint64_t i = 0; i < header.reference_count; i++) {
        struct instance_record *record = structure_instance(structure, i);
        memcpy(&record->instance.accelerationStructureReference, references + i * sizeof(uint64_t),
               sizeof(uint64_t));
    }
    return BUILDER_OK;
}
