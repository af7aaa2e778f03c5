/* SPDX-License-Identifier: Apache-2.0 */
/* The part of the hazard check that is about commands which trace rays. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_TRACES_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_TRACES_H

#include "layer/hazards/executed/reports.h"

/* A structure was written that may be a top-level one. */
void hazard_search_note_top(struct hazard_search *search, const struct hazard_command *command,
                            const struct hazard_entry *item);
/* An access of that number writes a structure to which instances may refer. */
void hazard_search_note_bottom_write(struct hazard_search *search,
                                     const struct hazard_access *write, uint64_t structure,
                                     uint64_t number);
/* The command may trace this structure: an entry HAZARD_TRACED. */
void hazard_search_add_traced(struct hazard_search *search, const struct hazard_entry *item);
/* A shader of the command uses a descriptor of this structure statically: an entry HAZARD_USED. */
void hazard_search_check_used(struct hazard_search *search, const struct hazard_entry *item);
/* The command certainly traces rays. */
void hazard_search_check_trace(struct hazard_search *search, enum access_kind kind);
/* A structure was destroyed, or memory freed. */
void hazard_search_end_traced(struct hazard_search *search, const struct ended_object *ended);

#endif
