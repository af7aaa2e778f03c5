/* SPDX-License-Identifier: Apache-2.0 */
/* Checking where the indirect command reads its build ranges. */
#ifndef ASSAY_RULES_INDIRECT_H
#define ASSAY_RULES_INDIRECT_H

#include "src/check/walk/walk.h"

/* Asks the rules about one build of COMMAND_INDIRECT, and shows its address to the witness. */
void check_indirect(struct walk *walk, const struct build_view *build, bool with_state);

#endif
