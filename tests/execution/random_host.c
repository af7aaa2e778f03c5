/* SPDX-License-Identifier: Apache-2.0 */
/* Random commands of the host, at once or deferred. */
#include "random_test.h"

#include <stdio.h>

void join(struct random_test *test, uint32_t operation)
{
    if (!test->works[operation].is_deferred)
        return;
    if (test->works[operation].fails)
        add_line(test, "fail vkGetDeferredOperationResultKHR OUT_OF_HOST_MEMORY");
    add_line(test, "host join d%u", operation);
    play_lines(test);
    test->works[operation].is_deferred = false;
    model_end_work(&test->now.model, test->works[operation].batch,
                   &test->works[operation].operation, test->works[operation].fails);
}

static struct operation random_work(struct random_test *test, uint32_t *deferred, bool *fails)
{
    static const enum action actions[] = {
        ACTION_HOST_BUILD, ACTION_HOST_BUILD,   ACTION_HOST_UPDATE, ACTION_HOST_UPDATE,
        ACTION_HOST_CLONE, ACTION_HOST_COMPACT, ACTION_HOST_FILL};
    struct operation work = {.action = actions[below(test, ARRAY_COUNT(actions))],
                             .dst = below(test, STRUCTURES),
                             .src = below(test, STRUCTURES),
                             .asked = {.state = BUILT, .counted = true}};
    if (test->play.platform->is_cpu) /* it refuses what the model finds mistakes in */
        work.action = ACTION_HOST_BUILD;
    *deferred = chance(test, 40) ? 1 + below(test, OPERATIONS) : 0;
    *fails =
        !test->is_faulty && !*deferred && work.action <= ACTION_HOST_UPDATE && chance(test, 10);
    if (work.action > ACTION_HOST_UPDATE && work.src == work.dst)
        work.src = (work.dst + 1) % STRUCTURES;
    work.asked.shape = random_shape(test);
    return work;
}

/* `end`: what follows the command. */
static void add_work(struct random_test *test, const struct operation *work, const char *end)
{
    char words[SHAPE_WORDS_SIZE];
    shape_write(&work->asked.shape, words);
    switch (work->action) {
    case ACTION_HOST_BUILD:
        add_line(test, "host build B%u %s%s", work->dst, words, end);
        break;
    case ACTION_HOST_UPDATE:
        add_line(test, "host build B%u update src B%u %s%s", work->dst, work->src, words, end);
        break;
    case ACTION_HOST_FILL:
        add_line(test, "host deserialize D0 > B%u%s", work->dst, end);
        break;
    default:
        add_line(test, "host %s B%u > B%u%s",
                 work->action == ACTION_HOST_CLONE ? "clone" : "compact", work->src, work->dst,
                 end);
    }
}

/* Some work is to be skipped if there is a finding. */
void work_on_host(struct random_test *test)
{
    uint32_t deferred;
    bool fails;
    char end[64] = "";
    const struct operation work = random_work(test, &deferred, &fails);
    const bool may_skip = !test->is_faulty && chance(test, 20);
    join(test, deferred);
    const uint32_t batch = model_judge_work(&test->now.model, &work);
    const bool is_skipped = may_skip && test->now.model.finding_count;
    if (deferred)
        snprintf(end, sizeof(end), " deferred d%u", deferred);
    else if (fails && !is_skipped)
        snprintf(end, sizeof(end), " returns OUT_OF_HOST_MEMORY");
    if (fails && !is_skipped)
        add_line(test, "fail vkBuildAccelerationStructuresKHR OUT_OF_HOST_MEMORY");
    add_work(test, &work, end);
    expect_findings(test, is_skipped);
    const bool is_done = play_lines(test);
    if (is_skipped)
        return;
    model_begin_work(&test->now.model, &work);
    deferred = is_done ? deferred : 0;
    test->works[deferred].operation = work;
    test->works[deferred].batch = batch;
    test->works[deferred].fails = deferred ? !test->is_faulty && chance(test, 10) : !is_done;
    test->works[deferred].is_deferred = deferred != 0;
    if (!deferred)
        model_end_work(&test->now.model, batch, &work, !is_done);
}
