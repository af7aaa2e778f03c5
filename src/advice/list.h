/* SPDX-License-Identifier: Apache-2.0 */
/* The list of advice of a device (setting advice), which is sent at the end of a run, except what
 * is sent before. It keeps the worst few pieces of advice of each id, and counts the others. Has a
 * lock. */
#ifndef ASSAY_ADVICE_LIST_H
#define ASSAY_ADVICE_LIST_H

#include "src/report/finding_message.h"

struct advice_list;
struct reporter;

/* Returns NULL if there is no memory. `lines`: of each id. */
struct advice_list *advice_list_create(uint32_t lines);
void advice_list_destroy(struct advice_list *list); /* accepts NULL */

/* Adds an advice; its `more` counts for nothing. `weight` says how bad it is, compared with others
 * of its id: a number of bytes, or of builds. Without memory the list only counts it. */
void advice_list_add(struct advice_list *list, const struct advice_report *report, uint64_t weight);

/* Sends of each advice that is certain at once what was added since, the worst first, and removes
 * it from the list: until as many lines as the list may have were sent of an id. */
void advice_list_send_certain(struct advice_list *list, struct reporter *reporter, VkDevice device);
/* Sends the list, the worst advice first, and empties it. Both hold no lock while a message is
 * sent.
 */
void advice_list_send(struct advice_list *list, struct reporter *reporter, VkDevice device);

#endif
