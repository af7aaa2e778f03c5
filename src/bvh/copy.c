/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of structures: clone, compact, serialize, deserialize. */
#include "src/bvh/structure.h"

#include <string.h>

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
