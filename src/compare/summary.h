/* SPDX-License-Identifier: Apache-2.0 */
/* All rays of a build judged: how many differ how, and the first of each kind in words. */
#ifndef ASSAY_COMPARE_SUMMARY_H
#define ASSAY_COMPARE_SUMMARY_H

#include "src/compare/top.h"

struct summary {
    uint32_t rays;
    bool is_top;
    struct {
        uint32_t count; /* how many; and of the first: */
        struct judgement judgement;
        struct compare_ray ray;
        struct aim aim;
        struct ring ring;
        uint32_t aimed_instance;
    } found[DIFFERENCE_COUNT];
};

void summary_make(const struct reference *reference, const struct rays *rays,
                  const struct compare_answer *answers, struct summary *summary);

void summary_make_top(const struct top_reference *reference, const struct top_rays *rays,
                      const struct compare_answer *answers, struct summary *summary);

/* What a finding says, after the name of the geometry, or of the TLAS's build; only where the count
 * isn't 0. */
enum { SUMMARY_TEXT = 2048 };
void summary_describe(const struct summary *summary, enum difference difference,
                      char out[SUMMARY_TEXT]);

#endif
