/* SPDX-License-Identifier: Apache-2.0 */
/* The last findings about vkGetAccelerationStructureBuildSizesKHR, if a layer is above. Such as the
 * Khronos layer, it may query the sizes of each build of the application, some several times: what
 * is wrong with the build is then wrong with each of these queries. A finding that says the same as
 * one of the last ones, from the same call site, is not reported again. Any thread, without a lock:
 * of two threads that find the same at once, both may report it. */
#ifndef ASSAY_REPORT_REPORTED_QUERIES_H
#define ASSAY_REPORT_REPORTED_QUERIES_H

#include <stdatomic.h>

#include "src/view/finding.h"
#include "src/view/location.h"

struct call_site;

enum { REPORTED_QUERIES = 16 };

/* Zero is empty. */
struct reported_queries {
    _Atomic uint64_t
        items[REPORTED_QUERIES]; /* a ring of reported_query(), with REPORTED_SKIPS; 0: none */
    atomic_uint next;
};

/* A callback returned VK_TRUE, to skip the call. */
#define REPORTED_SKIPS UINT64_C(1)

/* What a finding says, as a number other than 0 that lacks REPORTED_SKIPS. */
uint64_t reported_query(enum rule rule, const struct location *location,
                        const struct finding *finding, const struct call_site *site);
/* Returns the number with REPORTED_SKIPS if that was added, else without. Returns 0 if the finding
 * was not reported lately. */
uint64_t reported_queries_find(struct reported_queries *reported, uint64_t query);
void reported_queries_add(struct reported_queries *reported, uint64_t query);

#endif
