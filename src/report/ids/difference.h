/* SPDX-License-Identifier: Apache-2.0 */
/* Differences between ray hits in the driver's acceleration structure and in the reference
 * builder's (setting compare_rays). Their ids are the layer's own, not VUIDs. */
#ifndef ASSAY_REPORT_IDS_DIFFERENCE_H
#define ASSAY_REPORT_IDS_DIFFERENCE_H

enum difference {
    DIFFERENCE_MISSED,       /* the driver misses a hit */
    DIFFERENCE_DOUBLE,       /* the driver reports two hits at a shared edge or vertex */
    DIFFERENCE_EXTRA,        /* the driver reports a hit, but nothing is hit */
    DIFFERENCE_PRIMITIVE,    /* wrong primitive index */
    DIFFERENCE_DISTANCE,     /* wrong t, or not the nearest hit */
    DIFFERENCE_BARYCENTRICS, /* wrong barycentrics */
    DIFFERENCE_FACING,       /* wrong side */
    DIFFERENCE_COUNT,
};

/* Returns the id in static storage, such as ASSAY-compare-missed. */
const char *difference_id(enum difference difference);

#endif
