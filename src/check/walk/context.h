/* SPDX-License-Identifier: Apache-2.0 */
/* The context of a check: its hooks, the rules to evaluate and the state to read. */
#ifndef ASSAY_CHECK_WALK_CONTEXT_H
#define ASSAY_CHECK_WALK_CONTEXT_H

#include <stdbool.h>

#include "src/base/readable.h"
#include "src/state/aligned_copies.h"
#include "src/state/builds/places.h"
#include "src/state/builds/size_queries.h"
#include "src/state/commands/journal.h"
#include "src/state/resources/resources.h"
#include "src/view/finding.h"
#include "src/view/location.h"
#include "src/view/nv_view.h"
#include "src/view/view.h"

struct instance_uses;
struct query_pools;
struct pending_use;
struct update_templates;
struct used_object;
struct structures;
struct sweep;

/* Functions that a check calls with the context's `user`. They may call down the layer chain; no
 * lock is held when they are called. */
struct elements_read {
    VkDeviceAddress address; /* of the first one */
    uint64_t count, stride, size;
    uint64_t hash;
};

struct check_hooks {
    /* Reports a finding. Returns false if it needs no more findings of this rule. */
    bool (*found)(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding);
    /* Gets the build sizes from the next layer. `counts` are the primitive counts. */
    void (*find_sizes)(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       struct size_facts *sizes);
    /* Finds the query of the application that returned a size, as size_queries_find(). NULL: not
     * needed. */
    void (*find_size_query)(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                            const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                            enum queried_size which, VkDeviceSize size,
                            struct size_differences *differences);
    /* Gets the sizes of the build of a micromap from the next layer. `info` and its usage counts
     * are readable and valid. */
    void (*find_micromap_sizes)(void *user, const VkMicromapBuildInfoEXT *info,
                                VkAccelerationStructureBuildTypeKHR build_type,
                                struct micromap_size_facts *sizes);
    /* Gets the sizes of a build of clusters or of a partitioned structure from the next layer: of
     * `input`, the structure that the query of the command's extension takes, which is valid. */
    void (*find_input_sizes)(void *user, const void *input, struct size_facts *sizes);
    enum tristate (*vertex_format_supported)(void *user, VkFormat format);
    enum tristate (*radius_format_supported)(void *user, VkFormat format);
    /* An instance of an executed build, at `position` of its command buffer, refers to a live
     * structure. Called once for each structure of a build. NULL: not needed. */
    void (*on_reference)(void *user, uint32_t position, const struct accel_facts *referenced);
    /* The live structures that the instances of an executed build refer to, at least one, and how
     * many refer to each. NULL: not needed. */
    void (*on_instances)(void *user, uint32_t position, const struct instance_uses *uses);
    /* An instance of an executed build has a reference that may be that of a structure which was
     * destroyed after the submission. NULL: not needed. */
    void (*refers_to_destroyed)(void *user, uint32_t build, uint32_t instance, uint64_t reference);
    /* Queries the addresses of structures that the application did not query. Called when an
     * instance refers to an address. NULL: not needed. */
    void (*query_addresses)(void *user);
    /* The smallest and the largest index of a geometry of triangles of an executed build. NULL: not
     * needed. */
    void (*on_index_range)(void *user, uint32_t build, uint32_t geometry, uint32_t smallest,
                           uint32_t largest);
    /* Elements that a device build has read, a multiple of `stride` behind an address, and a hash
     * of them. At most once for each geometry. NULL: not needed. */
    void (*on_read)(void *user, uint32_t build, uint32_t geometry,
                    const struct elements_read *read);
    /* The structures that the instances of an executed build refer to, if all are known. `uses` is
     * NULL if there are none. NULL: not needed. */
    void (*on_all_references)(void *user, const struct instance_uses *uses);
    /* An instance of an executed build refers to an address at which a build may have put a
     * structure without a handle. NULL: not needed. */
    void (*on_placed_reference)(void *user, uint32_t build, VkDeviceAddress reference);
    /* An executed build at addresses, the n-th of its command buffer, has accessed elements; or if
     * `range` has the member ADDRESSED_MEMBERS, has read a structure, of which the first byte is
     * certain. NULL: not needed. */
    void (*on_access)(void *user, uint32_t number, bool is_partitioned,
                      const struct addressed_range *range);
    /* Returns whether another device of the process has such an object with that handle. */
    bool (*of_another_device)(void *user, enum resource_kind kind, uint64_t handle);
    /* Returns whether the physical device can read serialized data of this version: two UUIDs. */
    enum tristate (*is_compatible)(void *user, bool is_micromap,
                                   const uint8_t version[2 * VK_UUID_SIZE]);
    /* Finds a command that is not complete and uses the object. Returns false if none is certain.
     */
    bool (*find_use)(void *user, const struct used_object *object, struct pending_use *use);
};

/* Functions that record the builds of a call for its journal. They are called like check_hooks. */
struct build_recorder {
    /* Called for each build after its rules. `geometry` is its only geometry, without chained
     * inputs. It is NULL if the geometries were recorded before; the parameters of COMMAND_INDIRECT
     * were, too. */
    void (*record_build)(void *user, const struct build_view *build,
                         const struct geometry_view *geometry);
    void (*record_geometry)(void *user, const struct geometry_view *geometry);
    void (*record_indirect)(void *user, const struct indirect_view *indirect);
    /* Called with all ranges of a call that uses sparse buffers. Takes over `ranges`, which is NULL
     * if there was no memory. */
    void (*record_ranges)(void *user, struct noted_ranges *ranges);
    /* These two functions do the same for COMMAND_NV. */
    void (*record_nv_build)(void *user, const struct nv_call_view *call);
    void (*record_nv_input)(void *user, uint32_t geometry, enum input_role role,
                            const struct buffer_facts *facts);
};

/* The context of a check. One thread uses it at a time. */
struct check_context {
    const struct check_hooks *hooks;
    const struct build_recorder *recorder; /* or NULL */
    void *user;
    enum level level;
    const bool *active; /* [RULE_COUNT]: the rules to evaluate for this command, see check_select */
    struct readable_cache *readable;
    struct aligned_copies *copies; /* copies of misaligned parameters; filled during a call */
    struct resources *resources;
    struct query_pools *query_pools;         /* of commands that name pools; or NULL */
    struct update_templates *templates;      /* of updates of descriptor sets; or NULL */
    const struct size_queries *size_queries; /* of the application; or NULL */
    struct size_differences *queried;        /* a place for that of struct build_view; or NULL */
    struct sweep *sweep;   /* memory kept between calls, see check_make_sweep; or NULL */
    struct places *places; /* of structures without handles; or NULL */
    const struct structures *structures; /* those that builds refer to; or NULL */
    const struct execution_point *point; /* of a host command; NULL: unknown */
    uint64_t destroy_count; /* resources_destroy_count() at submission of the builds that are
                             * validated after execution */
};

/* Selects the rules to evaluate for a command at a level: fills active[RULE_COUNT]. */
void check_select(enum build_command command, enum level level, const bool muted[MESSAGE_ID_COUNT],
                  bool active[RULE_COUNT]);

#endif
