/* SPDX-License-Identifier: Apache-2.0 */
/* Copies misaligned parameters. Nearly all parameters are aligned. */
#include "src/check/assemble/views.h"

#include <string.h>

#include <vulkan/vulkan.h>

#include "src/model/geometry.h"

typedef VkAccelerationStructureGeometryKHR geometry_data;

/* ---- the call */

static bool align_readable(struct check_context *context, const void **array, bool is_readable,
                           size_t size, size_t alignment)
{
    if (is_readable)
        *array = align_array(context, *array, size, alignment);
    return !is_readable || *array || !size;
}

bool align_call(struct check_context *context, struct call_view *call)
{
    size_t count = call->info_count;
#define ALIGN(member)                                                                              \
    align_readable(context, (const void **)&call->member, call->member##_readable,                 \
                   count * sizeof(*call->member), _Alignof(__typeof__(*call->member)))
    return ALIGN(infos) && ALIGN(build_ranges) && ALIGN(max_primitive_counts) &&
           ALIGN(indirect_addresses) && ALIGN(indirect_strides);
#undef ALIGN
}

/* ---- chains */

static VkBaseInStructure read_base(const void *structure)
{
    VkBaseInStructure base;
    memcpy(&base, structure, sizeof(base));
    return base;
}

/* The offsets of the members that lead to the usage counts of a structure. find_usage_members()
 * returns false if the structure has none. */
struct usage_members {
    size_t count, array, pointers;
};

static bool find_usage_members(VkStructureType type, struct usage_members *members)
{
#define MEMBERS(structure)                                                                         \
    *members = (struct usage_members){offsetof(structure, usageCountsCount),                       \
                                      offsetof(structure, pUsageCounts),                           \
                                      offsetof(structure, ppUsageCounts)};                         \
    return true
    switch ((int)type) {
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR:
        MEMBERS(VkAccelerationStructureGeometryMicromapDataKHR);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT:
        MEMBERS(VkAccelerationStructureTrianglesOpacityMicromapEXT);
    case VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV:
        MEMBERS(VkAccelerationStructureTrianglesDisplacementMicromapNV);
    default:
        return false;
    }
#undef MEMBERS
}

static const void *pointer_at(const void *pointers, size_t i)
{
    const void *pointer;
    memcpy(&pointer, (const char *)pointers + i * sizeof(pointer), sizeof(pointer));
    return pointer;
}

static bool pointers_are_aligned(struct check_context *context, const void *pointers, size_t count,
                                 size_t alignment)
{
    if (!pointers || !readable(context->readable, pointers, count * sizeof(void *)))
        return true;
    bool all_aligned = is_aligned(pointers, _Alignof(void *));
    for (size_t i = 0; i < count && all_aligned; i++)
        all_aligned = is_aligned(pointer_at(pointers, i), alignment);
    return all_aligned;
}

static bool usages_are_aligned(struct check_context *context, const char *structure,
                               VkStructureType type)
{
    const size_t alignment = _Alignof(VkMicromapUsageEXT);
    struct usage_members members;
    uint32_t count;
    if (!find_usage_members(type, &members))
        return true;
    memcpy(&count, structure + members.count, sizeof(count));
    return is_aligned(pointer_at(structure + members.array, 0), alignment) &&
           pointers_are_aligned(context, pointer_at(structure + members.pointers, 0), count,
                                alignment);
}

static bool chain_is_aligned(struct check_context *context, const void *chain)
{
    for (int i = 0; chain && i < CHAIN_MAX; i++) {
        if (!readable(context->readable, chain, sizeof(VkBaseInStructure)))
            return true;
        VkBaseInStructure base = read_base(chain);
        if (!is_aligned(chain, _Alignof(VkBaseInStructure)))
            return false;
        if (readable(context->readable, chain, chain_size_of(base.sType)) &&
            !usages_are_aligned(context, chain, base.sType))
            return false;
        chain = base.pNext;
    }
    return true;
}

/* Aligns an array of pointers and the elements it points to. Leaves unreadable elements as they
 * are. Returns NULL if there is no memory. */
static const void *align_pointers(struct check_context *context, const void *pointers,
                                  uint32_t count, size_t size, size_t alignment)
{
    if (pointers_are_aligned(context, pointers, count, alignment))
        return pointers;
    const void **copy = aligned_copies_take(context->copies, pointers, count * sizeof(void *));
    for (uint32_t i = 0; copy && i < count; i++) {
        if (!readable(context->readable, copy[i], size))
            continue;
        copy[i] = align_array(context, copy[i], size, alignment);
        if (!copy[i])
            return NULL;
    }
    return copy;
}

/* Aligns the usage counts of `structure`, which is a copy. */
static bool align_usages(struct check_context *context, char *structure, VkStructureType type)
{
    const size_t size = sizeof(VkMicromapUsageEXT), alignment = _Alignof(VkMicromapUsageEXT);
    struct usage_members members;
    if (!find_usage_members(type, &members))
        return true;
    uint32_t count = *(uint32_t *)(void *)(structure + members.count);
    const void **array = (void *)(structure + members.array);
    const void **pointers = (void *)(structure + members.pointers);
    if (count && *array && readable(context->readable, *array, count * size) &&
        !(*array = align_array(context, *array, count * size, alignment)))
        return false;
    return !count || !*pointers ||
           (*pointers = align_pointers(context, *pointers, count, size, alignment));
}

/* Copies a chain up to its first unreadable structure. Copies only sType and pNext of a structure
 * of unknown type. */
static bool copy_chain(struct check_context *context, const void **chain)
{
    for (int i = 0; *chain && i < CHAIN_MAX; i++) {
        if (!readable(context->readable, *chain, sizeof(VkBaseInStructure)))
            return true;
        VkStructureType type = read_base(*chain).sType;
        size_t size = chain_size_of(type);
        if (!readable(context->readable, *chain, size))
            return true;
        char *copy = aligned_copies_take(context->copies, *chain, size);
        if (!copy || !align_usages(context, copy, type))
            return false;
        *chain = copy;
        chain = (const void **)(void *)(copy + offsetof(VkBaseInStructure, pNext));
    }
    return true;
}

/* ---- builds */

static bool chains_are_aligned(struct check_context *context, const geometry_data *geometry)
{
    bool has_data = triangles_in(geometry) || aabbs_in(geometry) || instances_in(geometry);
    return chain_is_aligned(context, geometry->pNext) &&
           (!has_data || chain_is_aligned(context, geometry->geometry.triangles.pNext));
}

bool build_is_misaligned(struct check_context *context, const struct build_view *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    bool aligned = is_aligned(info->pGeometries, _Alignof(geometry_data)) &&
                   pointers_are_aligned(context, info->ppGeometries, info->geometryCount,
                                        _Alignof(geometry_data)) &&
                   chain_is_aligned(context, info->pNext);
    for (uint32_t i = 0; i < build->geometry_count && aligned; i++)
        aligned = chains_are_aligned(context, build_geometry(info, i));
    return !aligned;
}

/* Returns the chain of the union member that geometryType selects, or NULL if there is none. */
static const void **data_chain(geometry_data *geometry)
{
    if (!triangles_in(geometry) && !aabbs_in(geometry) && !instances_in(geometry))
        return NULL;
    return &geometry->geometry.triangles.pNext; /* all members begin with sType and pNext */
}

static bool copy_chains(struct check_context *context, geometry_data *geometry)
{
    const void **chain = data_chain(geometry);
    return copy_chain(context, &geometry->pNext) && (!chain || copy_chain(context, chain));
}

/* Copies all readable geometries of a build with their chains. */
static bool copy_geometries(struct check_context *context,
                            VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    size_t count = info->geometryCount, size = count * sizeof(geometry_data);
    if (info->pGeometries && readable(context->readable, info->pGeometries, size)) {
        geometry_data *copy = aligned_copies_take(context->copies, info->pGeometries, size);
        info->pGeometries = copy;
        for (size_t i = 0; copy && i < count; i++)
            if (!copy_chains(context, &copy[i]))
                return false;
        return copy;
    }
    size = count * sizeof(void *);
    if (!info->ppGeometries || !readable(context->readable, info->ppGeometries, size))
        return true;
    const geometry_data **pointers =
        aligned_copies_take(context->copies, (const void *)info->ppGeometries, size);
    info->ppGeometries = pointers;
    for (size_t i = 0; pointers && i < count; i++) {
        if (!readable(context->readable, pointers[i], sizeof(*pointers[i])))
            continue;
        geometry_data *copy =
            aligned_copies_take(context->copies, pointers[i], sizeof(*pointers[i]));
        pointers[i] = copy;
        if (!copy || !copy_chains(context, copy))
            return false;
    }
    return pointers;
}

bool align_build(struct check_context *context, struct build_view *build)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info =
        aligned_copies_take(context->copies, build->info, sizeof(*info));
    if (!info || !copy_chain(context, &info->pNext) || !copy_geometries(context, info))
        return false;
    build->info = info;
    return true;
}

/* ---- VK_NV_ray_tracing */

bool align_nv_call(struct check_context *context, struct nv_call_view *call)
{
    const VkAccelerationStructureInfoNV *given = call->info_argument;
    VkAccelerationStructureInfoNV info;
    if (!readable(context->readable, given, sizeof(*given)))
        return true;
    memcpy(&info, given, sizeof(info));
    size_t size = info.geometryCount * sizeof(*info.pGeometries);
    bool geometries_aligned = is_aligned(info.pGeometries, _Alignof(VkGeometryNV)) ||
                              !readable(context->readable, info.pGeometries, size);
    if (is_aligned(given, _Alignof(VkAccelerationStructureInfoNV)) && geometries_aligned)
        return true;
    if (!geometries_aligned &&
        !(info.pGeometries = aligned_copies_take(context->copies, info.pGeometries, size)))
        return false;
    call->info_argument = aligned_copies_take(context->copies, &info, sizeof(info));
    return call->info_argument;
}
