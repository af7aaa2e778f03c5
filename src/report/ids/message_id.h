/* SPDX-License-Identifier: Apache-2.0 */
/* Ids of messages: the number of each, as the Khronos layer hashes it; and the ids of hazards,
 * differences and advice. */
#ifndef ASSAY_REPORT_IDS_MESSAGE_ID_H
#define ASSAY_REPORT_IDS_MESSAGE_ID_H

#include <stdbool.h>
#include <stdint.h>

#include "vuid-tables/advice.h"

/* Returns XXH32 of the id with seed 8: the same number as the Khronos layer. */
int32_t message_id_number(const char *id);

/* ---- Differences between ray hits in the driver's acceleration structure and in the reference
 * builder's (setting compare_rays). Their ids are the layer's own, not VUIDs. */

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

/* ---- The ids of messages about the application that are not VUIDs: differences of compared rays,
 * hazards, and advice. One space of numbers, in this order. */

/* The ids of the Khronos layer, so that filters carry over. */
enum hazard_id {
    HAZARD_ID_READ_AFTER_WRITE,
    HAZARD_ID_WRITE_AFTER_READ,
    HAZARD_ID_WRITE_AFTER_WRITE,
    HAZARD_ID_READ_RACING_WRITE, /* a read, and a write in a queue that is not ordered with it */
    HAZARD_ID_WRITE_RACING_READ,
    HAZARD_ID_WRITE_RACING_WRITE,
    HAZARD_ID_ERRORS, /* warnings of the layer's own from here on */
    HAZARD_ID_EARLY_TRACE = HAZARD_ID_ERRORS,
    HAZARD_ID_LATE_SHADER,
    HAZARD_ID_HOST_WRITE,
    HAZARD_ID_TRACE_DESTROYED,
    HAZARD_ID_OVERWRITTEN,
    HAZARD_ID_TRACE_UNBUILT,
    HAZARD_ID_COUNT,
};

enum {
    OTHER_ID_ADVICE = DIFFERENCE_COUNT + HAZARD_ID_COUNT, /* the first one of an advice */
    OTHER_ID_COUNT = OTHER_ID_ADVICE + ADVICE_COUNT,
};

static inline unsigned other_id_of_hazard(enum hazard_id hazard)
{
    return DIFFERENCE_COUNT + (unsigned)hazard;
}

static inline unsigned other_id_of_advice(enum advice advice)
{
    return OTHER_ID_ADVICE + (unsigned)advice;
}

static inline bool other_id_is_waste(unsigned id)
{
    return id >= OTHER_ID_ADVICE && advice_infos[id - OTHER_ID_ADVICE].kind == ADVICE_IS_WASTE;
}

/* Differences are warnings, and so are the hazards that the Khronos layer has no ids for. */
static inline bool other_id_is_error(unsigned id)
{
    return id >= DIFFERENCE_COUNT && id < DIFFERENCE_COUNT + HAZARD_ID_ERRORS;
}

/* Returns the id in static storage, such as SYNC-HAZARD-READ-AFTER-WRITE. */
const char *other_id_name(unsigned id);

#endif
