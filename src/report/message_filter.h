/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the messages that an entry of message_id_filter names. */
#ifndef ASSAY_REPORT_MESSAGE_FILTER_H
#define ASSAY_REPORT_MESSAGE_FILTER_H

#include <stdbool.h>

#include "src/report/difference.h"
#include "vuid-tables/rules.h"

/* Sets `muted` of each id that `entry` names: by VUID, by message number, or by the last digits of
 * a VUID. A retired id names the ids that replaced it. Returns false if `entry` names no id. */
bool message_filter_add(bool muted[MESSAGE_ID_COUNT], const char *entry);

/* The same for differences, by their ids or message numbers. */
bool message_filter_add_difference(bool muted[DIFFERENCE_COUNT], const char *entry);

#endif
