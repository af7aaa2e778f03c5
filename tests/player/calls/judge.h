/* SPDX-License-Identifier: Apache-2.0 */
/* Plays a case in one form: fixtures, mutations, and what is expected of messages. */
#ifndef ASSAY_TESTS_PLAYER_CALLS_JUDGE_H
#define ASSAY_TESTS_PLAYER_CALLS_JUDGE_H

#include "tests/player/calls/case.h"
#include "tests/player/tally.h"

struct call;

/* One way to play a case. */
struct play {
    /* Makes one call of the case, whose messages are in the fixture afterwards. Returns false if
     * the call cannot be judged. */
    bool (*make_call)(const struct play *play, struct fixture *fixture, const struct call *call,
                      struct report *report);
    const struct platform *platform;
    const struct test_case *test_case;
    enum build_command command;
    bool geometry_pointers;        /* ppGeometries instead of pGeometries */
    const char *level;             /* NULL, or a setting instead of the case's own */
    const struct variant *variant; /* of --submitted, or NULL */
    bool base_is_known;            /* the valid call was silent in this form before */
};

/* One of the three calls of a case. */
struct call {
    const char *what;
    const struct case_form *form; /* the edits; NULL: none */
    bool is_mutation, breaks, forwards, may_fail_on_cpu;
};

/* The id that a rule has for a command, or NULL. */
const char *rule_id(enum rule rule, enum build_command command);

/* Whether the command takes no build of the case's kind. */
bool judge_is_refused(const struct play *play);
/* Whether the environment has the layer report harsh limits. */
bool limits_are_harsh(void);

/* Whether the mutation breaks a rule of the case where the layer can see it: at the play's level.
 */
bool judge_expects(const struct play *play, enum rule rule);

/* Whether the case has a feature off, so that other commands break its rules, too. */
bool judge_lacks_features(const struct test_case *test_case);

/* Plays a case: the valid call, the twin, the mutation, each in a scene of its own. `fixture` is
 * reused from play to play; zero-initialized before the first, closed after the last. */
void judge_play(const struct play *play, struct fixture *fixture, struct report *report);

/* Opens a scene and edits it as the call says. */
struct scene *judge_open_scene(const struct play *play, struct fixture *fixture,
                               const struct call *call);

/* The setup of the fixture in which judge_play() begins. Another setup takes a new instance and
 * device. */
struct setup judge_first_setup(const struct play *play);
bool judge_is_same_setup(const struct setup *a, const struct setup *b);

/* The make_call of all forms but those of --submitted (play.c). */
bool play_call(const struct play *play, struct fixture *fixture, const struct call *call,
               struct report *report);

/* Forms of builds whose data --submitted plays (submitted.c). */
struct variant {
    const char *name;
    enum build_command command;
    bool geometry_pointers; /* ppGeometries */
    bool instance_pointers; /* arrays of pointers to instances, which wants compute shaders */
};
extern const struct variant variants[];
extern const uint32_t variant_count;
/* Whether a case can be played so at all. */
bool variant_fits(const struct variant *variant, const struct platform *platform,
                  const struct test_case *test_case);
/* The make_call of --submitted. */
bool content_call(const struct play *play, struct fixture *fixture, const struct call *call,
                  struct report *report);

/* ---- what messages say beside what is wrong (wording.c) ---- */

/* Returns whether each message has the hint of its row and counts that agree with their nouns, and
 * whether the messages of the case's first rule name the ids of the rules of `names`. */
bool wording_is_good(const struct play *play, const struct fixture *fixture, struct report *report);

/* A play of a case, with its first rule muted: the rules of `names` have messages of their own. */
struct muted_play {
    struct play play;
    struct test_case test_case;
    char name[192];
};

/* Makes that play. Returns false if the case names no rule for this command. `muted` must not
 * move. */
bool wording_mute(const struct play *play, struct muted_play *muted);

#endif
