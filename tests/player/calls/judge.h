/* SPDX-License-Identifier: Apache-2.0 */
/* Plays a program of a call in one form. */
#ifndef ASSAY_TESTS_PLAYER_CALLS_JUDGE_H
#define ASSAY_TESTS_PLAYER_CALLS_JUDGE_H

#include "tests/player/calls/case.h"

/* A program in one form. */
struct call_play {
    const struct platform *platform;
    const struct test_case *test_case;
    bool is_repaired; /* the repaired program, or the only one */
    bool is_muted;    /* the first rule is muted, so that the rules of `names` have messages */
    enum build_command command;
    bool geometry_pointers;        /* ppGeometries instead of pGeometries */
    const char *level;             /* NULL, or a setting instead of the program's own */
    const struct variant *variant; /* of --submitted, or NULL */
};

/* What is expected of its call. */
struct call {
    bool breaks;     /* rules that the layer can see */
    bool is_skipped; /* by the callback, or the layer */
    bool may_fail_on_cpu;
};

/* The id that a rule has for a command, or NULL. */
const char *rule_id(enum rule rule, enum build_command command);
const struct case_form *judge_form(const struct call_play *play);
/* Whether the command takes no build of the case's kind. */
bool judge_is_refused(const struct call_play *play);
/* Whether the environment has the layer report harsh limits. */
bool limits_are_harsh(void);

/* The rules that messages of the broken program are of. Returns their number. */
uint32_t judge_rules(const struct call_play *play, enum rule rules[2 * CASE_RULES]);
/* Whether a violation of the rule is seen at the play's level. */
bool judge_expects(const struct call_play *play, enum rule rule);
/* Whether the program has a feature off, so that other commands break its rules, too. */
bool judge_lacks_features(const struct call_play *play);

/* Plays a program. `fixture` is reused from play to play; zero-initialized before the first, closed
 * after the last. */
void judge_play(const struct call_play *play, struct fixture *fixture, struct report *report);

/* Opens a scene and edits it, unless the command takes no build of the case's kind and the program
 * is the repaired one. */
struct scene *judge_open_scene(const struct call_play *play, struct fixture *fixture);

/* The setup of the fixture. Another setup takes a new instance and device. */
struct setup judge_setup(const struct call_play *play);
bool judge_is_same_setup(const struct setup *a, const struct setup *b);

/* Each makes the call, whose messages are in the fixture afterwards. Returns false if its result or
 * what the driver got is wrong (play.c; and submitted.c, for --submitted). */
bool play_call(const struct call_play *play, struct fixture *fixture, const struct call *call,
               struct report *report);
bool content_call(const struct call_play *play, struct fixture *fixture, struct report *report);

/* Forms of builds whose data --submitted plays (submitted.c). */
struct variant {
    const char *name;
    enum build_command command;
    bool geometry_pointers; /* ppGeometries */
    bool instance_pointers; /* arrays of pointers to instances, which wants compute shaders */
};
extern const struct variant variants[];
extern const uint32_t variant_count;
/* Whether a program can be played so at all. */
bool variant_fits(const struct call_play *play);

#endif
