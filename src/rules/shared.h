/* SPDX-License-Identifier: Apache-2.0 */
/* What several files of rules share: paths of members, structures in the wrong place of a chain,
 * and the finding about an update that differs from its source. */
#ifndef ASSAY_RULES_SHARED_H
#define ASSAY_RULES_SHARED_H

#include "src/model/input_names.h"
#include "src/state/builds/size_queries.h"
#include "src/state/commands/journal.h"
#include "src/view/finding.h"
#include "src/view/view.h"
#include "vuid-tables/rules.h"

struct geometry_view;

/* Returns the path of the member that holds the device address of `role`, relative to the geometry,
 * or to the build info for scratch. */
const char *input_field(enum input_role role);
/* Returns the path of the member that holds the data which a build of the geometry reads. Host
 * builds use the host address. */
const char *content_field(const struct geometry_view *geometry, enum input_role role);

/* Returns the buffer of a structure without live memory. */
static inline struct holding_buffer holding_buffer_of_accel(const struct accel_facts *accel)
{
    return holding_buffer_of(accel->buffer, accel->buffer_id, accel->buffer_is_destroyed);
}

/* ---- structures in a pNext chain whose sType is invalid there */

/* Returns the rule that takes the invalid structure in a chain for a structure with a wrong sType.
 * Returns RULE_COUNT if there is none. The message of that rule names the id about the chain. */
enum rule rule_of_stray(const struct geometry_view *geometry);
enum rule rule_of_triangles_stray(const struct geometry_view *geometry);

/* ---- sizes */

/* Adds remarks about the query that returned the size of a dst that is too small. Returns false. */
bool remarks_on_size_query(struct finding *finding, const struct build_view *build,
                           enum queried_size which);

/* ---- updates */

/* Fills the finding: the update has the value `now` at `field`, but its source was last built with
 * `then`. Returns false. */
bool update_differs(const struct update_view *update, struct finding *finding, const char *field,
                    struct value now, struct value then);

#endif
