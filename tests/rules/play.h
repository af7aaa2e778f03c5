/* SPDX-License-Identifier: Apache-2.0 */
/* Playing one case: on one command, in one form. */
#ifndef RULES_PLAY_H
#define RULES_PLAY_H

#include "judge.h"

/* `world` is reused from play to play; zero-initialized before the first, closed after the last. */
void play_case(const struct play *play, struct fixture *fixture, struct report *report);

#endif
