/* SPDX-License-Identifier: Apache-2.0 */
/* What rules about updates say. */
#ifndef ASSAY_RULES_UPDATE_H
#define ASSAY_RULES_UPDATE_H

#include "src/view/finding.h"
#include "src/view/view.h"

/* The finding that an update asks for `now` at a field, where its source was last built with
 * `then`. Returns false. */
bool update_differs(const struct update_view *update, struct finding *finding, const char *field,
                    struct value now, struct value then);

#endif
