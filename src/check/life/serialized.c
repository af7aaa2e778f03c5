/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the header of serialized data on the host. The chapter on acceleration structures of the
 * specification has its layout, under vkCmdCopyAccelerationStructureToMemoryKHR. */
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
            (struct micromap_shape){.handle = (uint64_t)(uintptr_t)facts.handle, .id = facts.id};
}

/* Looks for an address that is in no buffer. The implementation may write NULL for a geometry
 * without a micromap. */
static void check_addresses(struct check_context *context, struct serialized_facts *data,
                            const char *addresses, uint64_t count)
{
    for (uint64_t i = 0; i < count && !data->invalid_address; i++) {
        const char *at = addresses + i * sizeof(uint64_t);
        struct address_facts facts;
        uint64_t address;
        if (!readable(context->readable, at, sizeof(address)))
            return;
        memcpy(&address, at, sizeof(address));
        resources_look_up_address(context->resources, address, &facts);
        if (facts.status == ADDRESS_NOWHERE)
            data->invalid_address = address;
        else if (data->micromaps && address)
            add_micromap(context->resources, data->micromaps, address);
    }
}

static void view_block(struct check_context *context, struct serialized_facts *data,
                       const struct block *block, const char *addresses)
{
    if (block->type != VK_ACCELERATION_STRUCTURE_SERIALIZED_BLOCK_TYPE_OPACITY_MICROMAP_KHR) {
        data->invalid_type = block->type;
        return;
    }
    data->has_micromaps = true;
    check_addresses(context, data, addresses, block->address_count);
}

/* Ends before a block that is not all within `data->size`: then the data are incomplete. */
static void view_blocks(struct check_context *context, struct serialized_facts *data,
                        const char *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        struct block block;
        const char *at = bytes + data->header_size;
        data->header_size = sum_of(data->header_size, 1, sizeof(block));
        if (data->header_size > data->size || !readable(context->readable, at, sizeof(block)))
            return;
        memcpy(&block, at, sizeof(block));
        data->header_size = sum_of(data->header_size, block.address_count, sizeof(uint64_t));
        if (data->header_size > data->size)
            return;
        view_block(context, data, &block, at + sizeof(block));
    }
}

static void view_sizes(struct check_context *context, struct serialized_facts *data,
                       const char *bytes)
{
    struct header header;
    if (!readable(context->readable, bytes, sizeof(header)))
        return;
    memcpy(&header, bytes, sizeof(header));
    data->has_sizes = true;
    data->size = header.size;
    data->deserialized_size = header.deserialized_size;
    data->header_size = sizeof(header);
    if (header.count < BLOCKS)
        data->header_size = sum_of(sizeof(header), header.count, sizeof(uint64_t));
    else if (data->compatible != NO)
        view_blocks(context, data, bytes, (uint32_t)header.count);
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

void check_view_serialized(struct check_context *context, struct copy_view *copy)
{
    const bool is_micromap = copy->dst.object_type == VK_OBJECT_TYPE_MICROMAP_EXT;
    const char *bytes = (const char *)(uintptr_t)copy->address;
    uint8_t version[2 * VK_UUID_SIZE];
    /* A misaligned address has a message of its own, and leads to no header. */
    if (context->level < LEVEL_CONTENT || !copy->is_on_host || copy->address % HOST_ALIGNMENT ||
        !readable(context->readable, bytes, sizeof(version)))
        return;
    memcpy(version, bytes, sizeof(version));
    copy->data.compatible = context->hooks->is_compatible(context->user, is_micromap, version);
    if (!is_micromap)
        view_sizes(context, &copy->data, bytes);
}
