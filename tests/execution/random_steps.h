/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the random programs share: dice, steps, and the comparison with the model. */
#ifndef EXECUTION_RANDOM_STEPS_H
#define EXECUTION_RANDOM_STEPS_H

#include "random_test.h"

uint32_t below(struct random_test *test, uint32_t bound);
bool chance(struct random_test *test, uint32_t percent);
struct shape random_shape(struct random_test *test);

void take_step(struct random_test *test, struct step step);
/* Ends a group of steps whose findings the model knows by now. */
void settle(struct random_test *test);
bool has_findings(const struct model *model);

/* random_host.c: a command of the host; and the completion of an operation, if it has work. */
void work_on_host(struct random_test *test);
void join(struct random_test *test, uint32_t operation);

#endif
