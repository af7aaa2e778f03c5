/* SPDX-License-Identifier: Apache-2.0 */
/* Which messages an entry of message_id_filter names. */
#ifndef ASSAY_REPORT_MESSAGE_FILTER_H
#define ASSAY_REPORT_MESSAGE_FILTER_H

#include <stdbool.h>

#include "src/report/difference.h"
#include "vuid-tables/rules.h"

/* Sets `muted` of every id that `entry` names: by its VUID, by its message number, or by the digits
 * at its end. An id that the registry has retired stands for those that replaced it. Returns false
 * if it names none. */
bool message_filter_add(bool muted[MESSAGE_ID_COUNT], const char *entry);

/* The same of differences, by their ids or numbers. */
bool message_filter_add_difference(bool muted[DIFFERENCE_COUNT], const char *entry);

#endif
