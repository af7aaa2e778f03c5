/* SPDX-License-Identifier: Apache-2.0 */
/* One predicate a row: true where its statement holds or can't be decided, else false and a
 * finding.
 *
 * The prototypes come from the rows, so a predicate whose signature isn't its subject's, or that
 * has no row, does not compile, and a row without a predicate does not link. */
#ifndef ASSAY_RULES_PREDICATES_H
#define ASSAY_RULES_PREDICATES_H

#include <stdbool.h>

#include "src/view/content_view.h"
#include "src/view/extension_view.h"
#include "src/view/finding.h"
#include "src/view/host_view.h"
#include "src/view/micromap_view.h"
#include "src/view/nv_view.h"
#include "src/view/view.h"

#define RULE(subject, name, level, ids)                                                            \
    bool name(const struct subject##_view *subject, struct finding *finding);
#define PENDING(name, level, waits_for, ids)
#include "vuid-tables/rules.def"

#endif
