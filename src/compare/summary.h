/* SPDX-License-Identifier: Apache-2.0 */
/* The judgements of all rays of a build: the number of differences of each kind, and a description
 * of the first of each kind. */
#ifndef ASSAY_COMPARE_SUMMARY_H
#define ASSAY_COMPARE_SUMMARY_H

#include "src/compare/top.h"

struct summary {
    uint32_t rays;
    bool is_top;
    struct {
        uint32_t count; /* number of rays; the other members describe the first ray */
        struct judgement judgement;
        struct compare_ray ray;
        struct aim aim;
        struct ring ring;
        uint32_t aimed_instance;
    } found[DIFFERENCE_COUNT];
};

/* Judges the driver's answers for the rays of a BLAS. */
void summary_make(const struct reference *reference, const struct rays *rays,
                  const struct compare_answer *answers, struct summary *summary);

/* Judges the driver's answers for the rays of a TLAS. */
void summary_make_top(const struct top_reference *reference, const struct top_rays *rays,
                      const struct compare_answer *answers, struct summary *summary);

/* Writes the message of a finding that follows the name of the geometry, or of the TLAS build. The
 * count of the difference must not be 0. */
enum { SUMMARY_TEXT = 2048 };
void summary_describe(const struct summary *summary, enum difference difference,
                      char out[SUMMARY_TEXT]);

#endif
