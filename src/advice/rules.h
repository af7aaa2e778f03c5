/* SPDX-License-Identifier: Apache-2.0 */
/* Declares the predicates about advice, one for each row of advice.def. A predicate returns true if
 * its statement holds or cannot be decided; else it fills the finding, whose sentence follows the
 * name of the object, and returns false. It also says how bad that is: `weight`, of any unit that
 * the predicate always uses. */
#ifndef ASSAY_ADVICE_RULES_H
#define ASSAY_ADVICE_RULES_H

#include "src/advice/views.h"
#include "src/view/finding.h"

#define ADVICE(subject, name, kind, id, hint)                                                      \
    bool name(const struct subject##_view *subject, struct finding *finding, uint64_t *weight);
#include "vuid-tables/advice.def"

/* Each judges by all rows of its subject. `found` gets what is advised. */
typedef void advice_found(void *user, enum advice advice, const struct finding *finding,
                          uint64_t weight);
void advice_judge_use(const struct use_view *use, advice_found *found, void *user);
void advice_judge_crowd(const struct crowd_view *crowd, advice_found *found, void *user);
void advice_judge_mesh(const struct mesh_view *mesh, advice_found *found, void *user);
void advice_judge_placing(const struct placing_view *placing, advice_found *found, void *user);

#endif
