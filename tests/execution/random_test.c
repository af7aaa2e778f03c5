/* SPDX-License-Identifier: Apache-2.0 */
/* execution_model_test [--programs N] [--seed S] [--only N]
 *
 * Random programs, valid ones save for their updates and copies, on the null driver, with what the
 * model expects of each line. A program depends on the seed and its own number alone, so that
 * --only plays it again. */
#include "random_test.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    const char *ranges = operation->asked.counted ? "" : " ranges R0";
    shape_write(&operation->asked.shape, words);
    switch (operation->action) {
    case ACTION_BUILD:
        add_line(test, "build B%u %s%s", operation->dst, words, ranges);
        break;
    case ACTION_UPDATE:
        add_line(test, "build B%u update src B%u %s%s", operation->dst, operation->src, words,
                 ranges);
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
    operation.asked.counted = !chance(test, 20);
    if (action == ACTION_EXECUTE) {
        test->executes[cb][operation.dst] = true;
        for (uint32_t i = 0; i < STRUCTURES; i++)
            test->uses[cb][i] |= test->uses[operation.dst][i];
    } else {
        test->uses[cb][operation.dst] = true;
        test->uses[cb][operation.src] |= action != ACTION_BUILD && action != ACTION_FILL;
    }
    add_operation(test, &operation);
    model_record(&test->model, cb, &operation);
    expect_findings(test, false);
}

/* Recording a secondary anew invalidates the primaries that execute it. */
static void forget_recording(struct random_test *test, uint32_t cb)
{
    test->executable[cb] = false;
    memset(test->uses[cb], 0, sizeof(test->uses[cb]));
    memset(test->executes[cb], 0, sizeof(test->executes[cb]));
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        if (test->executes[i][cb])
            forget_recording(test, i);
}

static void record(struct random_test *test)
{
    const uint32_t cb = below(test, COMMAND_BUFFERS);
    if (test->pending[cb])
        return;
    forget_recording(test, cb);
    add_line(test, "begin c%u simultaneous%s", cb,
             cb >= SECONDARIES   ? " secondary"
             : cb >= OTHER_QUEUE ? " for q2"
                                 : "");
    model_begin(&test->model, cb);
    for (uint32_t i = below(test, 4) + 1; i > 0; i--)
        record_operation(test, cb);
    add_line(test, "end");
    test->executable[cb] = true;
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
        batch->recordings[batch->recording_count++] = test->model.command_buffers[cb];
        test->pending[cb] = true;
        for (uint32_t j = 0; j < COMMAND_BUFFERS; j++)
            test->pending[j] |= test->executes[cb][j];
    }
}

/* The leader waits only for what has run, so that it is never held back itself. */
static bool may_wait_for(const struct random_test *test, uint32_t queue, int signal)
{
    return queue != test->leader || test->model.batches[signal].has_run;
}

static void add_timeline_wait(struct random_test *test, struct model_batch *batch)
{
    const uint32_t other = 1 - batch->queue;
    uint32_t last = test->values[other];
    if (batch->queue == test->leader)
        for (last = 0; last < test->values[other]; last++) {
            uint32_t i = 0;
            while (test->model.batches[i].queue != other ||
                   test->model.batches[i].signal_value != last + 1)
                i++;
            if (!test->model.batches[i].has_run)
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
    if (batch->queue != test->leader && test->awaited < value)
        test->awaited = value;
}

static void signal_timeline(struct random_test *test, struct model_batch *batch, uint32_t value)
{
    batch->signal_value = test->values[batch->queue] = value;
    add_words(test, " signal t%u=%u", batch->queue, value);
}

static void add_batch(struct random_test *test, uint32_t queue)
{
    struct model_batch *batch = model_add_batch(&test->model, queue);
    const uint32_t number = test->model.batch_count - 1, binary = below(test, SEMAPHORES);
    test->batch[0] = '\0';
    if (test->binary_signal[binary] != -1 && chance(test, 50) &&
        may_wait_for(test, queue, test->binary_signal[binary])) {
        add_words(test, " wait s%u", binary);
        batch->binary_signal = test->binary_signal[binary];
        test->binary_signal[binary] = -1;
    }
    if (chance(test, 30))
        add_timeline_wait(test, batch);
    add_commands(test, batch);
    if (test->binary_signal[binary] == -1 && batch->binary_signal < 0 && chance(test, 40)) {
        add_words(test, " signal s%u", binary);
        test->binary_signal[binary] = (int)number;
    }
    if (chance(test, 40))
        signal_timeline(test, batch, test->values[queue] + 1);
}

static const char *const queue_names[QUEUES] = {"q0", "q2"};

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
    add_line(test, "submit%s %s%s%s", is_second_form ? "" : "1", queue_names[queue], test->batch,
             fails ? " returns OUT_OF_HOST_MEMORY" : "");
}

static void submit(struct random_test *test)
{
    const uint32_t queue = below(test, QUEUES);
    add_submission(test, queue, chance(test, 50), false);
    model_run(&test->model);
    expect_findings(test, false);
}

/* A submission that fails, or that the callback skips if there is a finding, is judged like others
 * and leaves everything as it was. */
static void submit_in_vain(struct random_test *test)
{
    static struct model before;
    const uint32_t queue = below(test, QUEUES), awaited = test->awaited;
    const bool fails = chance(test, 40);
    uint32_t values[QUEUES];
    int binary_signal[SEMAPHORES];
    memcpy(values, test->values, sizeof(values));
    memcpy(binary_signal, test->binary_signal, sizeof(binary_signal));
    before = test->model;

    add_submission(test, queue, chance(test, 50), fails);
    model_run_queue(&test->model, queue);
    if (!fails && !test->model.finding_count) {
        model_run(&test->model);
        expect_findings(test, false);
        return;
    }
    expect_findings(test, !fails);
    test->model = before;
    test->awaited = awaited;
    memcpy(test->values, values, sizeof(values));
    memcpy(test->binary_signal, binary_signal, sizeof(binary_signal));
}

/* Lets all batches go that are still held back, and waits for them. */
static void idle(struct random_test *test)
{
    for (uint32_t i = 1; i <= OPERATIONS; i++)
        join(test, i);
    if (test->values[test->leader] < test->awaited) {
        test->batch[0] = '\0';
        signal_timeline(test, model_add_batch(&test->model, test->leader), test->awaited);
        add_line(test, "submit1 %s%s", queue_names[test->leader], test->batch);
        model_run(&test->model);
        expect_findings(test, false);
    }
    add_line(test, "host wait idle");
    model_idle(&test->model);
    memset(test->pending, 0, sizeof(test->pending));
}

static void recreate(struct random_test *test, uint32_t structure)
{
    add_line(test, "create B%u", structure);
    model_create(&test->model, structure);
    for (uint32_t cb = 0; cb < COMMAND_BUFFERS; cb++)
        if (test->uses[cb][structure])
            forget_recording(test, cb);
}

/* ---- programs */

/* Programs share objects, each with new structures and timelines. */
static void start(struct random_test *test, uint64_t number)
{
    struct program *program = &test->program;
    program->line_count = program->expected_count = 0;
    program->used = 0;
    snprintf(program->name, sizeof(program->name), "program %" PRIu64, number);
    add_line(test, "driver recycles");
    add_line(test, "structures generic");
    add_line(test, "timeline t0 0; timeline t1 0");
    for (uint32_t i = 0; i < STRUCTURES; i++)
        add_line(test, "create B%u", i);
    test->model.batch_count = test->model.finding_count = 0;
    test->model.host = 0;
    memset(test->model.write_count, 0, sizeof(test->model.write_count));
    memset(test->model.host_writers, 0, sizeof(test->model.host_writers));
    memset(test->works, 0, sizeof(test->works));
    memset(test->pending, 0, sizeof(test->pending));
    test->leader = below(test, QUEUES);
    test->awaited = 0;
    memset(test->values, 0, sizeof(test->values));
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        test->binary_signal[i] = -1;
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        forget_recording(test, i);
}

/* Leaves no binary semaphore signaled. */
static void finish(struct random_test *test)
{
    test->batch[0] = '\0';
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        if (test->binary_signal[i] >= 0)
            add_words(test, " wait s%u", i);
    add_line(test, "submit1 q0%s; host wait idle", test->batch);
}

static void generate(struct random_test *test, uint64_t number)
{
    const uint64_t findings = test->findings;
    start(test, number);
    for (uint32_t i = 4 + below(test, 24); i > 0; i--) {
        const uint32_t dice = below(test, 100);
        if (dice < 35) {
            record(test);
        } else if (dice < 55) {
            work_on_host(test);
        } else if (dice < 90) {
            submit(test);
        } else if (dice < 93) {
            submit_in_vain(test);
        } else {
            idle(test);
            if (chance(test, 30))
                recreate(test, below(test, STRUCTURES));
        }
    }
    idle(test);
    finish(test);
    test->silent_programs += test->findings == findings;
}

/* ---- the program */

/* The layer lets held batches of the queue go first that it got to know first. */
static void open_play(struct random_test *test)
{
    static struct program program = {.name = "the queues"};
    test->play = (struct play){.platform = &test->platform};
    program_add(&program, "driver recycles", 1);
    program_add(&program, "submit q0; submit q2; host wait idle", 2);
    if (!play_begin(&test->play, &program) || !play_line(&test->play, 1))
        exit(1);
}

static void play(struct random_test *test)
{
    test->play.program = &test->program;
    for (unsigned i = 0; i < test->program.line_count && test->play.outcome == OUTCOME_PASSED; i++)
        play_line(&test->play, i);
}

enum { PROGRAMS = 100000 };

static uint64_t read_number(int argc, char **argv, const char *name, uint64_t otherwise)
{
    for (int i = 1; i + 1 < argc; i += 2)
        if (strcmp(argv[i], name) == 0)
            return strtoull(argv[i + 1], NULL, 0);
    return otherwise;
}

int main(int argc, char **argv)
{
    static struct random_test test;
    const uint64_t programs = read_number(argc, argv, "--programs", PROGRAMS);
    const uint64_t seed = read_number(argc, argv, "--seed", random_seed(20261121));
    const uint64_t only = read_number(argc, argv, "--only", UINT64_MAX);
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    const char *missing = platform_open(&test.platform, "null");
    if (missing != NULL) {
        printf("%s\n", missing);
        return 1;
    }
    differences_fill();
    open_play(&test);
    for (uint64_t i = 0; i < programs && test.play.outcome == OUTCOME_PASSED; i++) {
        if (only != UINT64_MAX && i != only)
            continue;
        test.random.state = seed + (i << 32);
        generate(&test, i);
        play(&test);
        if (test.play.outcome != OUTCOME_PASSED)
            printf("%s\nseed %" PRIu64 "\n", test.play.report, seed);
    }
    printf("seed %" PRIu64 ": %" PRIu64 " programs, %" PRIu64 " of them silent, %" PRIu64
           " findings\n",
           seed, programs, test.silent_programs, test.findings);
    play_end(&test.play);
    play_close(&test.play);
    return test.play.outcome == OUTCOME_PASSED ? 0 : 1;
}
