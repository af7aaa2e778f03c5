/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of calls: which forms each is played in. */
#ifndef ASSAY_TESTS_PLAYER_CALLS_PLAN_H
#define ASSAY_TESTS_PLAYER_CALLS_PLAN_H

#include "tests/player/program.h"
#include "tests/player/tally.h"

/* Plays the programs of calls among the sources. `are_all`: no other is there, so that each id must
 * have fired and stayed silent. */
void calls_play(const struct sources *sources, struct tally *tally, bool are_all);

#endif
