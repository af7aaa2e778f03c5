/* SPDX-License-Identifier: Apache-2.0 */
/* Declares the predicates about advice, one for each row of advice.def. A predicate returns true if
 * its statement holds or cannot be decided; else it fills the finding, whose sentence follows the
 * name of the object, and returns false. It also says how bad that is: `weight`, of any unit that
 * the predicate always uses. */
#ifndef ASSAY_RULES_ADVICE_H
#define ASSAY_RULES_ADVICE_H

#include "src/view/advice_view.h"
#include "src/view/finding.h"

#define ADVICE(subject, name, kind, id, hint)                                                      \
    bool name(const struct subject##_view *subject, struct finding *finding, uint64_t *weight);
#include "vuid-tables/advice.def"

/* Judges a structure by all rows of the subject `use`. `found` gets what it is advised. */
void advice_judge_use(const struct use_view *use,
                      void (*found)(void *user, enum advice advice, const struct finding *finding,
                                    uint64_t weight),
                      void *user);

#endif
