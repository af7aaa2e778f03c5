/* SPDX-License-Identifier: Apache-2.0 */
#include "program.h"

#include <string.h>

#include "tests/unit/random.h"

enum {
    GENERATED_BATCHES = 24,
    GENERATED_SIGNALS = 24,
    BATCH_COMMANDS = 4,
    COMMAND_ACCESSES = 3,
    /* with two waits and signals, and what may precede it */
    LONGEST_BATCH = BATCH_COMMANDS * COMMAND_ACCESSES + 6,
};

struct generated_signal {
    uint64_t semaphore, value;
    bool has_gap;                    /* nothing signals the value before */
    uint64_t before[PROGRAM_QUEUES]; /* what is before a batch that waits for the signal */
};

struct generator {
    struct random random;
    struct program *program;
    bool has_host;
    uint32_t queue_count; /* without the host */
    kind_set kinds;
    stage_set stages;                /* of the kinds, and one that only continues chains */
    stage_set focus[PROGRAM_QUEUES]; /* of the queue's last access or second scope */
    uint32_t queue, command, memories;
    uint64_t numbers[PROGRAM_QUEUES];
    uint64_t known[PROGRAM_QUEUES]; /* what the host has observed */
    /* of the last batch of each queue; and the least that any batch to come may have completed */
    uint64_t before[PROGRAM_QUEUES][PROGRAM_QUEUES], completed[PROGRAM_QUEUES][PROGRAM_QUEUES];
    uint64_t pruned[PROGRAM_QUEUES];
    /* of all batches; each covers itself */
    uint64_t clocks[GENERATED_BATCHES][PROGRAM_QUEUES];
    uint32_t batch_queues[GENERATED_BATCHES];
    uint32_t batch_count, signal_count;
    struct generated_signal signals[GENERATED_SIGNALS];
    uint64_t values[PROGRAM_SEMAPHORES];
    stage_set event_stages[PROGRAM_QUEUES][PROGRAM_EVENTS]; /* 0: not set */
};

static uint32_t below(struct generator *generator, uint32_t count)
{
    return random_below(&generator->random, count);
}

static bool one_in(struct generator *generator, uint32_t times)
{
    return random_one_in(&generator->random, times);
}

static void join(uint64_t *clock, const uint64_t *other)
{
    for (uint32_t i = 0; i < PROGRAM_QUEUES; i++)
        if (clock[i] < other[i])
            clock[i] = other[i];
}

static struct step *add_step(struct generator *generator, enum step_type type)
{
    struct step *step = &generator->program->steps[generator->program->count++];
    memset(step, 0, sizeof(*step));
    step->type = type;
    return step;
}

/* ---- scopes */

static uint32_t random_bit(struct generator *generator, uint32_t bits)
{
    uint32_t bit;
    do
        bit = 1u << below(generator, 32);
    while (!(bits & bit));
    return bit;
}

static stage_set random_stages(struct generator *generator)
{
    if (one_in(generator, 5))
        return ALL_SYNC_STAGES;
    stage_set stages = random_bit(generator, generator->stages);
    while (one_in(generator, 2))
        stages |= random_bit(generator, generator->stages);
    return stages;
}

/* Often the scope continues a chain. */
static stage_set random_src(struct generator *generator)
{
    stage_set focus = generator->focus[generator->queue] & generator->stages;
    if (!focus || one_in(generator, 3))
        return random_stages(generator);
    return random_bit(generator, focus) | (one_in(generator, 3) ? random_stages(generator) : 0);
}

static stage_set random_dst(struct generator *generator)
{
    return generator->focus[generator->queue] = random_stages(generator);
}

static kind_set kinds_at(stage_set stages)
{
    kind_set kinds = 0;
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (stages >> access_stage((enum access_kind)kind) & 1)
            kinds |= 1u << kind;
    return kinds;
}

static kind_set random_kinds(struct generator *generator, stage_set stages)
{
    kind_set kinds = kinds_at(stages);
    if (one_in(generator, 8))
        return 0;
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (one_in(generator, 5))
            kinds &= ~(1u << kind);
    return kinds;
}

static struct hazard_bytes random_bytes(struct generator *generator)
{
    uint64_t memory = 1 + below(generator, generator->memories);
    if (one_in(generator, 3))
        return (struct hazard_bytes){memory, 0, PROGRAM_BYTES};
    uint64_t begin = below(generator, PROGRAM_BYTES);
    uint64_t end = begin + 1 + below(generator, PROGRAM_BYTES - (uint32_t)begin);
    return (struct hazard_bytes){memory, begin, end};
}

static struct hazard_barrier random_barrier(struct generator *generator, stage_set src)
{
    struct hazard_barrier barrier = {.is_global = below(generator, 9) < 5,
                                     .bytes = random_bytes(generator)};
    barrier.dependency.src = src;
    barrier.dependency.dst = random_dst(generator);
    barrier.dependency.src_kinds = random_kinds(generator, src);
    barrier.dependency.dst_kinds = random_kinds(generator, barrier.dependency.dst);
    if (one_in(generator, 8)) {
        barrier.is_acquisition = true;
        barrier.dependency.src_kinds = 0;
    } else if (one_in(generator, 8)) {
        barrier.dependency.dst_kinds = 0; /* a release */
    }
    if (one_in(generator, 16))
        barrier.bytes.end = barrier.bytes.begin; /* an image barrier */
    return barrier;
}

static void add_barriers(struct generator *generator)
{
    struct step *step = add_step(generator, STEP_BARRIERS);
    stage_set src[PROGRAM_BARRIERS];
    for (uint32_t i = 0; i < PROGRAM_BARRIERS; i++)
        src[i] = random_src(generator);
    do {
        uint32_t i = step->barrier_count++;
        step->barriers[i] = random_barrier(generator, src[i]);
    } while (step->barrier_count < PROGRAM_BARRIERS && one_in(generator, 3));
}

/* ---- commands */

static enum access_kind random_kind(struct generator *generator)
{
    const kind_set host = 1u << ACCESS_HOST_READ | 1u << ACCESS_HOST_WRITE;
    stage_set *focus = &generator->focus[generator->queue];
    enum access_kind kind = 0;
    for (uint32_t tries = 0; tries < 2; tries++) {
        kind = (enum access_kind)__builtin_ctz(
            random_bit(generator, generator->queue ? generator->kinds & ~host : host));
        if (*focus >> access_stage(kind) & 1)
            break;
    }
    *focus = 1u << access_stage(kind);
    return kind;
}

static void add_accesses(struct generator *generator)
{
    uint32_t left = COMMAND_ACCESSES;
    generator->command++;
    do {
        struct step *step = add_step(generator, STEP_ACCESS);
        step->command = generator->command;
        step->access.kind = random_kind(generator);
        step->access.bytes = random_bytes(generator);
        if (one_in(generator, 32))
            step->access.bytes.end = step->access.bytes.begin;
    } while (--left && one_in(generator, 3));
}

/* Events of one queue. A wait for that of another is not valid, and orders nothing. */
static void add_event(struct generator *generator)
{
    uint32_t queue = generator->queue;
    uint32_t event = below(generator, PROGRAM_EVENTS);
    if (one_in(generator, 16))
        queue = 1 + below(generator, generator->queue_count);
    stage_set *stages = &generator->event_stages[queue][event];
    uint32_t choice = below(generator, 6);
    struct step *step;
    if (choice < (*stages ? 4u : 1u)) { /* seldom for one that is not set */
        step = add_step(generator, STEP_WAIT_EVENT);
        do {
            /* vkCmdWaitEvents names the stages of all its events, vkCmdWaitEvents2 some of one. */
            stage_set src = *stages ? *stages : random_src(generator);
            if (one_in(generator, 3))
                src |= random_stages(generator);
            else if (one_in(generator, 3))
                src &= random_stages(generator);
            step->barriers[step->barrier_count++] = random_barrier(generator, src);
        } while (step->barrier_count < PROGRAM_BARRIERS && one_in(generator, 3));
    } else if (*stages && choice == 4) {
        step = add_step(generator, STEP_RESET_EVENT);
        *stages = 0;
    } else {
        step = add_step(generator, STEP_SET_EVENT);
        step->dependency.src = random_src(generator);
        if (!*stages)
            *stages = step->dependency.src;
    }
    step->object = queue * PROGRAM_EVENTS + event;
}

static void add_commands(struct generator *generator)
{
    for (uint32_t left = below(generator, BATCH_COMMANDS + 1); left; left--) {
        uint32_t choice = generator->queue ? below(generator, 20) : 0;
        if (choice < 9)
            add_accesses(generator);
        else if (choice < 14)
            add_barriers(generator);
        else
            add_event(generator);
    }
}

/* ---- batches */

static void add_wait(struct generator *generator, struct step *batch)
{
    if (!generator->signal_count)
        return;
    const struct generated_signal *signal =
        &generator->signals[below(generator, generator->signal_count)];
    struct step *step = add_step(generator, STEP_WAIT);
    step->object = signal->semaphore;
    step->value = signal->value - (signal->has_gap && one_in(generator, 2));
    step->dependency.dst = random_dst(generator);
    step->dependency.dst_kinds = kinds_at(step->dependency.dst);
    if (one_in(generator, 16))
        step->value = one_in(generator, 2) ? 0 : generator->values[step->object] + 1; /* unknown */
    else
        join(batch->before, signal->before);
}

static void add_signal(struct generator *generator, const uint64_t *clock)
{
    if (generator->signal_count == GENERATED_SIGNALS)
        return;
    struct generated_signal *signal = &generator->signals[generator->signal_count++];
    struct step *step = add_step(generator, STEP_SIGNAL);
    step->object = below(generator, PROGRAM_SEMAPHORES);
    signal->has_gap = one_in(generator, 2);
    step->value = generator->values[step->object] += 1 + signal->has_gap;
    step->dependency.src = random_src(generator);
    step->dependency.src_kinds = kinds_at(step->dependency.src);
    signal->semaphore = step->object;
    signal->value = step->value;
    memcpy(signal->before, clock, sizeof(signal->before));
}

/* The host observes that a batch has completed, and may conclude that those before it have. */
static void observe(struct generator *generator)
{
    if (!generator->batch_count || !one_in(generator, 6))
        return;
    uint32_t batch = below(generator, generator->batch_count);
    uint64_t alone[PROGRAM_QUEUES] = {0};
    uint32_t queue = generator->batch_queues[batch];
    alone[queue] = generator->clocks[batch][queue];
    join(generator->known, one_in(generator, 2) ? alone : generator->clocks[batch]);
}

static void forget(struct generator *generator)
{
    uint32_t choice = below(generator, 32);
    if (choice == 0) {
        struct step *step = add_step(generator, STEP_PRUNE);
        memcpy(step->completed, generator->known, sizeof(step->completed));
        join(generator->pruned, generator->known);
    } else if (choice == 1) {
        struct step *step = add_step(generator, STEP_FORGET_MEMORY);
        step->object = 1 + below(generator, generator->memories);
    }
}

static struct step *begin_batch(struct generator *generator, uint32_t queue)
{
    struct step *step = add_step(generator, STEP_BATCH);
    generator->numbers[queue] += 1 + one_in(generator, 4);
    step->queue = generator->queue = queue;
    step->number = generator->numbers[queue];
    step->is_certain = !one_in(generator, 24);
    /* It may have been submitted before the host observed what it knows by now. */
    if (one_in(generator, 2))
        join(generator->completed[queue], generator->known);
    join(generator->completed[queue], generator->pruned);
    memcpy(step->completed, generator->completed[queue], sizeof(step->completed));
    join(step->before, step->completed);
    if (queue || one_in(generator, 2))
        join(step->before, generator->before[queue]);
    return step;
}

static void add_batch(struct generator *generator)
{
    uint32_t queue = generator->has_host && one_in(generator, 4)
                         ? 0
                         : 1 + below(generator, generator->queue_count);
    observe(generator);
    forget(generator);
    struct step *batch = begin_batch(generator, queue);
    for (uint32_t waits = queue ? below(generator, 3) : 0; waits; waits--)
        add_wait(generator, batch);
    add_commands(generator);
    generator->batch_queues[generator->batch_count] = queue;
    uint64_t *clock = generator->clocks[generator->batch_count++];
    memcpy(clock, batch->before, sizeof(batch->before));
    clock[queue] = batch->number;
    memcpy(generator->before[queue], clock, sizeof(batch->before));
    for (uint32_t signals = below(generator, 5) / 2; signals; signals--)
        add_signal(generator, clock);
}

static void choose_scopes(struct generator *generator)
{
    static const enum access_kind kinds[] = {
        ACCESS_BUILD_ACCEL_READ, ACCESS_BUILD_ACCEL_WRITE, ACCESS_BUILD_SHADER_READ,
        ACCESS_COPY_ACCEL_READ,  ACCESS_COPY_ACCEL_WRITE,  ACCESS_TRANSFER_READ,
        ACCESS_TRANSFER_WRITE,   ACCESS_FILL_WRITE,        ACCESS_MICROMAP_WRITE,
    };
    /* Few kinds, so that dependencies often fit. */
    generator->kinds =
        1u << (one_in(generator, 2) ? ACCESS_BUILD_ACCEL_WRITE : ACCESS_TRANSFER_WRITE);
    for (uint32_t count = 1 + below(generator, 4); count; count--)
        generator->kinds |= 1u << kinds[below(generator, sizeof(kinds) / sizeof(kinds[0]))];
    if (generator->has_host)
        generator->kinds |= 1u << ACCESS_HOST_READ | 1u << ACCESS_HOST_WRITE;
    generator->stages = one_in(generator, 2) ? 1u << SYNC_COMPUTE_SHADER : 0;
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (generator->kinds >> kind & 1)
            generator->stages |= 1u << access_stage((enum access_kind)kind);
}

void program_generate(struct program *program, uint64_t seed)
{
    struct generator generator = {.random = {seed}, .program = program};
    program->seed = seed;
    program->count = 0;
    generator.has_host = one_in(&generator, 4);
    generator.queue_count = one_in(&generator, 4) ? 1 + below(&generator, 3) : 2;
    generator.memories = one_in(&generator, 8) ? 2 : 1;
    choose_scopes(&generator);
    uint32_t length = 10 + below(&generator, 30);
    while (program->count < length && program->count < PROGRAM_STEPS - LONGEST_BATCH &&
           generator.batch_count < GENERATED_BATCHES)
        add_batch(&generator);
}
