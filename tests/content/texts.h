/* SPDX-License-Identifier: Apache-2.0 */
/* Messages about what builds have read, whole. */
#ifndef CONTENT_TEXTS_H
#define CONTENT_TEXTS_H

#include "judge.h"

/* Plays them in a world that is opened for them. */
void texts_play(const struct platform *platform, struct fixture *fixture, struct tally *tally);

#endif
