/* SPDX-License-Identifier: Apache-2.0 */
/* The ways in which the data of device builds comes to be what it is when they execute. */
#ifndef ASSAY_TESTS_RULES_SUBMITTED_VARIANT_H
#define ASSAY_TESTS_RULES_SUBMITTED_VARIANT_H

#include "tests/rules/judge.h"

/* What the host does to the data that it wrote. The bytes that break rules and those before them
 * are exchanged. */
enum change {
    CHANGE_NOTHING,
    CHANGE_FOR_THE_WORSE,  /* between recording and submission */
    CHANGE_FOR_THE_BETTER, /* likewise: then nothing is to be found */
    CHANGE_AND_RESUBMIT,   /* for the worse, after a submission that was fine */
};

/* How the application learns that a submission is complete. */
enum waiting {
    WAIT_FENCE,
    WAIT_FENCE_STATUS,
    WAIT_TIMELINE,
    WAIT_QUEUE,
    WAIT_DEVICE,
};

struct variant {
    const char *name;
    enum build_command command;
    enum input_route inputs;
    enum change change;
    enum waiting waiting;
    bool in_secondary;
    bool uses_two_queues;   /* null driver only: others have one family */
    bool geometry_pointers; /* ppGeometries */
    bool instance_pointers; /* arrays of pointers to instances, which wants compute shaders */
};

extern const struct variant variants[];
extern const uint32_t variant_count;

/* Whether a case can be played so at all. */
bool variant_fits(const struct variant *variant, const struct platform *platform,
                  const struct test_case *test_case);

/* The make_call of --submitted (play.c): what is found is found when the submission is complete,
 * and not before. */
bool content_call(const struct play *play, struct fixture *fixture, const struct call *call,
                  struct report *report);

#endif
