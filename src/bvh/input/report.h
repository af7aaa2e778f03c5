/* SPDX-License-Identifier: Apache-2.0 */
/* Counting what reading primitives found. */
#ifndef ASSAY_BVH_INPUT_REPORT_H
#define ASSAY_BVH_INPUT_REPORT_H

#include "src/bvh/input/source.h"

/* Primitives may come in any order: the first places are those of the least. */
void report_place(uint64_t *count, struct builder_place *first, struct builder_place place);
void report_state(struct builder_report *report, enum source_state found,
                  struct builder_place place);
void report_merge(struct builder_report *report, const struct builder_report *more);

#endif
