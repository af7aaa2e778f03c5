/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs against the model, in the harness of property tests: every pair of batches is
 * asked for its order after each program. Calls may overlap, as those of several threads do: others
 * begin and end between the preparation of one and its end. A step's operand decides all that the
 * step does, so that a failing program can be reduced and replayed. */
#include <stdlib.h>

#include "generator.h"
#include "tests/unit/property.h"

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
    EXPECT(!submission_prepare(work->submission));
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

static void recreate_all(struct test *test)
{
    for (uint32_t handle = 1; handle <= SEMAPHORES && !test->name_count; handle++) {
        execution_order_remove_semaphore(test->program.order, SEMAPHORE(handle));
        create_semaphore(test, handle);
    }
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

/* Runs a step with random numbers of its own. */
#define STEP(name)                                                                                 \
    static void step_##name(void *state, const uint32_t *operands)                                 \
    {                                                                                              \
        ((struct test *)state)->random = (struct random){operands[0]};                             \
        name(state);                                                                               \
    }
STEP(recreate_all)
STEP(submit_some)
STEP(land_some)
STEP(see_some_fence)
STEP(see_some_semaphore)
STEP(see_some_idle)
STEP(signal_some_on_host)
STEP(work_on_host)
STEP(recreate_some)
STEP(present_some)

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
        EXPECT_EQUAL(found, expected);
    if (!found && signaller)
        EXPECT(model_is_before(model, model->semaphores[semaphore].signals[at].node, batch->host) ||
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
        EXPECT(!wait->is_met || !wait->signal);
        if (value <= semaphore->initial)
            EXPECT_EQUAL(wait->is_met, semaphore->timeline);
        else
            EXPECT_EQUAL(wait->is_met, !wait->signal);
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
            EXPECT_EQUAL(signal->previous, 0);
    }
}

static void compare(const struct test *test)
{
    const struct model *model = &test->model;
    EXPECT_EQUAL(test->program.losses, 0);
    for (uint32_t i = 0; i < model->batch_count; i++) {
        const struct model_batch *later = &model->batches[i];
        if (later->kind != SUBMIT_COMMANDS)
            continue;
        const struct heard *run = find_run(&test->program, later->name);
        EXPECT_EQUAL(run != NULL, later->resolved);
        if (run)
            compare_signals(test, later, run);
        for (uint32_t j = 0; run && j < model->batch_count; j++) {
            const struct model_batch *earlier = &model->batches[j];
            if (earlier->kind != SUBMIT_COMMANDS || !earlier->resolved)
                continue;
            const bool follows_it = follows(&test->program, later->name, earlier->name);
            EXPECT_EQUAL(follows_it, model_is_before(model, earlier->ends, later->starts));
            if (follows_it)
                EXPECT(find_run(&test->program, earlier->name) < run);
        }
    }
}

static void begin(void *state)
{
    struct test *test = state;
    program_start(&test->program);
    model_start(&test->model);
    for (uint32_t handle = 1; handle <= SEMAPHORES; handle++)
        create_semaphore(test, handle);
    for (uint32_t fence = 1; fence <= FENCES; fence++)
        execution_order_add_fence(test->program.order, FENCE(fence), false, false);
}

static uint32_t runs, held;

static void end(void *state)
{
    struct test *test = state;
    while (test->flying_count)
        land_some(test);
    while (test->work_count)
        end_work_on_host(test);
    compare(test);
    runs += test->program.run_count;
    held += anything_is_held(test);
    program_stop(&test->program);
}

#define ANYTHING                                                                                   \
    {                                                                                              \
        1u << 31                                                                                   \
    }

PROPERTY_TEST(order_random, .size = sizeof(struct test), .begin = begin, .end = end,
              .operations = {{"create", step_recreate_all, ANYTHING},
                             {"submit", step_submit_some, ANYTHING, 12},
                             {"land", step_land_some, ANYTHING, 3},
                             {"fence", step_see_some_fence, ANYTHING, 2},
                             {"semaphore", step_see_some_semaphore, ANYTHING, 2},
                             {"idle", step_see_some_idle, ANYTHING, 1},
                             {"signal", step_signal_some_on_host, ANYTHING, 1},
                             {"work", step_work_on_host, ANYTHING, 1},
                             {"recreate", step_recreate_some, ANYTHING, 1},
                             {"present", step_present_some, ANYTHING, 1}},
              .sequences = ORDER_PROGRAMS, .steps = 40)

TEST(programs_run_and_hold_batches)
{
    print_message("%u batches ran, %u programs ended with batches held\n", runs, held);
    assert_true(getenv("ASSAY_TEST_STEPS") || (runs > 10 * ORDER_PROGRAMS && held > 100));
}
