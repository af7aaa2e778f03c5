/* SPDX-License-Identifier: Apache-2.0 */
/* All rays of a build judged: how many differ how, and the first of each kind in words. */
#ifndef ASSAY_COMPARE_SUMMARY_H
#define ASSAY_COMPARE_SUMMARY_H

#include "compare/judge.h"

struct summary {
    uint32_t rays;
    struct {
        uint32_t count, ray; /* how many, and the first */
        struct judgement judgement;
    } found[DIFFERENCE_COUNT];
};

void summary_make(const struct reference *reference, const struct rays *rays,
                  const struct compare_answer *answers, struct summary *summary);

/* What a finding says, after the name of the geometry; only where the count isn't 0. */
enum { SUMMARY_TEXT = 2048 };
void summary_describe(const struct summary *summary, const struct rays *rays,
                      enum difference difference, char text[SUMMARY_TEXT]);

#endif
