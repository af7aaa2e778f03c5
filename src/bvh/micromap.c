/* SPDX-License-Identifier: Apache-2.0 */
/* Micromaps: blocks that hold the data of each triangle. */
#include "src/bvh/micromap.h"

#include <math.h>
#include <string.h>

#include "src/bvh/input/displacement.h"
#include "src/bvh/structure.h"

#define MICROMAP_MAGIC 0x4d4d5341u /* "ASMM" */

struct micromap_header {
    uint32_t magic, type;
    uint32_t triangle_count, spare;
    uint64_t size; /* size of the whole block */
};

/* The triangles follow the header; the data follows the triangles. */
struct micromap_triangle {
    uint64_t data; /* offset from the header */
    uint32_t level, format;
};

uint64_t micromap_triangle_bytes(uint32_t type, uint32_t format, uint32_t level)
{
    if (type == VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV)
        return displacement_bytes(format, level);
    if (type != VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT || level > MICROMAP_MAX_LEVEL ||
        (format != VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT &&
         format != VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT))
        return 0;
    uint64_t bits = (uint64_t)format << 2 * level; /* 1 or 2 bits per microtriangle */
    return (bits + 7) / 8;
}

static enum builder_result measure(const struct micromap_input *input, uint32_t *triangles,
                                   uint64_t *size)
{
    uint64_t count = 0, data = 0;
    for (uint32_t i = 0; i < input->usage_count; i++) {
        const VkMicromapUsageEXT *usage = &input->usages[i];
        uint64_t bytes =
            micromap_triangle_bytes(input->type, usage->format, usage->subdivisionLevel);
        if (bytes == 0)
            return BUILDER_UNKNOWN_FORMAT;
        count += usage->count;
        data += bytes * usage->count;
        if (count > BUILDER_MAX_PRIMITIVES) /* the data size stays below 2^29 times 2^25 */
            return BUILDER_TOO_MANY_PRIMITIVES;
    }
    *triangles = (uint32_t)count;
    *size = sizeof(struct micromap_header) + count * sizeof(struct micromap_triangle) + data;
    *size = (*size + BUILDER_ALIGNMENT - 1) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
    return BUILDER_OK;
}

enum builder_result micromap_get_size(const struct micromap_input *input, uint64_t *size)
{
    uint32_t triangles;
    *size = 0;
    return measure(input, &triangles, size);
}

uint64_t micromap_triangle_count(const struct micromap_input *input)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < input->usage_count; i++)
        count += input->usages[i].count;
    return count;
}

/* Reads element `index` of the input. Returns false if it is not readable or is invalid for the
 * type. */
static bool find_triangle(const struct micromap_input *input, uint64_t index,
                          VkMicromapTriangleEXT *triangle, uint64_t *bytes)
{
    uint64_t offset = input->stride * index;
    if (input->stride > UINT32_MAX || offset > input->triangles_size ||
        input->triangles_size - offset < sizeof(*triangle))
        return false;
    memcpy(triangle, (const uint8_t *)input->triangles + offset, sizeof(*triangle));
    *bytes = micromap_triangle_bytes(input->type, triangle->format, triangle->subdivisionLevel);
    return *bytes > 0;
}

uint64_t micromap_data_extent(const struct micromap_input *input)
{
    VkMicromapTriangleEXT triangle;
    uint64_t count = micromap_triangle_count(input), extent = 0, bytes;
    for (uint64_t i = 0; i < count && find_triangle(input, i, &triangle, &bytes); i++)
        if (extent < triangle.dataOffset + bytes)
            extent = triangle.dataOffset + bytes;
    return extent;
}

/* As find_triangle(); also returns false if the data of the triangle is not readable. */
static bool read_triangle(const struct micromap_input *input, uint32_t index,
                          VkMicromapTriangleEXT *triangle, uint64_t *bytes)
{
    return find_triangle(input, index, triangle, bytes) &&
           triangle->dataOffset <= input->data_size &&
           *bytes <= input->data_size - triangle->dataOffset;
}

enum builder_result micromap_build(const struct micromap_input *input, void *micromap,
                                   uint64_t size)
{
    struct micromap_header *header = micromap;
    struct micromap_triangle *triangles = (struct micromap_triangle *)(header + 1);
    uint32_t count;
    uint64_t whole;
    enum builder_result result = measure(input, &count, &whole);
    if (result != BUILDER_OK)
        return result;
    if (size < whole)
        return BUILDER_TOO_SMALL;
    *header = (struct micromap_header){MICROMAP_MAGIC, input->type, count, 0, whole};
    uint64_t used = sizeof(*header) + count * sizeof(*triangles);
    for (uint32_t i = 0; i < count; i++) {
        VkMicromapTriangleEXT triangle;
        uint64_t bytes;
        if (!read_triangle(input, i, &triangle, &bytes) || bytes > whole - used)
            return BUILDER_INPUT_OUT_OF_RANGE;
        triangles[i] = (struct micromap_triangle){used, triangle.subdivisionLevel, triangle.format};
        memcpy((uint8_t *)micromap + used, (const uint8_t *)input->data + triangle.dataOffset,
               bytes);
        used += bytes;
    }
    memset((uint8_t *)micromap + used, 0, whole - used);
    return BUILDER_OK;
}

bool micromap_is(const void *bytes)
{
    return ((const struct micromap_header *)bytes)->magic == MICROMAP_MAGIC;
}

uint64_t micromap_size(const void *micromap)
{
    return ((const struct micromap_header *)micromap)->size;
}

/* A micromap has no unused capacity. */
uint64_t micromap_compacted_size(const void *micromap)
{
    return micromap_size(micromap);
}

enum builder_result micromap_clone(const void *source, void *target, uint64_t target_size)
{
    uint64_t size = micromap_size(source);
    if (target_size < size)
        return BUILDER_TOO_SMALL;
    memmove(target, source, size);
    return BUILDER_OK;
}

enum builder_result micromap_compact(const void *source, void *target, uint64_t target_size)
{
    return micromap_clone(source, target, target_size);
}

uint64_t micromap_serialized_size(const void *micromap)
{
    return sizeof(struct serialized_header) + micromap_size(micromap);
}

enum builder_result micromap_serialize(const void *micromap, const struct builder_uuids *uuids,
                                       void *bytes, uint64_t size)
{
    struct serialized_header header = {.serialized_size = micromap_serialized_size(micromap),
                                       .deserialized_size = micromap_size(micromap)};
    if (size < header.serialized_size)
        return BUILDER_TOO_SMALL;
    memcpy(header.driver, uuids->driver, sizeof(header.driver));
    memcpy(header.compatibility, uuids->compatibility, sizeof(header.compatibility));
    memcpy(bytes, &header, sizeof(header));
    memcpy((uint8_t *)bytes + sizeof(header), micromap, header.deserialized_size);
    return BUILDER_OK;
}

static bool is_well_formed(const struct micromap_header *header, uint64_t size)
{
    const struct micromap_triangle *triangles = (const struct micromap_triangle *)(header + 1);
    uint64_t count = header->triangle_count;
    if (header->magic != MICROMAP_MAGIC || header->size > size || header->size < sizeof(*header) ||
        count * sizeof(*triangles) > header->size - sizeof(*header))
        return false;
    for (uint64_t i = 0; i < count; i++) {
        uint64_t bytes =
            micromap_triangle_bytes(header->type, triangles[i].format, triangles[i].level);
        if (bytes == 0 || triangles[i].data > header->size ||
            bytes > header->size - triangles[i].data)
            return false;
    }
    return true;
}

bool micromap_is_serialized(const void *bytes, uint64_t size)
{
    uint32_t magic;
    if (size < sizeof(struct serialized_header) + sizeof(struct micromap_header))
        return false;
    memcpy(&magic, (const uint8_t *)bytes + sizeof(struct serialized_header), sizeof(magic));
    return magic == MICROMAP_MAGIC;
}

enum builder_result micromap_deserialize(const void *bytes, uint64_t size,
                                         const struct builder_uuids *uuids, void *micromap,
                                         uint64_t micromap_size)
{
    struct builder_serialized serialized;
    struct micromap_header header;
    if (!micromap_is_serialized(bytes, size) || !builder_read_header(bytes, uuids, &serialized) ||
        serialized.reference_count != 0 || serialized.size > size ||
        serialized.structure_size < sizeof(header))
        return BUILDER_INCOMPATIBLE;
    if (micromap_size < serialized.structure_size)
        return BUILDER_TOO_SMALL;
    const uint8_t *from = (const uint8_t *)bytes + sizeof(struct serialized_header);
    memcpy(&header, from, sizeof(header));
    if (header.size != serialized.structure_size)
        return BUILDER_INCOMPATIBLE;
    memcpy(micromap, from, header.size);
    return is_well_formed(micromap, header.size) ? BUILDER_OK : BUILDER_INCOMPATIBLE;
}

/* A microtriangle by the barycentric weights of its center, in integer units whose sum is
 * `whole`. */
struct micro {
    uint32_t weight[3], whole;
};

/* Finds the microtriangle that contains a point: "clamping as needed to keep the sum" within the
 * triangle. */
static struct micro find_micro(float u, float v, uint32_t level)
{
    uint32_t count = 1u << level;
    float limit = (float)count;
    float x = fminf(fmaxf(u, 0), 1) * limit, y = fminf(fmaxf(v, 0), 1) * limit; /* exact */
    uint32_t column = (uint32_t)x, row = (uint32_t)y;
    bool is_beyond = x - (float)column + (y - (float)row) >= 1;
    column = column < count ? column : count - 1;
    row = row < count ? row : count - 1;
    bool is_flipped = is_beyond && column + row < count - 1;
    if (column + row >= count)
        column = count - 1 - row;
    struct micro micro = {.whole = 3 * count};
    micro.weight[1] = 3 * column + 1 + is_flipped;
    micro.weight[2] = 3 * row + 1 + is_flipped;
    micro.weight[0] = micro.whole - micro.weight[1] - micro.weight[2];
    return micro;
}

/* Descends one level at a time into the quarter that contains the center. The order of quarters:
 * nearest to vertex 0, the middle, nearest to vertex 1, nearest to vertex 2. The second and the
 * fourth quarter reverse the order of their contents. */
uint32_t micromap_curve_index(float u, float v, uint32_t level)
{
    struct micro micro = find_micro(u, v, level);
    uint32_t *weight = micro.weight, index = 0;
    for (uint32_t i = 0; i < level; i++) {
        const uint32_t quarters[3] = {0, 2, 3};
        uint32_t quarter = 1;
        for (int vertex = 0; vertex < 3; vertex++)
            if (2 * weight[vertex] > micro.whole)
                quarter = quarters[vertex];
        for (int vertex = 0; vertex < 3; vertex++) {
            if (quarter == 1) /* the vertices of the middle are the midpoints of the edges */
                weight[vertex] = micro.whole - 2 * weight[vertex];
            else
                weight[vertex] =
                    2 * weight[vertex] - (quarter == quarters[vertex] ? micro.whole : 0);
        }
        if (quarter % 2 == 1) {
            uint32_t first = weight[0];
            weight[0] = weight[1];
            weight[1] = first;
        }
        index = index << 2 | quarter;
    }
    return index;
}

enum micromap_state micromap_opacity(const void *micromap, uint32_t triangle, float u, float v)
{
    const struct micromap_header *header = micromap;
    const struct micromap_triangle *triangles = (const struct micromap_triangle *)(header + 1);
    if (header->type != VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT || triangle >= header->triangle_count)
        return MICROMAP_NONE;
    const struct micromap_triangle *found = &triangles[triangle];
    uint32_t bits = found->format == VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT ? 2 : 1;
    uint64_t place = (uint64_t)micromap_curve_index(u, v, found->level) * bits;
    uint8_t byte = ((const uint8_t *)micromap)[found->data + place / 8];
    return (enum micromap_state)(byte >> place % 8 & ((1u << bits) - 1));
}

const uint8_t *micromap_displacement(const void *micromap, uint64_t triangle, uint32_t *format,
                                     uint32_t *level)
{
    const struct micromap_header *header = micromap;
    const struct micromap_triangle *triangles = (const struct micromap_triangle *)(header + 1);
    if (header->type != VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV ||
        triangle >= header->triangle_count)
        return NULL;
    *format = triangles[triangle].format;
    *level = triangles[triangle].level;
    return (const uint8_t *)micromap + triangles[triangle].data;
}
