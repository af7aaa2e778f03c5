/* SPDX-License-Identifier: Apache-2.0 */
/* Findings of a class of their own: what compared rays met in the driver's structure and in the
 * reference builder's (setting compare_rays). No rule of the specification has their ids. */
#ifndef ASSAY_REPORT_DIFFERENCE_H
#define ASSAY_REPORT_DIFFERENCE_H

enum difference {
    DIFFERENCE_MISSED,       /* the driver has no hit where there is one */
    DIFFERENCE_DOUBLE,       /* two hits at an edge or a vertex that surfaces share */
    DIFFERENCE_EXTRA,        /* a hit where there is none */
    DIFFERENCE_PRIMITIVE,    /* a hit by another number than the primitive's */
    DIFFERENCE_DISTANCE,     /* a hit at another t, or not the nearest one */
    DIFFERENCE_BARYCENTRICS, /* a hit at another place of its triangle */
    DIFFERENCE_FACING,       /* a hit of the other side */
    DIFFERENCE_COUNT,
};

/* ASSAY-compare-missed and so on */
const char *difference_id(enum difference difference);

#endif
