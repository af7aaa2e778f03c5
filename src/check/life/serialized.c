/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the header of serialized data: on the host, or copied by the device before it was read. The
 * chapter on acceleration structures of the specification has its layout, under
 * vkCmdCopyAccelerationStructureToMemoryKHR. */
#include "src/check/life/life.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"

/* The header of a serialized structure. That of a VkMicromapEXT has only `version`. */
struct header {
    uint8_t version[2 * VK_UUID_SIZE]; /* of the driver and of the format */
    uint64_t size, deserialized_size;
    uint64_t count; /* of references; of a bottom-level structure: 0, or BLOCKS and their number */
};

struct block {
    uint32_t type; /* VkAccelerationStructureSerializedBlockTypeKHR */
    uint32_t reserved;
    uint64_t address_count; /* as many addresses of 64 bits follow */
};

enum { HOST_ALIGNMENT = 16 };

#define BLOCKS ((uint64_t)UINT32_MAX << 32)

/* The data, up to where they are known. */
struct source {
    struct check_context *context;
    const char *bytes;
    uint64_t size;
};

static bool has(const struct source *source, const char *at, size_t size)
{
    const uint64_t begin = (uint64_t)(at - source->bytes);
    return begin <= source->size && size <= source->size - begin &&
           readable(source->context->readable, at, size);
}

static uint64_t sum_of(uint64_t size, uint64_t count, uint64_t item)
{
    uint64_t bytes, sum;
    bool overflows = __builtin_mul_overflow(count, item, &bytes);
    return overflows || __builtin_add_overflow(size, bytes, &sum) ? UINT64_MAX : sum;
}

/* Without memory, the micromap is not added. */
static void add_micromap(struct resources *resources, struct referenced_micromaps *micromaps,
                         uint64_t address)
{
    struct accel_facts facts;
    if (resources_find_micromap_at(resources, address, &facts) &&
        ARRAY_HAS_ROOM(micromaps->items, micromaps->count, micromaps->capacity))
        micromaps->items[micromaps->count++] =
            (struct micromap_shape){.handle = handle_number(facts.handle), .id = facts.id};
}

/* Looks for an address that is in no buffer. The implementation may write NULL for a geometry
 * without a micromap. */
static void check_addresses(const struct source *source, struct serialized_facts *data,
                            const char *addresses, uint64_t count)
{
    struct resources *resources = source->context->resources;
    for (uint64_t i = 0; i < count && !data->invalid_address; i++) {
        const char *at = addresses + i * sizeof(uint64_t);
        struct address_facts facts;
        uint64_t address;
        if (!has(source, at, sizeof(address)))
            return;
        memcpy(&address, at, sizeof(address));
        resources_look_up_address(resources, address, &facts);
        if (facts.status == ADDRESS_NOWHERE)
            data->invalid_address = address;
        else if (data->micromaps && address)
            add_micromap(resources, data->micromaps, address);
    }
}

static void view_block(const struct source *source, struct serialized_facts *data,
                       const struct block *block, const char *addresses)
{
    if (block->type != VK_ACCELERATION_STRUCTURE_SERIALIZED_BLOCK_TYPE_OPACITY_MICROMAP_KHR) {
        data->invalid_type = block->type;
        return;
    }
    data->has_micromaps = true;
    check_addresses(source, data, addresses, block->address_count);
}

/* Ends before a block that is not all within `data->size`: then the data are incomplete. */
static void view_blocks(const struct source *source, struct serialized_facts *data, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        struct block block;
        const char *at = source->bytes + data->header_size;
        data->header_size = sum_of(data->header_size, 1, sizeof(block));
        if (data->header_size > data->size || !has(source, at, sizeof(block)))
            return;
        memcpy(&block, at, sizeof(block));
        data->header_size = sum_of(data->header_size, block.address_count, sizeof(uint64_t));
        if (data->header_size > data->size)
            return;
        view_block(source, data, &block, at + sizeof(block));
    }
}

static void view_sizes(const struct source *source, struct serialized_facts *data)
{
    struct header header;
    if (!has(source, source->bytes, sizeof(header)))
        return;
    memcpy(&header, source->bytes, sizeof(header));
    data->has_sizes = true;
    data->size = header.size;
    data->deserialized_size = header.deserialized_size;
    data->header_size = sizeof(header);
    if (header.count < BLOCKS)
        data->header_size = sum_of(sizeof(header), header.count, sizeof(uint64_t));
    else if (data->compatible != NO)
        view_blocks(source, data, (uint32_t)header.count);
}

struct geometry_shapes *check_referenced_micromaps(struct check_context *context, const void *bytes)
{
    struct referenced_micromaps micromaps = {0};
    struct geometry_shapes *shapes = NULL;
    struct copy_view copy = {
        .is_on_host = true, .address = (uint64_t)(uintptr_t)bytes, .data.micromaps = &micromaps};
    check_view_serialized(context, &copy);
    const struct serialized_facts *data = &copy.data;
    if (micromaps.count && data->compatible == YES && data->header_size <= data->size &&
        !data->invalid_type && !data->invalid_address)
        shapes = built_with_micromaps(micromaps.count, micromaps.items);
    free(micromaps.items);
    return shapes;
}

static void view_source(const struct source *source, struct copy_view *copy)
{
    const struct check_context *context = source->context;
    const bool is_micromap = copy->dst.object_type == VK_OBJECT_TYPE_MICROMAP_EXT;
    uint8_t version[2 * VK_UUID_SIZE];
    if (!has(source, source->bytes, sizeof(version)))
        return;
    memcpy(version, source->bytes, sizeof(version));
    copy->data.compatible = context->hooks->is_compatible(context->user, is_micromap, version);
    if (!is_micromap)
        view_sizes(source, &copy->data);
}

void check_view_serialized(struct check_context *context, struct copy_view *copy)
{
    const struct source source = {context, (const char *)(uintptr_t)copy->address, UINT64_MAX};
    /* A misaligned address has a message of its own, and leads to no header. */
    if (context->level >= LEVEL_CONTENT && copy->is_on_host && copy->address % HOST_ALIGNMENT == 0)
        view_source(&source, copy);
}

void check_read_serialized(struct walk *walk, const struct call_view *call,
                           const struct deserialization *deserialization, const void *bytes,
                           uint64_t size)
{
    const struct source source = {walk->context, bytes, size};
    const struct location location = check_argument(call, "pInfo");
    struct copy_view copy = {
        .call = call,
        .direction = COPY_FROM_MEMORY,
        .address = deserialization->address,
        .dst = {.object_type = call->command == COMMAND_CmdCopyMemoryToMicromapEXT
                                   ? VK_OBJECT_TYPE_MICROMAP_EXT
                                   : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                .handle = deserialization->dst,
                .details_known = deserialization->dst_size != 0,
                .size = deserialization->dst_size}};
    view_source(&source, &copy);
    /* If nothing was destroyed, the buffer is the one that the device has read. */
    if (resources_destroy_count(walk->context->resources) == walk->context->destroy_count)
        resources_look_up_address(walk->context->resources, copy.address, &copy.memory);
    /* The other rules were evaluated when the call was recorded. */
    for (int rule = 0; rule < RULE_COUNT; rule++)
        if (rule_infos[rule].level != LEVEL_CONTENT)
            walk_stop_rule(walk, (enum rule)rule);
    walk_copy(walk, &copy, &location);
}
