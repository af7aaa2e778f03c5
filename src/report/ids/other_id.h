/* SPDX-License-Identifier: Apache-2.0 */
/* The ids of messages about the application that are not VUIDs: differences of compared rays, and
 * hazards. One space of numbers: the differences, then the hazards. */
#ifndef ASSAY_REPORT_IDS_OTHER_ID_H
#define ASSAY_REPORT_IDS_OTHER_ID_H

#include <stdbool.h>

#include "src/report/ids/difference.h"

/* The ids of the Khronos layer, so that filters carry over. */
enum hazard_id {
    HAZARD_ID_READ_AFTER_WRITE,
    HAZARD_ID_WRITE_AFTER_READ,
    HAZARD_ID_WRITE_AFTER_WRITE,
    HAZARD_ID_READ_RACING_WRITE, /* a read, and a write in a queue that is not ordered with it */
    HAZARD_ID_WRITE_RACING_READ,
    HAZARD_ID_WRITE_RACING_WRITE,
    HAZARD_ID_COUNT,
};

enum { OTHER_ID_COUNT = DIFFERENCE_COUNT + HAZARD_ID_COUNT };

static inline unsigned other_id_of_hazard(enum hazard_id hazard)
{
    return DIFFERENCE_COUNT + (unsigned)hazard;
}

/* Hazards are errors, differences are warnings. */
static inline bool other_id_is_error(unsigned id)
{
    return id >= DIFFERENCE_COUNT;
}

/* Returns the id in static storage, such as SYNC-HAZARD-READ-AFTER-WRITE. */
const char *other_id_name(unsigned id);

#endif
