/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the chains of geometries, and looks for host memory. */
#include "src/check/assemble/views.h"

#include <vulkan/vulkan.h>

static bool may_follow_geometry(const struct device_facts *device, VkStructureType type)
{
    switch ((int)type) {
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX:
        return device->extension.dense_geometry_format_amdx;
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_LINEAR_SWEPT_SPHERES_DATA_NV:
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV:
        return device->extension.linear_swept_spheres_nv;
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR:
        return device->extension.opacity_micromap_khr;
    default:
        return false;
    }
}

static bool may_follow_triangles(const struct device_facts *device, VkStructureType type)
{
    switch ((int)type) {
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV:
        return device->extension.motion_blur_nv;
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV:
        return device->extension.displacement_micromap_nv;
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT:
        return device->extension.opacity_micromap_ext;
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR:
        return device->extension.opacity_micromap_khr;
    default:
        return false;
    }
}

/* Returns whether one of the first `count` structures of a chain has a type. */
static bool comes_before(const VkBaseInStructure *chain, int count, VkStructureType type)
{
    for (; count; chain = chain->pNext, count--)
        if (chain->sType == type)
            return true;
    return false;
}

size_t chain_size_of(VkStructureType type)
{
    switch ((int)type) {
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX:
        return sizeof(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_LINEAR_SWEPT_SPHERES_DATA_NV:
        return sizeof(VkAccelerationStructureGeometryLinearSweptSpheresDataNV);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV:
        return sizeof(VkAccelerationStructureGeometrySpheresDataNV);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR:
        return sizeof(VkAccelerationStructureGeometryMicromapDataKHR);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV:
        return sizeof(VkAccelerationStructureGeometryMotionTrianglesDataNV);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV:
        return sizeof(VkAccelerationStructureTrianglesDisplacementMicromapNV);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT:
        return sizeof(VkAccelerationStructureTrianglesOpacityMicromapEXT);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR:
        return sizeof(VkAccelerationStructureTrianglesOpacityMicromapKHR);
    default:
        return sizeof(VkBaseInStructure);
    }
}

static bool chain_link_is_readable(struct check_context *context,
                                   const VkBaseInStructure *structure)
{
    return readable(context->readable, structure, sizeof(*structure)) &&
           readable(context->readable, structure, chain_size_of(structure->sType));
}

void chain_view(struct check_context *context, const struct device_facts *device,
                enum chain_owner owner, const void *chain, struct chain_facts *facts)
{
    const VkBaseInStructure *s = chain;
    for (int i = 0; s && i < CHAIN_MAX; s = s->pNext, i++) {
        if (!chain_link_is_readable(context, s)) {
            facts->unreadable = s;
            return;
        }
        bool may_follow = owner == CHAIN_OF_GEOMETRY ? may_follow_geometry(device, s->sType)
                                                     : may_follow_triangles(device, s->sType);
        if (!facts->has_stray && !may_follow) {
            facts->has_stray = true;
            facts->stray = s->sType;
        }
        if (!facts->has_duplicate && comes_before(chain, i, s->sType)) {
            facts->has_duplicate = true;
            facts->duplicate = s->sType;
        }
    }
}

/* ---- usages of micromaps */

static bool are_readable_pointers(struct readable_cache *cache, const void *const *pointers,
                                  uint32_t count)
{
    if (!readable(cache, pointers, count * sizeof(*pointers)))
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (!readable(cache, pointers[i], sizeof(VkMicromapUsageEXT)))
            return false;
    return true;
}

void chain_view_usages(struct readable_cache *cache, uint32_t count, const void *array,
                       const void *const *pointers, struct micromap_usages *usages)
{
    usages->both_given = array && pointers;
    if (!count)
        return;
    usages->array_unreadable = array && !readable(cache, array, count * sizeof(VkMicromapUsageEXT));
    usages->pointers_unreadable = pointers && !are_readable_pointers(cache, pointers, count);
    if (!array == !pointers || usages->array_unreadable || usages->pointers_unreadable)
        return;
    usages->array = array;
    usages->pointers = pointers;
    usages->count = count;
}

static bool are_readable(struct readable_cache *cache, uint32_t count, const void *array,
                         const void *pointers)
{
    struct micromap_usages usages = {0};
    chain_view_usages(cache, count, array, pointers, &usages);
    return usages.count == count;
}

/* Returns whether the usage counts of a readable structure are readable: drivers read them for the
 * sizes of a build. */
static bool usages_are_readable(struct check_context *context, const VkBaseInStructure *structure)
{
    const VkAccelerationStructureGeometryMicromapDataKHR *data = (const void *)structure;
    const VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity = (const void *)structure;
    const VkAccelerationStructureTrianglesDisplacementMicromapNV *displacement =
        (const void *)structure;
    switch ((int)structure->sType) {
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR:
        return are_readable(context->readable, data->usageCountsCount, data->pUsageCounts,
                            data->ppUsageCounts);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT:
        return are_readable(context->readable, opacity->usageCountsCount, opacity->pUsageCounts,
                            opacity->ppUsageCounts);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV:
        return are_readable(context->readable, displacement->usageCountsCount,
                            displacement->pUsageCounts, displacement->ppUsageCounts);
    default:
        return true;
    }
}

bool chain_links_are_readable(struct check_context *context, const void *chain)
{
    const VkBaseInStructure *s = chain;
    for (int i = 0; s && i < CHAIN_MAX; s = s->pNext, i++)
        if (!chain_link_is_readable(context, s) || !usages_are_readable(context, s))
            return false;
    return !s;
}

const void *chain_member(const void *chain, const struct chain_facts *facts, VkStructureType type)
{
    const VkBaseInStructure *s = chain;
    if (facts->unreadable || facts->has_duplicate)
        return NULL;
    for (int i = 0; s && i < CHAIN_MAX; s = s->pNext, i++)
        if (s->sType == type)
            return s;
    return NULL;
}

/* ---- host memory, also in mappings of device memory */

struct search {
    struct readable_cache *cache;
    uint64_t at; /* the address of the next piece */
    bool is_there;
};

static void visit_piece(void *user, const struct memory_span *piece)
{
    struct search *search = user;
    const uint64_t size = piece->end - piece->begin;
    search->is_there &= piece->memory != memory_of_host() ||
                        readable(search->cache, (const void *)(uintptr_t)search->at, size);
    search->at += size;
}

bool host_memory_is_there(struct check_context *context, const void *address, uint64_t size)
{
    if (readable(context->readable, address, size))
        return true;
    struct search search = {context->readable, (uint64_t)(uintptr_t)address, true};
    resources_find_host_pieces(context->resources, address, size, visit_piece, &search);
    return search.is_there;
}

struct host_bytes host_memory_bytes(struct check_context *context, const void *address,
                                    uint64_t offset, uint64_t count, uint64_t stride, uint64_t size)
{
    struct host_bytes bytes = {.address = address};
    uint64_t base = (uint64_t)(uintptr_t)address;
    bool wraps = __builtin_add_overflow(base, offset, &bytes.begin);
    if (!address || !count)
        return bytes;
    wraps |= __builtin_mul_overflow(count - 1, stride, &bytes.size);
    wraps |= __builtin_add_overflow(bytes.size, size, &bytes.size);
    bytes.unreadable =
        wraps || !host_memory_is_there(context, (const void *)(uintptr_t)bytes.begin, bytes.size);
    return bytes;
}
