/* SPDX-License-Identifier: Apache-2.0 */
/* Setting advice, with setting hazards: build calls of a command buffer that could be one call. */
#ifndef ASSAY_ADVICE_SINGLE_CALLS_H
#define ASSAY_ADVICE_SINGLE_CALLS_H

#include "src/state/commands/journal.h"

/* Returns the largest number of calls of vkCmdBuildAccelerationStructuresKHR in a row that have one
 * build of a bottom-level structure each, none of which accesses what another one writes. Between
 * them the journal has at most barriers from builds to builds. Counts up to a few hundred. */
uint32_t journal_find_single_calls(const struct journal *journal);

#endif
