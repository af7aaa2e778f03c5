/* SPDX-License-Identifier: Apache-2.0 */
/* Declares one predicate for each row of the rules. A predicate returns true if its statement holds
 * or can't be decided; else it fills the finding and returns false.
 *
 * The prototypes come from the rows. A predicate whose signature differs from its subject's, or
 * that has no row, fails to compile; a row without a predicate fails to link. */
#ifndef ASSAY_RULES_PREDICATES_H
#define ASSAY_RULES_PREDICATES_H

#include <stdbool.h>

#include "src/view/cluster_view.h"
#include "src/view/content_view.h"
#include "src/view/extension_view.h"
#include "src/view/finding.h"
#include "src/view/life_view.h"
#include "src/view/micromap_view.h"
#include "src/view/nv_view.h"
#include "src/view/view.h"

/* Rows of generated ids have tables instead of predicates (src/check/life/implicit.h). */
struct implicit_view;

#define RULE(subject, name, level, ids)                                                            \
    bool name(const struct subject##_view *subject, struct finding *finding);
#define PENDING(name, level, waits_for, ids)
#include "vuid-tables/rules.def"

#endif
