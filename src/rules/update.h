/* SPDX-License-Identifier: Apache-2.0 */
/* The finding that the rules about updates share. */
#ifndef ASSAY_RULES_UPDATE_H
#define ASSAY_RULES_UPDATE_H

#include "src/view/finding.h"
#include "src/view/view.h"

/* Fills the finding: the update has the value `now` at `field`, but its source was last built with
 * `then`. Returns false. */
bool update_differs(const struct update_view *update, struct finding *finding, const char *field,
                    struct value now, struct value then);

#endif
