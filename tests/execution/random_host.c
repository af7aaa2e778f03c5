/* SPDX-License-Identifier: Apache-2.0 */
/* Random commands of the host, at once or deferred. */
#include <stdio.h>

#include "random_test.h"

void join(struct random_test *test, uint32_t operation)
{
    if (!test->works[operation].is_deferred)
        return;
    if (test->works[operation].fails)
        take_step(test, (struct step)FAIL_OPERATION);
    take_step(test, (struct step)JOIN((unsigned char)operation));
    test->works[operation].is_deferred = false;
    model_end_work(&test->model, test->works[operation].batch, &test->works[operation].operation,
                   test->works[operation].fails);
}

static struct step random_work(struct random_test *test)
{
    static const enum action actions[] = {
        ACTION_HOST_BUILD, ACTION_HOST_BUILD,   ACTION_HOST_UPDATE, ACTION_HOST_UPDATE,
        ACTION_HOST_CLONE, ACTION_HOST_COMPACT, ACTION_HOST_FILL};
    struct step step = {.action = actions[below(test, sizeof(actions) / sizeof(actions[0]))],
                        .dst = (unsigned char)below(test, STRUCTURES),
                        .src = (unsigned char)below(test, STRUCTURES)};
    if (chance(test, 40))
        step.object = (unsigned char)(1 + below(test, DEFERRED_OPERATIONS));
    else if (step.action <= ACTION_HOST_UPDATE && chance(test, 10))
        step.value = 1;
    if (step.action > ACTION_HOST_UPDATE && step.src == step.dst)
        step.src = (unsigned char)((step.dst + 1) % STRUCTURES);
    return step;
}

/* Some work is to be skipped if there is a finding. */
void work_on_host(struct random_test *test)
{
    const struct step step = random_work(test);
    const bool may_skip = chance(test, 20);
    join(test, step.object);
    struct operation operation = {.action = step.action, .dst = step.dst, .src = step.src};
    operation.asked =
        (struct content){.state = BUILT, .shape = random_shape(test), .counted = true};
    test->machine.good = operation.asked.shape;
    test->fixture.messages.answer = may_skip;
    take_step(test, step);
    test->fixture.messages.answer = VK_FALSE;

    const uint32_t batch = model_judge_work(&test->model, &operation);
    const bool is_skipped = may_skip && has_findings(&test->model);
    if (is_skipped != (test->machine.result == VK_ERROR_VALIDATION_FAILED_EXT)) {
        printf("the host's command returned %d\n", test->machine.result);
        test->failed = true;
    }
    settle(test);
    if (is_skipped) {
        test->fixture.platform->null_driver.reset(); /* of a failure that it has not met */
        return;
    }
    model_begin_work(&test->model, &operation);
    test->works[step.object].operation = operation;
    test->works[step.object].batch = batch;
    test->works[step.object].fails = step.object == 0 ? step.value != 0 : chance(test, 10);
    test->works[step.object].is_deferred = step.object != 0;
    if (step.object == 0)
        model_end_work(&test->model, batch, &operation, step.value != 0);
}
