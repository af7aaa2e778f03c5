/* SPDX-License-Identifier: Apache-2.0 */
/* A program of tests on the platform that its argument names. program.c has the main function. */
#ifndef ASSAY_TESTS_CPU_BACKEND_PROGRAM_H
#define ASSAY_TESTS_CPU_BACKEND_PROGRAM_H

#include "tests/cpu_backend/test_between.h"

/* What the tests of a program share. Defined once for each kind of program: advertise_fixture.c,
 * host_scene.c, device_program.c. Returns NULL, or why the platform cannot be used. */
const char *program_open(const char *platform);
void program_close(void);

#endif
