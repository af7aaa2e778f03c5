/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of backend cpu's offer share: a physical device without a device yet. */
#ifndef CPU_BACKEND_OFFER_STAGE_H
#define CPU_BACKEND_OFFER_STAGE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kit.h"

extern struct platform platform;
extern struct kit kit; /* between: */
int offer_open(void **state);
int offer_close(void **state);

/* What main() returns: runs the tests on the platform that the arguments name. */
int offer_main(int argc, char **argv, int (*run_all)(void));

#endif
