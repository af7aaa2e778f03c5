/* SPDX-License-Identifier: Apache-2.0 */
/* The views that rules get: a build call, a build, a geometry, a pair of ranges. A rule treats
 * everything in a view as const. A view lives only as long as the call.
 *
 * A pointer of the application appears in a view only after it was found readable. Otherwise it is
 * NULL, and the rules that need it stay silent. */
#ifndef ASSAY_VIEW_VIEW_H
#define ASSAY_VIEW_VIEW_H

#include "src/model/geometry.h"
#include "src/state/builds/built.h"
#include "src/state/commands/journal.h"
#include "src/state/commands/used_range.h"
#include "src/state/facts.h"
#include "vuid-tables/rules.h"

/* One call of a command. */
struct call_view {
    enum build_command command;
    uint32_t info_count;
    const struct device_facts *device;
    struct command_buffer_facts command_buffer; /* of commands that are recorded */
    /* Not of build commands: struct arguments_of_NAME of the generated arguments.h. */
    const void *arguments;
    /* device_argument and deferred: of the other commands. */
    VkDevice device_argument;
    struct deferred_operation_facts deferred;

    /* As the application passed them, info_count elements each; readable only if the flag below is
     * set. */
    const VkAccelerationStructureBuildGeometryInfoKHR *infos;
    /* Not for COMMAND_INDIRECT. */
    const VkAccelerationStructureBuildRangeInfoKHR *const *build_ranges;
    /* COMMAND_INDIRECT, and queries of sizes, whose `infos` is the one build. */
    const uint32_t *const *max_primitive_counts;
    /* indirect_addresses and indirect_strides: COMMAND_INDIRECT only. */
    const VkDeviceAddress *indirect_addresses;
    const uint32_t *indirect_strides;
    bool infos_readable, build_ranges_readable, max_primitive_counts_readable,
        indirect_addresses_readable, indirect_strides_readable;
};

/* One element of pInfos. */
struct build_view {
    const struct call_view *call;
    uint32_t index;
    const VkAccelerationStructureBuildGeometryInfoKHR *info;
    /* The geometry array of the two that is not NULL, if all of it is readable. geometry_count is 0
     * if there is neither. */
    const VkAccelerationStructureGeometryKHR *geometries;
    const VkAccelerationStructureGeometryKHR *const *geometry_pointers;
    uint32_t geometry_count;
    bool geometries_unreadable, geometry_pointers_unreadable, build_ranges_unreadable;
    /* geometry_count elements, or NULL. The command determines which of the two is set. */
    const VkAccelerationStructureBuildRangeInfoKHR *ranges;
    const uint32_t *max_primitive_counts;
    /* Sums of primitiveCount, or of the maximum counts, over the geometries of each type. */
    uint64_t triangle_count, aabb_count;
    /* Index of the first geometry whose type differs from the first geometry's; geometry_count
     * if there is none. */
    uint32_t first_other_type;
    /* All data of the geometries of VK_AMDX_dense_geometry_format is readable; false if there is
     * none. */
    bool dense_readable;

    /* The micromaps that the geometries use, set after the checks of micromaps; NULL if none. */
    const struct micromap_uses *micromaps;
    struct build_inputs *inputs; /* the retained input data; NULL if none */

    /* From level STATE on. */
    struct accel_facts dst, src;
    struct address_facts scratch; /* device commands only */
    struct size_facts sizes;
    /* If dst or scratch memory is too small: the query that returned its size; NULL if neither is.
     */
    const struct size_differences *queried;
};

/* Returns the scratch size in bytes that the build's mode needs. Valid only if the sizes are
 * known. */
static inline VkDeviceSize build_scratch_size(const struct build_view *build)
{
    return build_is_update(build->info) ? build->sizes.update_scratch : build->sizes.build_scratch;
}

/* The result of walking a pNext chain once. */
struct chain_facts {
    bool has_stray; /* the chain has a structure whose type is invalid here */
    VkStructureType stray;
    const void *unreadable; /* an invalid pointer in the chain */
    bool has_duplicate;     /* the chain has two structures of one type */
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
    struct chained_inputs *chained; /* NULL if no extension adds addresses */

    /* From level STATE on; ADDRESS_UNKNOWN if the geometry has no such address, or is empty. */
    struct address_facts vertex, index_data, transform, data; /* data: AABBs or instances */
    enum tristate vertex_format_supported;
};

/* Returns the role that the address in `data` has in its build. */
static inline enum input_role data_role(const struct geometry_view *geometry)
{
    return type_is_aabbs(geometry->geometry->geometryType) ? INPUT_AABBS : INPUT_INSTANCES;
}

/* Returns the facts of the address of a role, which is in no chain. */
static inline const struct address_facts *input_facts(const struct geometry_view *geometry,
                                                      enum input_role role)
{
    return role == INPUT_VERTEX   ? &geometry->vertex
           : role == INPUT_INDEX  ? &geometry->index_data
           : role == INPUT_MATRIX ? &geometry->transform
                                  : &geometry->data;
}

/* Returns whether a build certainly reads no data of a geometry: its primitive count, or the
 * maximum count of an indirect build, is 0. Such geometries are common (translation layers build an
 * empty TLAS with an instance address of 0). Rules about the memory at an address therefore skip
 * them, although the specification makes no exception: a build that reads nothing cannot fail.
 * Returns false if the count is elsewhere or unknown. */
static inline bool geometry_is_empty(const struct geometry_view *geometry)
{
    const struct build_view *build = geometry->build;
    if (build->ranges)
        return !build->ranges[geometry->index].primitiveCount;
    return build->max_primitive_counts && !build->max_primitive_counts[geometry->index];
}

/* One geometry with its build range, or with its maximum count for the indirect command. */
struct range_view {
    const struct geometry_view *geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range; /* NULL for COMMAND_INDIRECT */
    uint32_t primitive_count;
    /* Bits 1 << role: where the buffer of that input ends, another one is or may be. */
    uint32_t continued_inputs;
};

/* One address of a build. */
struct address_view {
    const struct build_view *build;
    /* NULL for scratch and for build ranges (INPUT_INDIRECT). */
    const struct geometry_view *geometry;
    enum input_role role;
    const struct address_facts *facts;
};

/* The address from which the indirect command reads the build ranges of one build. */
struct indirect_view {
    const struct build_view *build;
    const VkDeviceAddress *address; /* address and stride: NULL if the array is not readable */
    const uint32_t *stride;
    struct address_facts facts; /* from level STATE on */
};

/* Two ranges of the same structure, or two ranges that share memory. `a` has the lower role or, if
 * the roles are equal, the lower build index. */
struct pair_view {
    const struct call_view *call;
    struct used_range a, b;
    bool shares_memory;
    struct memory_span shared; /* the memory that both ranges contain */
};

/* A structure in a sparse buffer that a build accesses when it executes, though bytes of it are not
 * bound to memory then. */
struct unbound_access_view {
    const struct accel_facts *structure;
    bool is_dst;
    VkDeviceSize begin, end; /* the bytes of the buffer that are not bound */
};

/* An update that was recorded, or that the host executes, and the state of its source when it
 * executes: never built, or built with `source`. */
struct update_view {
    enum build_command command;
    uint64_t src; /* a handle; see struct journal_entry */
    const struct built *requested, *source;
};

/* A geometry of an update, and the geometry of the same index that its source was built with; both
 * builds have the same number of geometries. */
struct updated_geometry_view {
    const struct update_view *update;
    uint32_t index;
    const struct geometry_shape *requested, *source;
};

/* ---- only for vkBuildAccelerationStructuresKHR: builds with scratch in host memory, and
 * geometries with data in host memory */

/* Bytes that a host build reads. If the primitive count is 0 or unknown, only `address` is
 * valid. */
struct host_bytes {
    const void *address; /* as the application gave it */
    /* `address` is not NULL, and some of `size` bytes from `begin` on are neither readable nor
     * mapped device memory. */
    bool unreadable;
    uint64_t begin, size;
};

struct host_build_view {
    const struct build_view *build;
    struct host_bytes scratch;
};

struct host_geometry_view {
    const struct geometry_view *geometry;
    /* By role. Zeros for inputs that the geometry lacks. */
    struct host_bytes inputs[INPUT_LAST_PLAIN + 1];
};

#endif
