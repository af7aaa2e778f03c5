/* SPDX-License-Identifier: Apache-2.0 */
/* One predicate a row: true where its statement holds or can't be decided, else false and a
 * finding.
 *
 * The prototypes come from the rows, so a predicate whose signature isn't its subject's, or that
 * has no row, does not compile, and a row without a predicate does not link. */
#ifndef ASSAY_CHECK_PREDICATES_H
#define ASSAY_CHECK_PREDICATES_H

#include <stdbool.h>

#include "check/content_view.h"
#include "check/extension_view.h"
#include "check/finding.h"
#include "check/host_view.h"
#include "check/micromap_view.h"
#include "check/nv_view.h"
#include "check/view.h"

#define RULE(subject, name, level, ids)                                                            \
    bool name(const struct subject##_view *subject, struct finding *finding);
#define PENDING(name, level, waits_for, ids)
#include "rules.def"

#endif
