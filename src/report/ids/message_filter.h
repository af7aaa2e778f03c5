/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns of names, as fnmatch of Python has them: * stands for any characters, ? for one, [abc],
 * [a-c] and [!abc] for one of or not of a set. A backslash stands for itself. */
#ifndef ASSAY_REPORT_IDS_MESSAGE_FILTER_H
#define ASSAY_REPORT_IDS_MESSAGE_FILTER_H

#include <stdbool.h>
#include <stdint.h>

#include "src/report/ids/message_id.h"
#include "src/report/settings/reported_lines.h"
#include "vuid-tables/rules.h"

/* Both texts are UTF-8; a byte that is not counts as a character. */
bool glob_matches(const char *glob, const char *text);

/* ---- finds the messages that an entry of message_id_filter names */

/* Sets `muted` of each id that `entry` names: by VUID, by message number, or by the last digits of
 * a VUID. A retired id names the ids that replaced it. Returns false if `entry` names no id. */
bool message_filter_add(bool muted[MESSAGE_ID_COUNT], const char *entry);

/* An entry ID@GLOB: mutes the messages of the id with an object whose debug name matches the
 * pattern, or a label that does. */
struct narrow_filter {
    struct narrow_filter *next;
    bool vuids[MESSAGE_ID_COUNT], others[OTHER_ID_COUNT];
    char glob[];
};

/* Where entries are added to. */
struct message_filters {
    bool *vuids, *others;          /* of MESSAGE_ID_COUNT and OTHER_ID_COUNT elements */
    struct narrow_filter **narrow; /* an owned list */
};

/* Adds the entries of a list: ids as above, or ID@GLOB. Adds one line to `warnings` for an entry
 * that names no id, or has no pattern after the @. If memory runs out, an entry ID@GLOB is ignored.
 */
void message_filters_load(const struct message_filters *filters, char *list,
                          struct kept_lines *warnings);
void narrow_filters_free(struct narrow_filter *filters);

/* Returns whether a filter of the list is about this id: a VUID, or MESSAGE_ID_COUNT plus an
 * other id. */
bool narrow_filters_have(const struct narrow_filter *filters, uint32_t id);
/* Returns whether such a filter matches the name, which may be NULL. */
bool narrow_filters_match(const struct narrow_filter *filters, uint32_t id, const char *name);

#endif
