/* SPDX-License-Identifier: Apache-2.0 */
/* execution_model_test [--programs N] [--seed S] [--only N]
 *
 * Random programs, valid ones save for their updates, on the null driver, through the loader and
 * the layer, against the model. A program depends on the seed and its own number alone, so that
 * --only plays it again. */
#include "random_test.h"

#include <inttypes.h>
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

/* An updated or copied structure may be its own source only in updates. */
static void record_operation(struct random_test *test, uint32_t cb)
{
    struct machine *machine = &test->machine;
    const bool is_primary = cb < S;
    struct step step = {.action = random_action(test, is_primary), .object = (unsigned char)cb};
    step.dst = (unsigned char)below(test, STRUCTURES);
    step.src = (unsigned char)below(test, STRUCTURES);
    if (step.action == ACTION_EXECUTE)
        step.dst = (unsigned char)(S + below(test, 2));
    if (step.action == ACTION_EXECUTE && (!test->executable[step.dst] || QUEUE_OF(cb) != 0))
        return;
    if ((step.action == ACTION_CLONE || step.action == ACTION_COMPACT) && step.src == step.dst)
        step.src = (unsigned char)((step.dst + 1) % STRUCTURES);

    struct operation operation = {.action = step.action, .dst = step.dst, .src = step.src};
    operation.asked = (struct content){.state = BUILT, .shape = random_shape(test)};
    machine->good = operation.asked.shape;
    machine->update_command = chance(test, 20) ? COMMAND_INDIRECT : COMMAND_DEVICE;
    machine->build_command = machine->update_command;
    operation.asked.counted = machine->update_command == COMMAND_DEVICE;
    if (step.action == ACTION_EXECUTE) {
        test->executes[cb][step.dst] = true;
        for (uint32_t i = 0; i < STRUCTURES; i++)
            test->uses[cb][i] |= test->uses[step.dst][i];
    } else {
        test->uses[cb][step.dst] = true;
        test->uses[cb][step.src] |= step.action != ACTION_BUILD && step.action != ACTION_FILL;
    }
    take_step(test, step);
    model_record(&test->model, cb, &operation);
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
    take_step(test, (struct step)BEGIN_SIMULTANEOUS((unsigned char)cb));
    model_begin(&test->model, cb);
    for (uint32_t i = below(test, 4) + 1; i > 0 && !test->failed; i--) {
        record_operation(test, cb);
        settle(test);
    }
    take_step(test, (struct step)END((unsigned char)cb));
    test->executable[cb] = true;
}

/* ---- submitting */

static void add_commands(struct random_test *test, struct model_batch *batch)
{
    for (uint32_t i = below(test, 3); i > 0; i--) {
        const uint32_t cb = batch->queue == 0 ? below(test, D + 1) : P + below(test, 2);
        if (!test->executable[cb])
            continue;
        take_step(test, (struct step)WITH((unsigned char)cb));
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
        for (last = test->first_values[other]; last < test->values[other]; last++) {
            uint32_t i = 0;
            while (test->model.batches[i].queue != other ||
                   test->model.batches[i].signal_value != last + 1)
                i++;
            if (!test->model.batches[i].has_run)
                break;
        }
    else
        last += 2;
    if (last == test->first_values[other])
        return;
    const uint32_t value =
        test->first_values[other] + 1 + below(test, last - test->first_values[other]);
    take_step(test, (struct step)WAIT_FOR((unsigned char)other, value));
    batch->waits_for = other;
    batch->wait_value = value;
    if (batch->queue != test->leader && test->awaited < value)
        test->awaited = value;
}

static void add_batch(struct random_test *test, uint32_t queue)
{
    struct model_batch *batch = model_add_batch(&test->model, queue);
    const uint32_t number = test->model.batch_count - 1, binary = below(test, SEMAPHORES);
    take_step(test, (struct step)BATCH);
    if (test->binary_signal[binary] != -1 && chance(test, 50) &&
        may_wait_for(test, queue, test->binary_signal[binary])) {
        take_step(test, (struct step)WAIT((unsigned char)binary));
        batch->binary_signal = test->binary_signal[binary];
        test->binary_signal[binary] = -1;
    }
    if (chance(test, 30))
        add_timeline_wait(test, batch);
    add_commands(test, batch);
    if (test->binary_signal[binary] == -1 && batch->binary_signal < 0 && chance(test, 40)) {
        take_step(test, (struct step)SIGNAL((unsigned char)binary));
        test->binary_signal[binary] = (int)number;
    }
    if (chance(test, 40)) {
        batch->signal_value = ++test->values[queue];
        take_step(test, (struct step)SIGNAL_TO((unsigned char)queue, batch->signal_value));
    }
}

static void add_batches(struct random_test *test, uint32_t queue)
{
    for (uint32_t i = below(test, 2) + 1; i > 0; i--)
        add_batch(test, queue);
}

static void call_submit(struct random_test *test, uint32_t queue, bool second_form)
{
    if (second_form)
        take_step(test, (struct step)SUBMIT2((unsigned char)queue));
    else
        take_step(test, (struct step)SUBMIT((unsigned char)queue));
}

static void submit(struct random_test *test)
{
    const uint32_t queue = below(test, QUEUES);
    add_batches(test, queue);
    call_submit(test, queue, chance(test, 50));
    model_run(&test->model);
    settle(test);
}

/* A submission that fails, or that the callback skips if there is a finding, is judged like others
 * and leaves everything as it was. */
static void submit_in_vain(struct random_test *test)
{
    static struct model before;
    const uint32_t queue = below(test, QUEUES), awaited = test->awaited;
    const bool fails = chance(test, 40), second_form = chance(test, 50);
    uint32_t values[QUEUES];
    int binary_signal[SEMAPHORES];
    memcpy(values, test->values, sizeof(values));
    memcpy(binary_signal, test->binary_signal, sizeof(binary_signal));
    before = test->model;

    add_batches(test, queue);
    if (fails)
        test->fixture.platform->null_driver.fail_next(
            second_form ? "vkQueueSubmit2" : "vkQueueSubmit", VK_ERROR_OUT_OF_HOST_MEMORY);
    test->fixture.messages.answer = !fails;
    call_submit(test, queue, second_form);
    test->fixture.messages.answer = VK_FALSE;
    model_run_queue(&test->model, queue);
    const bool succeeds = !fails && !has_findings(&test->model);
    if (succeeds != (test->machine.result == VK_SUCCESS)) {
        printf("the submission returned %d\n", test->machine.result);
        test->failed = true;
    }
    if (succeeds) {
        model_run(&test->model);
    } else {
        memcpy(before.findings, test->model.findings, sizeof(before.findings));
        test->model = before;
        test->awaited = awaited;
        memcpy(test->values, values, sizeof(values));
        memcpy(test->binary_signal, binary_signal, sizeof(binary_signal));
    }
    settle(test);
}

/* Lets all batches go that are still held back, and waits for them. */
static void idle(struct random_test *test)
{
    for (uint32_t i = 1; i <= DEFERRED_OPERATIONS; i++)
        join(test, i);
    if (test->values[test->leader] < test->awaited) {
        struct model_batch *batch = model_add_batch(&test->model, test->leader);
        batch->signal_value = test->values[test->leader] = test->awaited;
        take_step(test, (struct step)BATCH);
        take_step(test, (struct step)SIGNAL_TO((unsigned char)test->leader, batch->signal_value));
        take_step(test, (struct step)SUBMIT((unsigned char)test->leader));
        model_run(&test->model);
        settle(test);
    }
    take_step(test, (struct step)IDLE);
    model_idle(&test->model);
    memset(test->pending, 0, sizeof(test->pending));
}

static void recreate(struct random_test *test, uint32_t structure)
{
    take_step(test, (struct step)DESTROY((unsigned char)structure));
    take_step(test, (struct step)CREATE((unsigned char)structure));
    model_create(&test->model, structure);
    for (uint32_t cb = 0; cb < COMMAND_BUFFERS; cb++)
        if (test->uses[cb][structure])
            forget_recording(test, cb);
}

/* ---- programs */

static void start(struct random_test *test)
{
    test->step_count = 0;
    test->model.batch_count = 0;
    test->model.host = 0;
    test->leader = below(test, QUEUES);
    test->awaited = 0;
    for (uint32_t i = 0; i < QUEUES; i++)
        test->first_values[i] = test->values[i];
    for (uint32_t i = 0; i < COMMAND_BUFFERS; i++)
        forget_recording(test, i);
    for (uint32_t i = 0; i < STRUCTURES; i++)
        recreate(test, i);
}

/* Leaves no binary semaphore signalled. */
static void finish(struct random_test *test)
{
    idle(test);
    take_step(test, (struct step)BATCH);
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        if (test->binary_signal[i] >= 0)
            take_step(test, (struct step)WAIT((unsigned char)i));
    take_step(test, (struct step)SUBMIT(0));
    take_step(test, (struct step)IDLE);
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        test->binary_signal[i] = -1;
}

static void play(struct random_test *test)
{
    const uint64_t findings = test->findings;
    start(test);
    for (uint32_t i = 4 + below(test, 24); i > 0 && !test->failed; i--) {
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
    if (!test->failed)
        finish(test);
    test->silent_programs += test->findings == findings;
}

/* ---- the world */

static void recycle(struct null_driver_config *config)
{
    config->recycle_handles = true;
}

static void open_test(struct random_test *test, const struct platform *platform)
{
    const struct setup setup = {.configure = recycle};
    if (fixture_open(&test->fixture, platform, &setup) != NULL)
        exit(1);
    machine_open(&test->machine, &test->fixture, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    for (uint32_t i = 0; i < SEMAPHORES; i++)
        test->binary_signal[i] = -1;
    /* The layer lets held batches of the queue go first that it got to know first. */
    for (uint32_t queue = 0; queue < QUEUES; queue++) {
        take_step(test, (struct step)BATCH);
        take_step(test, (struct step)SUBMIT((unsigned char)queue));
    }
    take_step(test, (struct step)IDLE);
}

/* ---- the program */

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
    static struct platform platform;
    static struct random_test test;
    const uint64_t programs = read_number(argc, argv, "--programs", PROGRAMS);
    const uint64_t seed = read_number(argc, argv, "--seed", random_seed(20261121));
    const uint64_t only = read_number(argc, argv, "--only", UINT64_MAX);
    const char *missing = platform_open(&platform, "null");
    if (missing != NULL) {
        printf("%s\n", missing);
        return 1;
    }
    differences_fill();
    open_test(&test, &platform);
    for (uint64_t i = 0; i < programs && !test.failed; i++) {
        if (only != UINT64_MAX && i != only)
            continue;
        test.random.state = seed + (i << 32);
        play(&test);
        if (test.failed)
            printf("program %" PRIu64 " of seed %" PRIu64 " differs\n", i, seed);
    }
    printf("seed %" PRIu64 ": %" PRIu64 " programs, %" PRIu64 " of them silent, %" PRIu64
           " findings\n",
           seed, programs, test.silent_programs, test.findings);
    machine_close(&test.machine);
    fixture_close(&test.fixture);
    return test.failed ? 1 : 0;
}
