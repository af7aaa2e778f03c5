/* SPDX-License-Identifier: Apache-2.0 */
/* The ids of hazards, and those of differences. */
#include "src/report/ids/other_id.h"

#include <stddef.h>

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
    case HAZARD_ID_COUNT:
        break;
    }
    return NULL;
}

const char *other_id_name(unsigned id)
{
    return id < DIFFERENCE_COUNT ? difference_id((enum difference)id)
                                 : hazard_name((enum hazard_id)(id - DIFFERENCE_COUNT));
}
