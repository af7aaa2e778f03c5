/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of submits, and the consumer that writes down. */
#include "program.h"

static void *capture(void *user, VkCommandBuffer command_buffer)
{
    struct program *program = user;
    program->captured++;
    return command_buffer;
}

static void release(void *user, void *captured)
{
    struct program *program = user;
    assert_non_null(captured);
    program->captured--;
}

static void let_others(struct program *program)
{
    void (*meanwhile)(struct program *) = program->meanwhile;
    program->meanwhile = NULL;
    if (meanwhile)
        meanwhile(program);
}

static void check(void *user, struct order_batch *batch)
{
    struct program *program = user;
    program->checks++;
    let_others(program);
    batch->skips_call = batch->command_count && program->skip_name &&
                        batch->commands[0].captured == COMMAND_BUFFER(program->skip_name);
}

static void undo(void *user, struct order_batch *batch)
{
    struct program *program = user;
    assert_true(batch->is_checked);
    program->drops++;
}

static void run(void *user, struct order_batch *batch)
{
    struct program *program = user;
    if (batch->work == WORK_BEGINS || batch->work == WORK_FAILS) {
        program->begins += batch->work == WORK_BEGINS;
        program->failures += batch->work == WORK_FAILS;
        return;
    }
    assert_true(program->run_count < PROGRAM_RUNS);
    struct heard *heard = &program->runs[program->run_count++];
    *heard = (struct heard){.command_count = batch->command_count,
                            .queue = batch->origin.queue,
                            .timestamp = batch->timestamp,
                            .checked = batch->is_checked,
                            .predecessors_known = batch->predecessors_known};
    if (batch->command_count)
        heard->name = (uint32_t)(uintptr_t)batch->commands[0].captured;
    execution_clock_copy(&heard->clock, &batch->clock);
    for (uint32_t i = 0; i < batch->operation_count && i < 2 * CALL_OPERATIONS; i++)
        heard->operations[heard->operation_count++] = batch->operations[i];
    let_others(program);
}

static void order_unknown(void *user, enum order_unknown_reason why)
{
    struct program *program = user;
    program->losses++;
    program->unknown_reason = why;
}

void program_start(struct program *program)
{
    *program = (struct program){0};
    const struct execution_hooks hooks = {.user = program, .capture = capture, .release = release};
    assert_int_equal(execution_order_create(&program->order, &hooks), VK_SUCCESS);
    execution_order_add_consumer(program->order,
                                 (struct batch_consumer){.user = program,
                                                         .check = check,
                                                         .undo = undo,
                                                         .run = run,
                                                         .order_unknown = order_unknown});
}

void program_stop(struct program *program)
{
    execution_order_destroy(program->order);
    assert_int_equal(program->captured, 0);
}

struct program *program_open(void)
{
    static struct program program;
    program_start(&program);
    return &program;
}

static enum semaphore_scope scope_of(enum reach reach)
{
    return reach == REACH_ALL ? SCOPE_ALL : reach == REACH_BUILDS ? SCOPE_BUILDS : SCOPE_NOTHING;
}

void call_add_batch(struct submission *submission, const struct call *call)
{
    submission_add_batch(submission);
    for (uint32_t i = 0; i < CALL_OPERATIONS && call->wait[i].semaphore; i++)
        submission_add_wait(submission, SEMAPHORE(call->wait[i].semaphore), call->wait[i].value,
                            scope_of(call->wait[i].reach));
    if (call->name)
        submission_add_commands(submission, COMMAND_BUFFER(call->name));
    for (uint32_t i = 0; i < CALL_OPERATIONS && call->signal[i].semaphore; i++)
        submission_add_signal(submission, SEMAPHORE(call->signal[i].semaphore),
                              call->signal[i].value, scope_of(call->signal[i].reach));
}

void submit(struct program *program, const struct call *call)
{
    struct submission *submission =
        submission_begin(program->order, call->kind, QUEUE(call->queue));
    call_add_batch(submission, call);
    assert_true(finish_batches(submission, call->fence, call->result));
}

bool finish_batches(struct submission *submission, uint32_t fence, VkResult result)
{
    submission_set_fence(submission, FENCE(fence));
    bool skip = submission_prepare(submission);
    submission_finish(submission, skip ? VK_ERROR_VALIDATION_FAILED_EXT : result);
    return !skip;
}

void create_binary(struct program *program, uint32_t semaphore)
{
    execution_order_add_semaphore(program->order, SEMAPHORE(semaphore), VK_SEMAPHORE_TYPE_BINARY, 0,
                                  false);
}

void create_timeline(struct program *program, uint32_t semaphore, uint64_t initial_value)
{
    execution_order_add_semaphore(program->order, SEMAPHORE(semaphore), VK_SEMAPHORE_TYPE_TIMELINE,
                                  initial_value, false);
}

void signal_on_host(struct program *program, uint32_t semaphore, uint64_t value)
{
    struct submission *submission =
        submission_begin(program->order, SUBMIT_HOST_SIGNAL, VK_NULL_HANDLE);
    submission_add_batch(submission);
    submission_add_signal(submission, SEMAPHORE(semaphore), value, SCOPE_ALL);
    finish_batches(submission, 0, VK_SUCCESS);
}

void wait_idle(struct program *program, uint32_t queue)
{
    struct idle_wait wait;
    execution_order_start_idle(program->order, QUEUE(queue), &wait);
    execution_order_observe_idle(program->order, &wait);
}

const struct heard *find_run(const struct program *program, uint32_t name)
{
    for (uint32_t i = 0; i < program->run_count; i++)
        if (program->runs[i].name == name)
            return &program->runs[i];
    return NULL;
}

const struct semaphore_operation *find_operation(const struct program *program, uint32_t name,
                                                 bool is_signal)
{
    const struct heard *run = find_run(program, name);
    assert_non_null(run);
    for (uint32_t i = run->operation_count; i--;)
        if (run->operations[i].is_signal == is_signal)
            return &run->operations[i];
    fail_msg("%u has no such operation", name);
    return NULL;
}

bool follows(const struct program *program, uint32_t later, uint32_t earlier)
{
    const struct heard *a = find_run(program, later), *b = find_run(program, earlier);
    assert_non_null(a);
    assert_non_null(b);
    return execution_clock_has(&a->clock, b->timestamp);
}
