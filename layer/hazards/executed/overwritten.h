/* SPDX-License-Identifier: Apache-2.0 */
/* The part of the hazard check that is about structures whose memory something else has
 * overwritten. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_OVERWRITTEN_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_OVERWRITTEN_H

#include "layer/hazards/executed/reports.h"

/* The access of that number wrote a structure, and these bytes of it. Number 0: that is
 * not certain, and nothing is known then. */
void hazard_search_note_write(struct hazard_search *search, uint64_t structure, uint64_t number,
                              const struct hazard_bytes *bytes);
void hazard_search_forget_all_written(struct hazard_search *search);
/* Returns the bytes of a structure that begins there, as far as its last write shows; else `first`.
 */
struct hazard_bytes hazard_search_written_bytes(const struct hazard_search *search,
                                                uint64_t structure,
                                                const struct hazard_bytes *first);
/* The access of that number writes bytes. `own`: the structure that it builds or copies to; 0: it
 * writes something else. Other structures of these bytes are overwritten, until they are built
 * again, and must not be traced meanwhile. */
void hazard_search_note_overwritten(struct hazard_search *search, const struct hazard_access *write,
                                    uint64_t number, uint64_t own);
/* An access by the current command reads the structure, whose first byte that is. Returns the
 * number of the access. What the command itself writes is left to its valid usage. */
uint64_t hazard_search_read_structure(struct hazard_search *search,
                                      const struct hazard_access *read, uint64_t structure);
/* The same for an instance of the build at that position of the command buffer. No valid usage
 * forbids that a build overwrites what its own instances refer to. */
uint64_t hazard_search_read_reference(struct hazard_search *search,
                                      const struct hazard_access *read, uint64_t structure,
                                      uint32_t position);

#endif
