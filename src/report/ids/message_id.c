/* SPDX-License-Identifier: Apache-2.0 */
/* Ids of messages: their numbers, and those that are no VUIDs. */
#include "src/report/ids/message_id.h"

#include <stddef.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

int32_t message_id_number(const char *id)
{
    return (int32_t)XXH32(id, strlen(id), 8);
}

/* ---- the ids of differences */

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

/* ---- the ids of hazards, and those of differences */

static const char *hazard_name(enum hazard_id hazard)
{
    switch (hazard) {
    case HAZARD_ID_READ_AFTER_WRITE:
        return "SYNC-HAZARD-READ-AFTER-WRITE";
    case HAZARD_ID_WRITE_AFTER_READ:
        return "SYNC-HAZARD-WRITE-AFTER-READ";
    case HAZARD_ID_WRITE_AFTER_WRITE:
        return "SYNC-HAZARD-WRITE-AFTER-WRITE";
    case HAZARD_ID_READ_RACING_WRITE:
        return "SYNC-HAZARD-READ-RACING-WRITE";
    case HAZARD_ID_WRITE_RACING_READ:
        return "SYNC-HAZARD-WRITE-RACING-READ";
    case HAZARD_ID_WRITE_RACING_WRITE:
        return "SYNC-HAZARD-WRITE-RACING-WRITE";
    case HAZARD_ID_EARLY_TRACE:
        return "ASSAY-early-trace";
    case HAZARD_ID_LATE_SHADER:
        return "ASSAY-shader-write-not-visible";
    case HAZARD_ID_HOST_WRITE:
        return "ASSAY-input-overwritten";
    case HAZARD_ID_TRACE_DESTROYED:
        return "ASSAY-trace-destroyed";
    case HAZARD_ID_OVERWRITTEN:
        return "ASSAY-structure-overwritten";
    case HAZARD_ID_TRACE_UNBUILT:
        return "ASSAY-trace-unbuilt";
    case HAZARD_ID_COUNT:
        break;
    }
    return NULL;
}

const char *other_id_name(unsigned id)
{
    if (id >= OTHER_ID_ADVICE)
        return advice_infos[id - OTHER_ID_ADVICE].id;
    return id < DIFFERENCE_COUNT ? difference_id((enum difference)id)
                                 : hazard_name((enum hazard_id)(id - DIFFERENCE_COUNT));
}
