/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the findings of reading primitives. */
#ifndef ASSAY_BVH_INPUT_REPORT_H
#define ASSAY_BVH_INPUT_REPORT_H

#include "src/bvh/input/source.h"

/* Primitives may be reported in any order; `first` becomes the lowest place. */
void report_place(uint64_t *count, struct builder_place *first, struct builder_place place);
void report_state(struct builder_report *report, enum source_state found,
                  struct builder_place place);
void report_merge(struct builder_report *report, const struct builder_report *more);

#endif
