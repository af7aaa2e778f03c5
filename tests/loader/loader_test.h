/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of the loader share: cmocka and what it needs, the platform, a call to report. */
#ifndef LOADER_TEST_H
#define LOADER_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/rules/scene.h"

#define LENGTH(array) (sizeof(array) / sizeof((array)[0]))

extern struct platform platform;

/* A group's setup: opens the null driver's platform. */
int platform_set_up(void **state);
/* Opens the platform that the only argument names. Returns 0, or what the program returns: 2 if the
 * arguments are wrong, 77 if there is no such platform here. */
int platform_of_arguments(int argc, char **argv);

/* Makes a valid call, of which nothing may be reported, and one with a mistake. Returns the number
 * of messages of the latter; if it is 1, the message is that of the mistake. */
uint32_t count_findings(const struct setup *setup);

#endif
