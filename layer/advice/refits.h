/* SPDX-License-Identifier: Apache-2.0 */
/* Setting advice: compares the trees of updates with new ones (src/advice/figures/refits.h), on a
 * thread of its own, which works for a part of the time only (limit refit_percent). */
#ifndef ASSAY_LAYER_ADVICE_REFITS_H
#define ASSAY_LAYER_ADVICE_REFITS_H

#include "layer/layer.h"
#include "src/advice/list.h"
#include "src/advice/reading.h"

struct refit_rules;

/* Returns NULL if there is no memory. The thread starts with the first update, and adds what it
 * finds to the list. */
struct refit_rules *refit_rules_create(const struct layer_device *device,
                                       const struct advice_limits *limits,
                                       struct advice_list *list);

enum { REFITS_WAITING_MAX = 256 };

/* Hands over an update of the structure with this id, which the report names. It is not judged if
 * another one of the structure waits, or if REFITS_WAITING_MAX do. Any thread. */
void refit_rules_add(struct refit_rules *rules, uint64_t id, const struct refit *refit,
                     const struct advice_report *report);

/* Waits until all updates are judged, without pauses, and ends the thread. May be called again. */
void refit_rules_end(struct refit_rules *rules);
void refit_rules_destroy(struct refit_rules *rules); /* accepts NULL */

#endif
