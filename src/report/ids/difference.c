/* SPDX-License-Identifier: Apache-2.0 */
/* The ids of differences. */
#include "src/report/ids/difference.h"

#include <stddef.h>

const char *difference_id(enum difference difference)
{
    switch (difference) {
    case DIFFERENCE_MISSED:
        return "ASSAY-compare-missed";
    case DIFFERENCE_DOUBLE:
        return "ASSAY-compare-double";
    case DIFFERENCE_EXTRA:
        return "ASSAY-compare-extra";
    case DIFFERENCE_PRIMITIVE:
        return "ASSAY-compare-primitive";
    case DIFFERENCE_DISTANCE:
        return "ASSAY-compare-distance";
    case DIFFERENCE_BARYCENTRICS:
        return "ASSAY-compare-barycentrics";
    case DIFFERENCE_FACING:
        return "ASSAY-compare-facing";
    case DIFFERENCE_COUNT:
        break;
    }
    return NULL;
}
