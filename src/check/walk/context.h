/* SPDX-License-Identifier: Apache-2.0 */
/* What a check needs of its surroundings. */
#ifndef ASSAY_CHECK_WALK_CONTEXT_H
#define ASSAY_CHECK_WALK_CONTEXT_H

#include <stdbool.h>

#include "src/base/readable.h"
#include "src/state/aligned_copies.h"
#include "src/state/commands/journal.h"
#include "src/state/resources/resources.h"
#include "src/view/finding.h"
#include "src/view/location.h"
#include "src/view/nv_view.h"
#include "src/view/view.h"

struct built_flags;
struct previous_shape;
struct sweep;

/* The functions that a check calls, with the context's `user`. They may call down; none is called
 * while a lock is held. */
struct check_hooks {
    /* Takes a finding. Returns false if it wants no more of this rule. */
    bool (*found)(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding);
    /* What the next layer says of build sizes; `counts` are the primitive counts. */
    void (*find_sizes)(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       struct size_facts *sizes);
    enum tristate (*vertex_format_supported)(void *user, VkFormat format);
    enum tristate (*radius_format_supported)(void *user, VkFormat format);
    /* Whether another device of the process has such a thing of that handle. */
    bool (*of_another_device)(void *user, enum resource_kind kind, uint64_t handle);
};

/* The functions that see what a call builds, for its journal; likewise. */
struct build_recorder {
    /* Each build after its rules, with its geometry if it has one alone, without chained inputs;
     * NULL: its geometries have been seen before it, as has where COMMAND_INDIRECT reads its
     * ranges. */
    void (*record_build)(void *user, const struct build_view *build,
                         const struct geometry_view *geometry);
    void (*record_geometry)(void *user, const struct geometry_view *geometry);
    void (*record_indirect)(void *user, const struct indirect_view *indirect);
    /* All ranges of a call that uses sparse buffers; takes them over. NULL without memory. */
    void (*record_ranges)(void *user, struct noted_ranges *ranges);
    /* The same for COMMAND_NV. */
    void (*record_nv_build)(void *user, const struct nv_call_view *call);
    void (*record_nv_input)(void *user, uint32_t geometry, enum input_role role,
                            const struct buffer_facts *facts);
};

/* What a check needs of its surroundings. */
struct check_context {
    const struct check_hooks *hooks;
    const struct build_recorder *recorder; /* or NULL */
    void *user;
    enum level level;
    const bool *active; /* RULE_COUNT: the rules to walk for this command, see check_select */
    struct readable_cache *readable;
    struct aligned_copies *copies; /* of misaligned parameters; filled while a call is checked */
    struct resources *resources;
    struct previous_shape *previous_shape; /* kept between calls; or NULL */
    struct sweep *sweep;       /* memory kept between calls, see check_make_sweep; or NULL */
    struct built_flags *flags; /* of structures that builds have found; or NULL */
    const struct execution_point *point; /* of the host's call; NULL: it isn't known */
    uint64_t destroy_count; /* resources_destroy_count when what is checked after it executed was
                               submitted */
};

/* Which rules there are to walk for a command at a level: fills active[RULE_COUNT]. */
void check_select(enum build_command command, enum level level, const bool muted[MESSAGE_ID_COUNT],
                  bool active[RULE_COUNT]);

#endif
