/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of calls, builds and geometries. */
#include "src/check/assemble/views.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/clear.h"
#include "src/base/recording_path.h"
#include "src/check/assemble/extended.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/state/builds/size_cache.h"

enum { INLINE_COUNTS = 16 };

void view_call(struct check_context *context, struct call_view *call)
{
    struct readable_cache *cache = context->readable;
    size_t count = call->info_count;
    call->infos_readable = readable(cache, call->infos, count * sizeof(*call->infos));
    call->build_ranges_readable =
        call->command != COMMAND_INDIRECT &&
        readable(cache, call->build_ranges, count * sizeof(*call->build_ranges));
    call->max_primitive_counts_readable =
        call->command == COMMAND_INDIRECT &&
        readable(cache, call->max_primitive_counts, count * sizeof(*call->max_primitive_counts));
    call->indirect_addresses_readable =
        call->command == COMMAND_INDIRECT &&
        readable(cache, call->indirect_addresses, count * sizeof(*call->indirect_addresses));
    call->indirect_strides_readable =
        call->command == COMMAND_INDIRECT &&
        readable(cache, call->indirect_strides, count * sizeof(*call->indirect_strides));
}

/* ---- parameters */

static bool pointers_are_readable(struct readable_cache *cache,
                                  const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    if (!readable(cache, info->ppGeometries,
                  (size_t)info->geometryCount * sizeof(*info->ppGeometries)))
        return false;
    for (uint32_t i = 0; i < info->geometryCount; i++) {
        const VkAccelerationStructureGeometryKHR *geometry;
        memcpy(&geometry, &info->ppGeometries[i], sizeof(geometry)); /* the application's array may
                                                                      * be misaligned */
        if (!readable(cache, geometry, sizeof(*geometry)))
            return false;
    }
    return true;
}

__attribute__((always_inline)) static inline void
view_geometry_arrays(struct check_context *context, struct build_view *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    struct readable_cache *cache = context->readable;
    if (!info->geometryCount)
        return;
    bool unreadable =
        info->pGeometries && !readable(cache, info->pGeometries,
                                       (size_t)info->geometryCount * sizeof(*info->pGeometries));
    bool pointers_unreadable = info->ppGeometries && !pointers_are_readable(cache, info);
    build->geometries_unreadable = unreadable;
    build->geometry_pointers_unreadable = pointers_unreadable;
    if (!info->pGeometries == !info->ppGeometries || unreadable || pointers_unreadable)
        return;
    build->geometries = info->pGeometries;
    build->geometry_pointers = info->ppGeometries;
    build->geometry_count = info->geometryCount;
}

/* Returns whether the array of geometries is all that a build reads, and is aligned. Nearly all
 * builds are so. */
static inline bool is_trivially_aligned(const struct build_view *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    if (info->ppGeometries || info->pNext || !is_aligned(info->pGeometries, _Alignof(void *)))
        return false;
    for (uint32_t i = 0; i < build->geometry_count; i++)
        if (info->pGeometries[i].pNext || info->pGeometries[i].geometry.triangles.pNext)
            return false;
    return true;
}

__attribute__((noinline, cold)) static void view_misaligned(struct check_context *context,
                                                            struct build_view *build)
{
    if (!build_is_misaligned(context, build))
        return;
    bool has_memory = align_build(context, build);
    build->geometry_count = 0;
    build->geometries = NULL;
    build->geometry_pointers = NULL;
    if (has_memory)
        view_geometry_arrays(context, build);
}

__attribute__((always_inline)) static inline void view_counts(struct check_context *context,
                                                              struct build_view *build)
{
    const struct call_view *call = build->call;
    size_t count = build->info->geometryCount;
    if (!count)
        return;
    if (call->build_ranges_readable) {
        const VkAccelerationStructureBuildRangeInfoKHR *ranges = call->build_ranges[build->index];
        build->build_ranges_unreadable =
            !readable(context->readable, ranges, count * sizeof(*ranges));
        build->ranges =
            build->build_ranges_unreadable
                ? NULL
                : align_array(context, ranges, count * sizeof(*ranges), _Alignof(uint32_t));
    }
    if (call->max_primitive_counts_readable) {
        const uint32_t *counts = call->max_primitive_counts[build->index];
        build->max_primitive_counts =
            readable(context->readable, counts, count * sizeof(*counts))
                ? align_array(context, counts, count * sizeof(*counts), _Alignof(uint32_t))
                : NULL;
    }
}

bool view_primitive_count(const struct build_view *build, uint32_t geometry, uint32_t *count)
{
    if (build->ranges)
        *count = build->ranges[geometry].primitiveCount;
    else if (build->max_primitive_counts)
        *count = build->max_primitive_counts[geometry];
    else
        return false;
    return true;
}

/* For builds without build ranges, whose counts are in the structures of their types. The host's
 * command requires a pointer to build ranges even so:
 * vkBuildAccelerationStructuresKHR-pInfos-11702. */
static void clear_counts(struct build_view *build)
{
    if (build->call->command != COMMAND_HOST)
        build->build_ranges_unreadable = false;
    build->ranges = NULL;
    build->max_primitive_counts = NULL;
    build->triangle_count = build->aabb_count = 0;
}

/* Adds the primitives of a geometry. Returns whether the geometry takes a build range. The
 * indirect command's maximum counts only bound the counts. */
static inline bool sum_geometry(struct build_view *build, uint32_t index, VkGeometryTypeKHR type)
{
    uint32_t count = build->ranges ? build->ranges[index].primitiveCount : 0;
    if (type_is_triangles(type))
        build->triangle_count += count;
    else if (type_is_aabbs(type))
        build->aabb_count += count;
    else
        return type_takes_range(type);
    return true;
}

/* Adds the primitives of all geometries after the first. Returns whether all of them take build
 * ranges. */
__attribute__((noinline)) static bool sum_other_geometries(struct build_view *build,
                                                           VkGeometryTypeKHR first_type)
{
    bool take_ranges = true;
    for (uint32_t i = 1; i < build->geometry_count; i++) {
        VkGeometryTypeKHR type = build_geometry(build->info, i)->geometryType;
        take_ranges &= sum_geometry(build, i, type);
        if (type != first_type && build->first_other_type == build->geometry_count)
            build->first_other_type = i;
    }
    return take_ranges;
}

__attribute__((always_inline)) static inline void sum_primitives(struct build_view *build)
{
    bool takes_ranges = build->info->type != VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    build->first_other_type = build->geometry_count;
    if (build->geometry_count) {
        VkGeometryTypeKHR type = build_geometry(build->info, 0)->geometryType;
        takes_ranges &= sum_geometry(build, 0, type);
        if (build->geometry_count > 1)
            takes_ranges &= sum_other_geometries(build, type);
    }
    if (!takes_ranges)
        clear_counts(build);
}

_Static_assert(offsetof(struct build_view, dst) % 8 == 0, "clear_words() takes whole words");
_Static_assert(offsetof(struct geometry_view, vertex) % 8 == 0, "clear_words() takes whole words");

/* Facts are the largest part of a view and are overwritten later, so this only marks them
 * unknown. */
static void start_build(struct build_view *build)
{
    clear_words(build, offsetof(struct build_view, dst));
    build->scratch.status = ADDRESS_UNKNOWN;
    build->sizes.known = false;
}

static void start_geometry(struct geometry_view *geometry)
{
    clear_words(geometry, offsetof(struct geometry_view, vertex));
    geometry->vertex.status = geometry->index_data.status = ADDRESS_UNKNOWN;
    geometry->transform.status = geometry->data.status = ADDRESS_UNKNOWN;
    geometry->vertex_format_supported = UNKNOWN;
}

__attribute__((always_inline)) static inline void fill_build_view(struct check_context *context,
                                                                  const struct call_view *call,
                                                                  uint32_t index,
                                                                  struct build_view *build)
{
    start_build(build);
    build->call = call;
    build->index = index;
    build->info = &call->infos[index];
    view_geometry_arrays(context, build);
    if (!is_trivially_aligned(build))
        view_misaligned(context, build);
    view_counts(context, build);
    sum_primitives(build);
}

void view_build(struct check_context *context, const struct call_view *call, uint32_t index,
                struct build_view *build)
{
    fill_build_view(context, call, index, build);
}

__attribute__((noinline)) void view_sized_build(struct check_context *context,
                                                const struct call_view *call,
                                                struct build_view *build)
{
    fill_build_view(context, call, 0, build);
    for (uint32_t i = 0; build->max_primitive_counts && i < build->geometry_count; i++) {
        const VkGeometryTypeKHR type = build_geometry(build->info, i)->geometryType;
        const uint32_t count = build->max_primitive_counts[i];
        build->triangle_count += type_is_triangles(type) ? count : 0;
        build->aabb_count += type_is_aabbs(type) ? count : 0;
    }
}

__attribute__((noinline)) static void view_chains(struct check_context *context,
                                                  struct geometry_view *geometry, const void *chain,
                                                  const void *triangles_chain)
{
    const struct device_facts *device = geometry->build->call->device;
    if (chain)
        chain_view(context, device, CHAIN_OF_GEOMETRY, chain, &geometry->chain);
    if (triangles_chain)
        chain_view(context, device, CHAIN_OF_TRIANGLES, triangles_chain,
                   &geometry->triangles_chain);
}

ON_RECORDING_PATH void view_geometry(struct check_context *context, const struct build_view *build,
                                     uint32_t index, struct geometry_view *geometry)
{
    const VkAccelerationStructureGeometryKHR *given = build_geometry(build->info, index);
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(given);
    const void *triangles_chain = triangles ? triangles->pNext : NULL;
    start_geometry(geometry);
    geometry->build = build;
    geometry->index = index;
    geometry->geometry = given;
    if (given->pNext || triangles_chain)
        view_chains(context, geometry, given->pNext, triangles_chain);
}

/* ---- state */

static bool
triangles_are_well_formed(struct check_context *context,
                          const VkAccelerationStructureGeometryTrianglesDataKHR *triangles)
{
    return chain_is_readable(context, triangles->pNext) &&
           format_is_known(triangles->vertexFormat) &&
           (index_type_size(triangles->indexType) ||
            triangles->indexType == VK_INDEX_TYPE_NONE_KHR);
}

static bool geometry_is_well_formed(struct check_context *context, const struct build_view *build,
                                    uint32_t index)
{
    const VkAccelerationStructureGeometryKHR *geometry = build_geometry(build->info, index);
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(geometry);
    uint32_t count;
    if (!chain_is_readable(context, geometry->pNext))
        return false;
    if (triangles)
        return triangles_are_well_formed(context, triangles);
    if (instances_in(geometry))
        return !view_primitive_count(build, index, &count) ||
               count <= build->call->device->limits.maxInstanceCount;
    return aabbs_in(geometry) || extended_geometry_is_well_formed(geometry);
}

static bool is_within_limits(const struct build_view *build)
{
    const VkPhysicalDeviceAccelerationStructurePropertiesKHR *limits = &build->call->device->limits;
    return build->info->geometryCount <= limits->maxGeometryCount &&
           build->aabb_count <= limits->maxPrimitiveCount &&
           build->triangle_count <= limits->maxPrimitiveCount;
}

/* Returns whether the rules about parameters report everything that structures_are_well_formed()
 * checks: true if no structures may be chained, and the registry knows everything that is
 * enabled. */
static bool rules_report_all(const struct device_facts *device)
{
    return !device->extension.adds_to_inputs && !device->newer_than_registry;
}

__attribute__((noinline)) static bool structures_are_well_formed(struct check_context *context,
                                                                 const struct build_view *build)
{
    VkAccelerationStructureTypeKHR type = build->info->type;
    VkBuildAccelerationStructureModeKHR mode = build->info->mode;
    /* The mode decides which of the sizes a build needs. */
    if (mode != VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR &&
        mode != VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR)
        return false;
    if ((type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR &&
         type != VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR &&
         !is_micromap_build_for_device(build)) ||
        !chain_is_readable(context, build->info->pNext))
        return false;
    for (uint32_t i = 0; i < build->geometry_count; i++)
        if (!geometry_is_well_formed(context, build, i))
            return false;
    return true;
}

/* Returns whether a driver's size query is safe for a build, even if the rules that would report
 * the build are muted. */
static bool is_well_formed(struct check_context *context, const struct build_view *build,
                           bool holds)
{
    return is_within_limits(build) && ((holds && rules_report_all(build->call->device)) ||
                                       structures_are_well_formed(context, build));
}

static bool needs_no_count(const struct build_view *build, uint32_t *count)
{
    *count = 0;
    return is_micromap_build_for_device(build);
}

static VkAccelerationStructureBuildTypeKHR build_type_of(const struct build_view *build)
{
    return build->call->command == COMMAND_HOST ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                                                : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR;
}

/* A call explains one size: that of the last build with a size that is too small. If a build has
 * two such sizes, it explains that of dst. */
__attribute__((cold)) static void find_size_query(struct check_context *context,
                                                  struct build_view *build, const uint32_t *counts,
                                                  enum queried_size which, VkDeviceSize size)
{
    if (!context->queried)
        return;
    context->queried->build = build->index;
    context->hooks->find_size_query(context->user, build->info, counts, build_type_of(build), which,
                                    size, context->queried);
    build->queried = context->queried;
}

static bool lacks_scratch(const struct build_view *build)
{
    return build->scratch.bytes_left < build_scratch_size(build) &&
           build->scratch.status == ADDRESS_IN_BUFFER;
}

/* Queries the sizes of a build with all its geometries. */
static void query_sizes(struct check_context *context, struct build_view *build)
{
    uint32_t inline_counts[INLINE_COUNTS] = {0}, *counts = inline_counts;
    uint32_t count = build->geometry_count;
    if (count > INLINE_COUNTS)
        counts = malloc(count * sizeof(*counts));
    bool known = counts != NULL;
    for (uint32_t i = 0; known && i < count; i++)
        known = view_primitive_count(build, i, &counts[i]) ||
                dense_triangle_count(build_geometry(build->info, i), &counts[i]) ||
                needs_no_count(build, &counts[i]);
    if (known)
        context->hooks->find_sizes(context->user, build->info, counts, build_type_of(build),
                                   &build->sizes);
    if (known && build->dst.size < build->sizes.acceleration_structure)
        find_size_query(context, build, counts, SIZE_OF_STRUCTURE, build->dst.size);
    else if (known && lacks_scratch(build))
        find_size_query(context, build, counts,
                        build_is_update(build->info) ? SIZE_OF_UPDATE_SCRATCH
                                                     : SIZE_OF_BUILD_SCRATCH,
                        build->scratch.bytes_left);
    if (counts != inline_counts)
        free(counts);
}

/* Looks for a handle on other devices only if this device has no such structure. */
static void find_other_device(struct check_context *context, struct accel_facts *accel)
{
    if (accel->handle && accel->alive == NO)
        accel->of_another_device = context->hooks->of_another_device(context->user, RESOURCE_ACCEL,
                                                                     handle_number(accel->handle));
}

ON_RECORDING_PATH void view_build_sizes(struct check_context *context, struct build_view *build,
                                        bool holds)
{
    if (is_well_formed(context, build, holds) &&
        build->geometry_count == build->info->geometryCount)
        query_sizes(context, build);
}

void view_build_state(struct check_context *context, struct build_view *build)
{
    find_other_device(context, &build->dst);
    find_other_device(context, &build->src);
}

void view_geometry_state(struct check_context *context, struct geometry_view *geometry)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    if (triangles)
        geometry->vertex_format_supported =
            context->hooks->vertex_format_supported(context->user, triangles->vertexFormat);
}
