/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs on the null driver, valid ones save for their updates and copies, with what the
 * model expects of each line. In faulty programs some builds have wrong parameters, too. */
#include "random_test.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static uint32_t random_queue(struct random_test *test)
{
    return test->queue ? 0 : below(test, QUEUES);
}

/* ---- recording */

static enum action random_action(struct random_test *test, bool is_primary)
{
    const uint32_t dice = below(test, 100);
    if (dice < 30)
        return ACTION_BUILD;
    if (dice < 70)
        return ACTION_UPDATE;
    if (dice < 80)
        return ACTION_CLONE;
    if (dice < 87)
        return ACTION_COMPACT;
    if (dice < 90 || !is_primary)
        return ACTION_FILL;
    return ACTION_EXECUTE;
}

static void add_operation(struct random_test *test, const struct operation *operation)
{
    char words[SHAPE_WORDS_SIZE];
    char ranges[16] = "";
    const char *scratch = test->is_faulty && chance(test, 50) ? " scratch S0" : "";
    shape_write(&operation->asked.shape, words);
    if (!operation->asked.counted) /* no range changes until it is read */
        snprintf(ranges, sizeof(ranges), " ranges R%u", operation->asked.shape.primitive_count);
    switch (operation->action) {
    case ACTION_BUILD:
        add_line(test, "build B%u %s%s%s", operation->dst, words, ranges, scratch);
        break;
    case ACTION_UPDATE:
        add_line(test, "build B%u update src B%u %s%s%s", operation->dst, operation->src, words,
                 ranges, scratch);
        break;
    case ACTION_FILL:
        add_line(test, "deserialize D0 > B%u", operation->dst);
        break;
    case ACTION_EXECUTE:
        add_line(test, "execute c%u", operation->dst);
        break;
    default:
        add_line(test, "%s B%u > B%u", operation->action == ACTION_CLONE ? "clone" : "compact",
                 operation->src, operation->dst);
    }
}

/* An updated or copied structure may be its own source only in updates. */
static void record_operation(struct random_test *test, uint32_t cb)
{
    struct operation operation = {.action = random_action(test, cb < SECONDARIES),
                                  .dst = below(test, STRUCTURES),
                                  .src = below(test, STRUCTURES)};
    const enum action action = operation.action;
    if (action == ACTION_EXECUTE)
        operation.dst = SECONDARIES + below(test, 2);
    if (action == ACTION_EXECUTE && (!test->executable[operation.dst] || cb >= OTHER_QUEUE))
        return;
    if ((action == ACTION_CLONE || action == ACTION_COMPACT) && operation.src == operation.dst)
        operation.src = (operation.dst + 1) % STRUCTURES;
    operation.asked = (struct content){.state = BUILT, .shape = random_shape(test)};
    /* Level content reads ranges, and the model does not. */
    operation.asked.counted = test->is_faulty || !chance(test, 20);
    if (action == ACTION_EXECUTE) {
        test->executes[cb][operation.dst] = true;
        for (uint32_t i = 0; i < STRUCTURES; i++)
            test->uses[cb][i] |= test->uses[operation.dst][i];
    } else {
        test->uses[cb][operation.dst] = true;
        test->uses[cb][operation.src] |= action != ACTION_BUILD && action != ACTION_FILL;
    }
    add_operation(test, &operation);
    model_record(&test->now.model, cb, &operation);
    expect_findings(test, false);
}

void forget_recording(struct random_test *test, uint32_t cb)
{
    test->executable[cb] = false;
    memset(test->uses[cb], 0, sizeof(test->uses[cb]));
    memset(test->executes[cb], 0, sizeof(test->executes[cb]));
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        if (test->executes[i][cb])
            forget_recording(test, i);
}

/* The commands of one command buffer. Returns whether it may be submitted. */
static bool record_operations(struct random_test *test, uint32_t cb)
{
    for (uint32_t i = below(test, 4) + 1; i > 0; i--) {
        if (test->is_faulty && chance(test, 10))
            add_line(test, "label here; fill G0; barrier all > all; unlabel");
        if (test->is_faulty && chance(test, 5)) {
            add_line(test, "build B%u stride 6", below(test, STRUCTURES));
            expect_mistake(test, RULE_vertex_stride_is_aligned);
            return false;
        }
        record_operation(test, cb);
    }
    return true;
}

static void record(struct random_test *test)
{
    const uint32_t cb = below(test, COMMAND_BUFFERS);
    const bool is_other = cb >= OTHER_QUEUE && cb < SECONDARIES;
    if (test->pending[cb] || (is_other && test->queue))
        return;
    forget_recording(test, cb);
    add_line(test, "begin c%u simultaneous%s for %s", cb, cb >= SECONDARIES ? " secondary" : "",
             queue_name(test, is_other));
    if (!play_lines(test))
        return;
    model_begin(&test->now.model, cb);
    const bool is_valid = record_operations(test, cb);
    add_line(test, "end");
    test->executable[cb] = play_lines(test) && is_valid;
}

/* ---- submitting */

__attribute__((format(printf, 2, 3))) static void add_words(struct random_test *test,
                                                            const char *format, ...)
{
    const size_t length = strlen(test->batch);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(test->batch + length, sizeof(test->batch) - length, format, arguments);
    va_end(arguments);
}

static void add_commands(struct random_test *test, struct model_batch *batch)
{
    for (uint32_t i = below(test, 3); i > 0; i--) {
        const uint32_t cb =
            batch->queue == 0 ? below(test, OTHER_QUEUE) : OTHER_QUEUE + below(test, 2);
        if (!test->executable[cb])
            continue;
        add_words(test, " c%u", cb);
        batch->recordings[batch->recording_count++] = test->now.model.command_buffers[cb];
        test->pending[cb] = true;
        for (uint32_t j = 0; j < COMMAND_BUFFERS; j++)
            test->pending[j] |= test->executes[cb][j];
    }
}

/* The leader waits only for what has run, so that it is never held back itself. */
static bool may_wait_for(const struct random_test *test, uint32_t queue, int signal)
{
    return queue != test->leader || test->now.model.batches[signal].has_run;
}

static void add_timeline_wait(struct random_test *test, struct model_batch *batch)
{
    const uint32_t other = 1 - batch->queue;
    uint32_t last = test->now.values[other];
    if (batch->queue == test->leader)
        for (last = 0; last < test->now.values[other]; last++) {
            uint32_t i = 0;
            while (test->now.model.batches[i].queue != other ||
                   test->now.model.batches[i].signal_value != last + 1)
                i++;
            if (!test->now.model.batches[i].has_run)
                break;
        }
    else
        last += 2;
    if (last == 0)
        return;
    const uint32_t value = 1 + below(test, last);
    add_words(test, " wait t%u=%u", other, value);
    batch->waits_for = other;
    batch->wait_value = value;
    if (batch->queue != test->leader && test->now.awaited < value)
        test->now.awaited = value;
}

static void signal_timeline(struct random_test *test, struct model_batch *batch, uint32_t value)
{
    batch->signal_value = test->now.values[batch->queue] = value;
    add_words(test, " signal t%u=%u", batch->queue, value);
}

static void add_batch(struct random_test *test, uint32_t queue)
{
    struct model_batch *batch = model_add_batch(&test->now.model, queue);
    const uint32_t number = test->now.model.batch_count - 1, binary = below(test, SEMAPHORES);
    test->batch[0] = '\0';
    if (test->now.binary_signal[binary] != -1 && chance(test, 50) &&
        may_wait_for(test, queue, test->now.binary_signal[binary])) {
        add_words(test, " wait s%u", binary);
        batch->binary_signal = test->now.binary_signal[binary];
        test->now.binary_signal[binary] = -1;
    }
    if (!test->queue && chance(test, 30))
        add_timeline_wait(test, batch);
    add_commands(test, batch);
    if (test->now.binary_signal[binary] == -1 && batch->binary_signal < 0 && chance(test, 40)) {
        add_words(test, " signal s%u", binary);
        test->now.binary_signal[binary] = (int)number;
    }
    if (chance(test, 40))
        signal_timeline(test, batch, test->now.values[queue] + 1);
}

/* One batch or two; the line of the submission has the last. */
static void add_submission(struct random_test *test, uint32_t queue, bool is_second_form,
                           bool fails)
{
    for (uint32_t i = below(test, 2) + 1; i > 0; i--) {
        add_batch(test, queue);
        if (i > 1)
            add_line(test, "batch%s", test->batch);
    }
    if (fails)
        add_line(test, "fail vkQueueSubmit%s OUT_OF_HOST_MEMORY", is_second_form ? "2" : "");
    add_line(test, "submit%s %s%s%s", is_second_form ? "" : "1", queue_name(test, queue),
             test->batch, fails ? " returns OUT_OF_HOST_MEMORY" : "");
}

/* Most programs need no copy. */
static void begin_submission(struct random_test *test)
{
    if (test->is_faulty)
        test->before = test->now;
}

static void submit(struct random_test *test)
{
    const uint32_t queue = random_queue(test);
    begin_submission(test);
    add_submission(test, queue, chance(test, 50), false);
    model_run(&test->now.model);
    expect_findings(test, false);
    if (!play_lines(test) && test->is_faulty)
        test->now = test->before;
}

/* Adds a submission that fails, or that the callback skips because of a finding. The layer judges
 * it like others, and it changes nothing. */
static void submit_in_vain(struct random_test *test)
{
    const uint32_t queue = random_queue(test);
    const bool fails = chance(test, 40);
    test->before = test->now;
    add_submission(test, queue, chance(test, 50), fails);
    model_run_queue(&test->now.model, queue);
    const bool is_in_vain = fails || test->now.model.finding_count;
    if (!is_in_vain)
        model_run(&test->now.model);
    expect_findings(test, is_in_vain && !fails);
    play_lines(test);
    if (is_in_vain)
        test->now = test->before;
}

/* A lost device executes nothing any more, so nothing is pending. */
static bool succeeds_or_is_lost(struct random_test *test)
{
    return play_lines(test) || test->play.result == VK_ERROR_DEVICE_LOST;
}

/* Lets all batches go that are still held back. Returns false if the submission failed. */
static bool release(struct random_test *test)
{
    if (test->now.values[test->leader] >= test->now.awaited)
        return true;
    begin_submission(test);
    test->batch[0] = '\0';
    signal_timeline(test, model_add_batch(&test->now.model, test->leader), test->now.awaited);
    add_line(test, "submit1 %s%s", queue_name(test, test->leader), test->batch);
    model_run(&test->now.model);
    expect_findings(test, false);
    if (play_lines(test) || !test->is_faulty)
        return true;
    test->now = test->before;
    return test->play.result == VK_ERROR_DEVICE_LOST;
}

/* Waits for all batches. Returns false if that failed. */
static bool idle(struct random_test *test)
{
    for (uint32_t i = 1; i <= OPERATIONS; i++)
        join(test, i);
    if (!release(test))
        return false;
    add_line(test, "host wait %s", test->queue ? test->queue : "idle");
    if (!succeeds_or_is_lost(test))
        return false;
    model_idle(&test->now.model);
    memset(test->pending, 0, sizeof(test->pending));
    return true;
}

/* ---- programs */

void random_start(struct random_test *test)
{
    add_line(test, "structures generic");
    if (test->is_faulty)
        create_all(test);
    add_line(test, "timeline t0 0; timeline t1 0");
    for (uint32_t i = 0; i < STRUCTURES; i++)
        add_line(test, "create B%u", i);
    test->now.model.batch_count = test->now.model.finding_count = 0;
    test->now.model.host = 0;
    memset(test->now.model.write_count, 0, sizeof(test->now.model.write_count));
    memset(test->now.model.host_writers, 0, sizeof(test->now.model.host_writers));
    memset(test->works, 0, sizeof(test->works));
    memset(test->pending, 0, sizeof(test->pending));
    test->leader = random_queue(test);
    test->now.awaited = 0;
    memset(test->now.values, 0, sizeof(test->now.values));
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        test->now.binary_signal[i] = -1;
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        forget_recording(test, i);
    play_lines(test);
}

void random_finish(struct random_test *test)
{
    if (!idle(test))
        idle(test);
    test->batch[0] = '\0';
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        if (test->now.binary_signal[i] >= 0)
            add_words(test, " wait s%u", i);
    add_line(test, "submit1 %s%s; host wait %s", queue_name(test, 0), test->batch,
             test->queue ? test->queue : "idle");
    play_lines(test);
}

void random_step(struct random_test *test)
{
    const uint32_t dice = below(test, 100);
    if (test->is_over || test->play.report.outcome != OUTCOME_PASSED)
        return;
    if (dice < 35) {
        record(test);
    } else if (dice < 55 && !test->queue) { /* threads leave its order to batches open */
        work_on_host(test);
    } else if (dice < 90 || (dice < 93 && test->is_faulty)) {
        submit(test);
    } else if (dice < 93) {
        submit_in_vain(test);
    } else if (idle(test)) {
        if (chance(test, 30))
            recreate(test, below(test, STRUCTURES));
        else if (test->is_faulty && chance(test, 40))
            renew_scratch(test);
    }
}
