/* SPDX-License-Identifier: Apache-2.0 */
/* Playing a case in a variant: what is found is found when the submission is complete, and not
 * before. */
#ifndef CONTENT_PLAY_H
#define CONTENT_PLAY_H

#include "variant.h"

struct content_play {
    struct play play; /* command and form are the variant's */
    const struct variant *variant;
    bool base_is_known; /* the valid call was silent in this variant and world before */
};

/* `world` as for play_case(). */
void play_content(const struct content_play *play, struct fixture *fixture, struct report *report);

#endif
