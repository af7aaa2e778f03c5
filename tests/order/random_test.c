/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs against the model: every pair of batches is asked for its order after each
 * program. Calls may overlap, as those of several threads do: others begin and end between the
 * preparation of one and its end. */
#include <string.h>

#include "generator.h"

enum { PROGRAMS = ORDER_PROGRAMS, STEPS = 40 };

/* ---- the host */

static void see_some_fence(struct test *test)
{
    uint32_t fence = 1 + below(test, FENCES);
    struct fence_use *use = &test->fences[fence];
    if (!use->pending || use->last_batch == UINT32_MAX ||
        !test->model.batches[use->last_batch].resolved)
        return;
    execution_order_observe_fence(test->program.order, FENCE(fence));
    model_see(&test->model, test->model.batches[use->last_batch].fence);
    if (below(test, 2)) {
        execution_order_reset_fence(test->program.order, FENCE(fence));
        use->pending = false;
    }
}

static void see_some_semaphore(struct test *test)
{
    uint32_t handle = 1 + below(test, SEMAPHORES);
    struct usage *usage = &test->usage[handle];
    struct model_semaphore *semaphore = &test->model.semaphores[usage->index];
    if (!semaphore->timeline || !semaphore->signal_count)
        return;
    uint32_t at = below(test, semaphore->signal_count);
    for (uint32_t i = 0; i <= at; i++)
        if (!semaphore->signals[i].node)
            return;
    uint64_t value = semaphore->signals[at].value;
    uint64_t before = at ? semaphore->signals[at - 1].value : semaphore->initial;
    bool exact = below(test, 2);
    if (!exact)
        value -= below(test, (uint32_t)(value - before));
    execution_order_observe_semaphore(test->program.order, SEMAPHORE(handle), value, exact);
    for (uint32_t i = 0; i <= at; i++)
        model_see(&test->model, semaphore->signals[i].node);
}

static bool anything_is_held(const struct test *test)
{
    for (uint32_t queue = 1; queue <= MODEL_QUEUES; queue++)
        if (queue_is_held(test, queue))
            return true;
    return false;
}

static void see_some_idle(struct test *test)
{
    uint32_t queue = below(test, MODEL_QUEUES + 1);
    if (queue ? queue_is_flying(test, queue) || queue_is_held(test, queue)
              : test->flying_count || anything_is_held(test))
        return;
    wait_idle(&test->program, queue);
    for (uint32_t i = 1; i <= MODEL_QUEUES; i++)
        if (!queue || i == queue)
            model_see(&test->model, test->model.queues[i].all);
}

static void signal_some_on_host(struct test *test)
{
    uint32_t handle = SEMAPHORES; /* the only one BY_HOST */
    struct usage *usage = &test->usage[handle];
    signal_on_host(&test->program, handle, ++usage->top);
    model_signal_on_host(&test->model, usage->index, usage->top, test->model.host);
    model_settle(&test->model);
}

static void end_work_on_host(struct test *test)
{
    struct work *work = &test->works[below(test, test->work_count)];
    submission_finish(work->submission, VK_SUCCESS);
    struct model_batch *batch = &test->model.batches[test->model.batch_count++];
    *batch = work->batch;
    batch->ends = model_add_node(&test->model, batch->starts);
    model_see(&test->model, batch->ends);
    *work = test->works[--test->work_count];
}

/* A batch of no queue in the model. */
static void work_on_host(struct test *test)
{
    if (test->work_count == IN_FLIGHT) {
        end_work_on_host(test);
        return;
    }
    struct work *work = &test->works[test->work_count++];
    work->submission = submission_begin(test->program.order, SUBMIT_HOST_WORK, VK_NULL_HANDLE);
    submission_add_batch(work->submission);
    submission_add_commands(work->submission, COMMAND_BUFFER(++test->name_count));
    work->batch = (struct model_batch){.name = test->name_count, .resolved = true};
    work->batch.starts = model_add_node(&test->model, test->model.host);
    assert_false(submission_prepare(work->submission));
    if (below(test, 2))
        end_work_on_host(test);
}

/* Only when no batch may yet use it. */
static void recreate_some(struct test *test)
{
    if (test->flying_count || anything_is_held(test))
        return;
    uint32_t handle = 1 + below(test, SEMAPHORES);
    if (test->semaphore_count + 1 == MODEL_SEMAPHORES)
        return;
    execution_order_remove_semaphore(test->program.order, SEMAPHORE(handle));
    create_semaphore(test, handle);
}

/* The signal is consumed: as if nothing had been signalled. */
static void present_some(struct test *test)
{
    struct usage *usage = &test->usage[1 + below(test, SEMAPHORES)];
    if (usage->kind != BINARY || usage->waited == usage->top ||
        !signal_node(test, usage, usage->top))
        return;
    execution_order_forget_signal(test->program.order, SEMAPHORE((uint32_t)(usage - test->usage)));
    usage->waited = usage->top;
    usage->waiter = 0;
}

/* ---- programs */

static void step(struct test *test)
{
    static const struct {
        void (*step)(struct test *test);
        uint32_t weight;
    } steps[] = {{submit_some, 12},       {land_some, 3},     {see_some_fence, 2},
                 {see_some_semaphore, 2}, {see_some_idle, 1}, {signal_some_on_host, 1},
                 {work_on_host, 1},       {recreate_some, 1}, {present_some, 1}};
    uint32_t i = 0, choice = below(test, 24);
    for (; choice >= steps[i].weight; i++)
        choice -= steps[i].weight;
    steps[i].step(test);
}

/* The batch that signals a value; NULL: the host does. */
static const struct model_batch *find_signaller(const struct model *model, uint32_t semaphore,
                                                uint64_t value)
{
    for (uint32_t i = 0; i < model->batch_count; i++)
        for (int j = 0; j < CALL_OPERATIONS; j++)
            if (model->batches[i].signal[j].semaphore == semaphore &&
                model->batches[i].signal[j].value == value)
                return &model->batches[i];
    return NULL;
}

/* The number of a signal; 0 if its batch is not heard of. */
static uint64_t number_of(const struct test *test, const struct model_batch *signaller,
                          uint32_t semaphore)
{
    const struct heard *run = signaller && signaller->kind == SUBMIT_COMMANDS
                                  ? find_run(&test->program, signaller->name)
                                  : NULL;
    for (uint32_t i = 0; run && i < run->operation_count; i++) {
        const struct semaphore_operation *operation = &run->operations[i];
        if (operation->is_signal && test->usage[(uintptr_t)operation->handle].index == semaphore)
            return operation->signal;
    }
    return 0;
}

/* Compares what a batch found: `found`, for the signal at `at` of the semaphore. If it is 0, the
 * host had observed the signal. */
static void compare_signal(const struct test *test, const struct model_batch *batch,
                           uint32_t semaphore, uint32_t at, uint64_t found)
{
    const struct model *model = &test->model;
    const uint64_t value = model->semaphores[semaphore].signals[at].value;
    const struct model_batch *signaller = find_signaller(model, semaphore, value);
    const uint64_t expected = number_of(test, signaller, semaphore);
    if (found && expected)
        assert_int_equal(found, expected);
    if (!found && signaller)
        assert_true(
            model_is_before(model, model->semaphores[semaphore].signals[at].node, batch->host) ||
            model_is_before(model, signaller->ends, batch->host));
}

static void compare_signals(const struct test *test, const struct model_batch *batch,
                            const struct heard *run)
{
    uint32_t count = 0;
    for (int i = 0; i < CALL_OPERATIONS && batch->wait[i].semaphore; i++) {
        const struct model_semaphore *semaphore = &test->model.semaphores[batch->wait[i].semaphore];
        const struct semaphore_operation *wait = &run->operations[count++];
        const uint64_t value = batch->wait[i].value;
        uint32_t at = 0;
        while (at < semaphore->signal_count && semaphore->signals[at].value < value)
            at++;
        assert_true(!wait->is_met || !wait->signal);
        if (value <= semaphore->initial)
            assert_int_equal(wait->is_met, semaphore->timeline);
        else
            assert_int_equal(wait->is_met, !wait->signal);
        if (value > semaphore->initial)
            compare_signal(test, batch, batch->wait[i].semaphore, at, wait->signal);
    }
    for (int i = 0; i < CALL_OPERATIONS && batch->signal[i].semaphore; i++) {
        const struct model_semaphore *semaphore =
            &test->model.semaphores[batch->signal[i].semaphore];
        const struct semaphore_operation *signal = &run->operations[count++];
        uint32_t before = 0;
        while (semaphore->signals[before].value < batch->signal[i].value)
            before++;
        if (before)
            compare_signal(test, batch, batch->signal[i].semaphore, before - 1, signal->previous);
        else
            assert_int_equal(signal->previous, 0);
    }
}

static void compare(const struct test *test)
{
    const struct model *model = &test->model;
    assert_int_equal(test->program.losses, 0);
    for (uint32_t i = 0; i < model->batch_count; i++) {
        const struct model_batch *later = &model->batches[i];
        if (later->kind != SUBMIT_COMMANDS)
            continue;
        const struct heard *run = find_run(&test->program, later->name);
        assert_int_equal(run != NULL, later->resolved);
        if (run)
            compare_signals(test, later, run);
        for (uint32_t j = 0; run && j < model->batch_count; j++) {
            const struct model_batch *earlier = &model->batches[j];
            if (earlier->kind != SUBMIT_COMMANDS || !earlier->resolved)
                continue;
            bool is = follows(&test->program, later->name, earlier->name);
            bool should_be = model_is_before(model, earlier->ends, later->starts);
            if (is != should_be)
                fail_msg("batch %u follows %u: %d instead of %d", later->name, earlier->name, is,
                         should_be);
            if (is)
                assert_true(find_run(&test->program, earlier->name) < run);
        }
    }
}

static void start(struct test *test)
{
    const struct random random = test->random;
    memset(test->usage, 0, sizeof(test->usage));
    memset(test->fences, 0, sizeof(test->fences));
    test->flying_count = test->work_count = test->semaphore_count = test->name_count = 0;
    program_start(&test->program);
    model_start(&test->model);
    for (uint32_t handle = 1; handle <= SEMAPHORES; handle++)
        create_semaphore(test, handle);
    for (uint32_t fence = 1; fence <= FENCES; fence++)
        execution_order_add_fence(test->program.order, FENCE(fence), false, false);
    test->random = random;
}

TEST(random_programs_agree_with_the_model)
{
    static struct test test;
    uint64_t runs = 0, held = 0;
    test.random = random_of("order_random");
    for (uint32_t i = 0; i < PROGRAMS; i++) {
        start(&test);
        for (uint32_t j = 0; j < STEPS; j++)
            step(&test);
        while (test.flying_count)
            land_some(&test);
        while (test.work_count)
            end_work_on_host(&test);
        compare(&test);
        runs += test.program.run_count;
        held += anything_is_held(&test);
        program_stop(&test.program);
    }
    print_message("%u programs, %llu batches ran, %llu programs ended with batches held\n",
                  PROGRAMS, (unsigned long long)runs, (unsigned long long)held);
}
