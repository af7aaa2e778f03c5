/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/digest.h"

#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/check/content/content.h"
#include "src/model/geometry_shape.h"
#include "src/model/inputs.h"

/* ---- the hash: each step is one of the hash before it, with a hash of the bytes. */

static void add_bytes(struct input_digest *digest, const void *bytes, uint64_t size)
{
    const XXH128_hash_t hash = XXH3_128bits(bytes, size);
    const uint64_t step[] = {digest->words[0], digest->words[1], hash.low64, hash.high64, size};
    const XXH128_hash_t next = XXH3_128bits(step, sizeof(step));
    digest->words[0] = next.low64;
    digest->words[1] = next.high64;
}

/* Adds the elements of an array. Returns false if they are not all known. */
static bool add_array(struct input_digest *digest, const struct content *content,
                      VkDeviceOrHostAddressConstKHR address, uint64_t offset, uint64_t count,
                      uint64_t stride, uint64_t size)
{
    if (!count)
        return true;
    const uint8_t *bytes = content_find(content, address, offset, count, stride, size);
    if (bytes)
        add_bytes(digest, bytes, (count - 1) * stride + size);
    return bytes;
}

/* ---- geometries */

/* Indices choose among the vertices up to that of the largest index. */
static bool add_input(struct input_digest *digest, const struct content *content,
                      const struct geometry_input *input)
{
    const struct content_indices *indices = &content->indices;
    if ((input->is_chosen && !indices->bytes) || !input->size || input->offset == UINT64_MAX)
        return false;
    return add_array(digest, content, input->address, input->offset,
                     input->is_chosen ? (uint64_t)indices->max + 1 : input->count, input->stride,
                     input->size);
}

static bool add_inputs(struct input_digest *digest, const struct content *content)
{
    const VkAccelerationStructureGeometryKHR *geometry = content->range->geometry->geometry;
    struct geometry_input inputs[GEOMETRY_INPUTS];
    if (!triangles_in(geometry) && !aabbs_in(geometry) &&
        (!instances_in(geometry) || has_instance_pointers(geometry)))
        return false;
    const uint32_t count = inputs_of_geometry(0, geometry, NULL, content->range->range, inputs);
    for (uint32_t i = 0; i < count; i++)
        if (!add_input(digest, content, &inputs[i]))
            return false;
    return true;
}

void digest_add(struct input_digesting *digesting, const struct content *content)
{
    const struct geometry_shape shape = geometry_shape_of(content->range->geometry->geometry,
                                                          &content->range->range->primitiveCount);
    add_bytes(&digesting->digest, &shape, sizeof(shape));
    digesting->geometries += add_inputs(&digesting->digest, content);
}

/* ---- builds */

void digest_begin(struct input_digesting *digesting, const struct build_parameters *given)
{
    const uint64_t parameters[] = {given->info.type, given->info.flags, given->info.mode,
                                   given->info.geometryCount};
    *digesting = (struct input_digesting){0};
    add_bytes(&digesting->digest, parameters, sizeof(parameters));
}

bool digest_end(struct input_digesting *digesting, const struct build_parameters *given,
                const struct execution_point *point)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = &given->info;
    const bool is_moved =
        build_is_update(info) && info->srcAccelerationStructure != info->dstAccelerationStructure;
    digesting->digest.is_top = info->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    digesting->digest.serial = point ? point->serial : 0;
    return digesting->geometries == info->geometryCount && !is_moved && !given->had_chains &&
           !(info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) &&
           (point || !digesting->digest.is_top);
}
