/* SPDX-License-Identifier: Apache-2.0 */
/* The views that rules get: one build call, one of its builds, one geometry of it, a pair of
 * ranges. Everything in a view is const to a rule and lives only as long as the call.
 *
 * Pointers of the application appear in a view only after they were found readable; where they
 * were not, they are NULL and the rules behind them stay silent. */
#ifndef ASSAY_VIEW_VIEW_H
#define ASSAY_VIEW_VIEW_H

#include "src/state/builds/build_info.h"
#include "src/state/builds/built.h"
#include "src/state/commands/journal.h"
#include "src/state/commands/used_range.h"
#include "src/state/facts.h"
#include "vuid-tables/rules.h"

/* One call of a build command. */
struct call_view {
    enum build_command command;
    uint32_t info_count;
    const struct device_facts *device;
    struct command_buffer_facts command_buffer; /* not for COMMAND_HOST */
    VkDevice device_argument;                   /* these two: COMMAND_HOST */
    struct deferred_operation_facts deferred;

    /* As the application passed them, info_count elements each; readable only if the flag says so.
     */
    const VkAccelerationStructureBuildGeometryInfoKHR *infos;
    const VkAccelerationStructureBuildRangeInfoKHR *const *build_ranges; /* not INDIRECT */
    const uint32_t *const *max_primitive_counts;                         /* INDIRECT */
    const VkDeviceAddress *indirect_addresses;                           /* these two: INDIRECT */
    const uint32_t *indirect_strides;
    bool infos_readable, build_ranges_readable, max_primitive_counts_readable,
        indirect_addresses_readable, indirect_strides_readable;
};

/* One element of pInfos. */
struct build_view {
    const struct call_view *call;
    uint32_t index;
    const VkAccelerationStructureBuildGeometryInfoKHR *info;
    /* The geometry array that is given, readable to its end: the one of both that is not NULL.
     * geometry_count is 0 where neither is. */
    const VkAccelerationStructureGeometryKHR *geometries;
    const VkAccelerationStructureGeometryKHR *const *geometry_pointers;
    uint32_t geometry_count;
    bool geometries_unreadable, geometry_pointers_unreadable, build_ranges_unreadable;
    /* One of both, by command, geometry_count elements, or NULL. */
    const VkAccelerationStructureBuildRangeInfoKHR *ranges;
    const uint32_t *max_primitive_counts;
    /* Sums over the geometries of that type (primitiveCount or maximum), and how many types. */
    uint64_t triangle_count, aabb_count;
    uint32_t first_other_type; /* index of the first geometry whose type is not the first's; or
                                  geometry_count */
    bool dense_readable; /* the data of all geometries of VK_AMDX_dense_geometry_format; false where
                            there are none */

    /* Of what its geometries say of micromaps, after these were checked; NULL: nothing. */
    const struct micromap_uses *micromaps;
    struct build_inputs *inputs; /* what is to be kept of its data; NULL: nothing */

    /* From level STATE on. */
    struct accel_facts dst, src;
    struct address_facts scratch; /* device commands only */
    struct size_facts sizes;
};

/* Bytes of scratch that a build needs in its mode, where its sizes are known. */
static inline VkDeviceSize build_scratch_size(const struct build_view *build)
{
    return build_is_update(build->info) ? build->sizes.update_scratch : build->sizes.build_scratch;
}

/* A pNext chain, walked once. */
struct chain_facts {
    bool has_stray; /* a structure that may not stand there, */
    VkStructureType stray;
    const void *unreadable; /* a pointer that leads nowhere, */
    bool has_duplicate;     /* a structure that stands there twice */
    VkStructureType duplicate;
};

/* Addresses in the structures that extensions chain to a geometry. */
enum { CHAINED_INPUTS_MAX = 8 };

struct chained_inputs {
    uint32_t count;
    struct {
        enum input_role role;
        struct address_facts facts;
    } items[CHAINED_INPUTS_MAX];
};

/* One geometry of a build. */
struct geometry_view {
    const struct build_view *build;
    uint32_t index;
    const VkAccelerationStructureGeometryKHR *geometry;
    struct chain_facts chain, triangles_chain;
    struct chained_inputs *chained; /* NULL where no extension has any */

    /* From level STATE on; ADDRESS_UNKNOWN if the geometry has no such address, or is empty. */
    struct address_facts vertex, index_data, transform, data; /* data: AABBs or instances */
    enum tristate vertex_format_supported;
};

/* Whether a build certainly reads no data of a geometry: its primitive count is 0, or in indirect
 * builds the maximum. Such geometries are common (translation layers build an empty TLAS with an
 * instance address of 0), so no rule about what an address leads to is asked of them, although the
 * sentences make no exception: without a read there is nothing that could go wrong. False for
 * geometries whose count is elsewhere or unknown. */
static inline bool geometry_is_empty(const struct geometry_view *geometry)
{
    const struct build_view *build = geometry->build;
    if (build->ranges)
        return !build->ranges[geometry->index].primitiveCount;
    return build->max_primitive_counts && !build->max_primitive_counts[geometry->index];
}

/* One geometry with its build range (or, for the indirect command, its maximum count). */
struct range_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range; /* NULL for COMMAND_INDIRECT */
    uint32_t primitive_count;
};

/* One address of a build. */
struct address_view {
    const struct build_view *build;
    const struct geometry_view *geometry; /* NULL: scratch, or build ranges (INPUT_INDIRECT) */
    enum input_role role;
    const struct address_facts *facts;
};

/* Where the indirect command reads the build ranges of one build. */
struct indirect_view {
    const struct build_view *build;
    const VkDeviceAddress *address; /* these two: NULL where the array can't be read */
    const uint32_t *stride;
    struct address_facts facts; /* from level STATE on */
};

/* Two ranges that name the same structure or share memory; `a` is of the lower role, and of the
 * lower build among equals. */
struct pair_view {
    const struct call_view *call;
    struct used_range a, b;
    bool shares_memory;
    struct memory_span shared; /* what they share */
};

/* An update that was recorded, or is carried out by the host, and what is known of its source when
 * it executes: never built, or built with `source`. */
struct update_view {
    enum build_command command;
    uint64_t src; /* handle, see struct journal_entry */
    const struct built *asked, *source;
};

/* A geometry of an update, and the geometry of the same index that its source was built with; both
 * have as many. */
struct updated_geometry_view {
    const struct update_view *update;
    uint32_t index;
    const struct geometry_shape *asked, *source;
};

#endif
