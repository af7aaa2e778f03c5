/* SPDX-License-Identifier: Apache-2.0 */
/* Random submissions. */
#include "generator.h"

#include <string.h>

uint32_t below(struct test *test, uint32_t count)
{
    return random_below(&test->random, count);
}

static uint32_t min(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

void create_semaphore(struct test *test, uint32_t handle)
{
    static const enum semaphore_kind kinds[SEMAPHORES] = {BINARY, BINARY,  BINARY,  OWNED,
                                                          OWNED,  CHAINED, CHAINED, BY_HOST};
    struct usage *usage = &test->usage[handle];
    *usage = (struct usage){.kind = kinds[handle - 1], .index = ++test->semaphore_count};
    struct model_semaphore *semaphore = &test->model.semaphores[usage->index];
    semaphore->timeline = usage->kind != BINARY;
    if (semaphore->timeline) {
        usage->top = semaphore->initial = below(test, 3);
        create_timeline(&test->program, handle, usage->top);
    } else {
        create_binary(&test->program, handle);
    }
}

node signal_node(const struct test *test, const struct usage *usage, uint64_t value)
{
    const struct model_semaphore *semaphore = &test->model.semaphores[usage->index];
    for (uint32_t i = 0; i < semaphore->signal_count; i++)
        if (semaphore->signals[i].value == value)
            return semaphore->signals[i].node;
    return 0;
}

static bool uses(const struct operation *operations, uint32_t semaphore)
{
    for (int i = 0; i < CALL_OPERATIONS; i++)
        if (operations[i].semaphore == semaphore)
            return true;
    return false;
}

static void add(struct operation *operations, uint32_t semaphore, uint64_t value, enum reach reach)
{
    int i = 0;
    while (operations[i].semaphore)
        i++;
    assert_true(i < CALL_OPERATIONS);
    operations[i] = (struct operation){semaphore, value, reach};
}

static enum reach some_reach(struct test *test)
{
    return below(test, 4) ? REACH_ALL : (enum reach)below(test, 3);
}

bool queue_is_flying(const struct test *test, uint32_t queue)
{
    for (uint32_t i = 0; i < test->flying_count; i++)
        if (test->flying[i].batches[0].queue == queue)
            return true;
    return false;
}

bool queue_is_held(const struct test *test, uint32_t queue)
{
    return test->model.queues[queue].count != 0;
}

/* A binary semaphore may be signalled again when the wait before has executed, or comes first on
 * the same queue, where bindings come in no order. */
static bool binary_is_free(const struct test *test, const struct usage *usage,
                           const struct call *call)
{
    if (usage->waited != usage->top)
        return false;
    if (usage->waiter == call->queue)
        return call->kind == SUBMIT_COMMANDS && !usage->bindings_wait;
    return usage->waiter == 0 ||
           (!queue_is_flying(test, usage->waiter) && !queue_is_held(test, usage->waiter));
}

static void add_some_wait(struct test *test, struct call *call)
{
    uint32_t handle = 1 + below(test, SEMAPHORES);
    struct usage *usage = &test->usage[handle];
    if (uses(call->wait, handle))
        return;
    uint64_t value = 0;
    if (usage->kind != BINARY) {
        value = usage->top - below(test, min(4, (uint32_t)usage->top) + 1);
        value += !below(test, 10);
    } else if (usage->waited != usage->top) {
        value = usage->waited = usage->top;
        usage->waiter = call->queue;
        usage->bindings_wait = call->kind == SUBMIT_BINDINGS;
    }
    add(call->wait, handle, value, some_reach(test));
}

static void add_chained_signal(struct test *test, struct call *call, uint32_t handle)
{
    struct usage *usage = &test->usage[handle];
    if (uses(call->wait, handle))
        return;
    uint64_t value, before = usage->top;
    if (usage->hole && below(test, 4)) {
        value = usage->hole;
        before = usage->below_hole;
        usage->hole = 0;
    } else if (!usage->hole && !below(test, 4)) {
        usage->below_hole = usage->top;
        usage->hole = before = usage->top + 1;
        value = usage->top = usage->top + 2;
    } else {
        value = ++usage->top;
    }
    add(call->wait, handle, before, REACH_ALL);
    add(call->signal, handle, value, some_reach(test));
}

static void add_some_signal(struct test *test, struct call *call)
{
    uint32_t handle = 1 + below(test, SEMAPHORES);
    struct usage *usage = &test->usage[handle];
    if (uses(call->signal, handle) || usage->top + 4 > MODEL_SIGNALS)
        return;
    if (usage->kind == CHAINED)
        add_chained_signal(test, call, handle);
    else if (usage->kind == OWNED && call->queue == handle % MODEL_QUEUES + 1)
        add(call->signal, handle, usage->top += 1 + below(test, 2), some_reach(test));
    else if (usage->kind == BINARY && binary_is_free(test, usage, call))
        add(call->signal, handle, ++usage->top, some_reach(test));
}

static void to_model(const struct test *test, const struct call *call, struct model_batch *batch)
{
    *batch = (struct model_batch){
        .name = call->name, .queue = call->queue, .kind = call->kind, .host = test->model.host};
    memcpy(batch->wait, call->wait, sizeof(batch->wait));
    memcpy(batch->signal, call->signal, sizeof(batch->signal));
    for (int i = 0; i < CALL_OPERATIONS; i++) {
        batch->wait[i].semaphore = test->usage[call->wait[i].semaphore].index;
        batch->signal[i].semaphore = test->usage[call->signal[i].semaphore].index;
    }
}

static void land(struct test *test, const struct flying *flying)
{
    uint32_t last = 0;
    for (uint32_t i = 0; i < flying->batch_count; i++)
        last = model_submit(&test->model, &flying->batches[i]);
    if (flying->fence)
        test->fences[flying->fence].last_batch = last;
    model_settle(&test->model);
}

static uint32_t some_free_fence(struct test *test)
{
    uint32_t fence = 1 + below(test, FENCES);
    return below(test, 3) || test->fences[fence].pending ? 0 : fence;
}

static struct flying begin_call(struct test *test, uint32_t queue)
{
    struct flying flying = {.batch_count = 1 + below(test, 8) / 6 * (1 + below(test, 2)),
                            .fence = some_free_fence(test)};
    enum submission_kind kind = below(test, 6) ? SUBMIT_COMMANDS : SUBMIT_BINDINGS;
    flying.submission = submission_begin(test->program.order, kind, QUEUE(queue));
    for (uint32_t i = 0; i < flying.batch_count; i++) {
        struct call call = {.queue = queue, .kind = kind};
        if (kind == SUBMIT_COMMANDS)
            call.name = ++test->name_count;
        for (uint32_t waits = below(test, 3); waits; waits--)
            add_some_wait(test, &call);
        for (uint32_t signals = below(test, 3); signals; signals--)
            add_some_signal(test, &call);
        call_add_batch(flying.submission, &call);
        to_model(test, &call, &flying.batches[i]);
        flying.batches[i].place = i;
        flying.batches[i].has_fence = flying.fence;
    }
    flying.batches[flying.batch_count - 1].gives_fence = flying.fence;
    submission_set_fence(flying.submission, FENCE(flying.fence));
    return flying;
}

static bool uses_binary(const struct flying *flying, const struct test *test)
{
    for (uint32_t i = 0; i < flying->batch_count; i++)
        for (int j = 0; j < CALL_OPERATIONS; j++)
            if (flying->batches[i].signal[j].semaphore &&
                !test->model.semaphores[flying->batches[i].signal[j].semaphore].timeline)
                return true;
    return false;
}

/* Calls that signal binary semaphores don't overlap others, which might wait for them too early. */
void submit_some(struct test *test)
{
    uint32_t queue = 1 + below(test, MODEL_QUEUES);
    if (queue_is_flying(test, queue))
        return;
    struct usage before[SEMAPHORES + 1];
    memcpy(before, test->usage, sizeof(before));
    struct flying flying = begin_call(test, queue);
    test->program.skip_name = below(test, 16) ? 0 : test->name_count;
    bool skip = submission_prepare(flying.submission);
    test->program.skip_name = 0;
    bool fails = !skip && !below(test, 12);
    if (skip || fails) {
        submission_finish(flying.submission, VK_ERROR_OUT_OF_HOST_MEMORY);
        memcpy(test->usage, before, sizeof(before));
        return;
    }
    test->fences[flying.fence].pending = flying.fence != 0;
    test->fences[flying.fence].last_batch = UINT32_MAX;
    if (test->flying_count < IN_FLIGHT && !uses_binary(&flying, test) && !below(test, 3)) {
        test->flying[test->flying_count++] = flying;
        return;
    }
    submission_finish(flying.submission, VK_SUCCESS);
    land(test, &flying);
}

void land_some(struct test *test)
{
    if (!test->flying_count)
        return;
    uint32_t i = below(test, test->flying_count);
    struct flying flying = test->flying[i];
    test->flying[i] = test->flying[--test->flying_count];
    submission_finish(flying.submission, VK_SUCCESS);
    land(test, &flying);
}
