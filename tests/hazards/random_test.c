/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs: the hazard check finds what the model finds, byte by byte. A program that
 * differs is shrunk and printed; ASSAY_TEST_SEED with its seed repeats it. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/hazards/hazards.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

/* ---- small programs of batches, accesses and dependencies for src/hazards/hazards.h, and what is
 * found in them. A program is an array of steps, so that the test can remove one and play the rest.
 */

enum {
    PROGRAM_QUEUES = 4, /* the host, and three queues */
    PROGRAM_STEPS = 64,
    PROGRAM_BARRIERS = 3, /* of one command */
    PROGRAM_BYTES = 4,    /* of each memory */
    PROGRAM_SEMAPHORES = 2,
    PROGRAM_EVENTS = 2,
    PROGRAM_FINDINGS = 2048,
};

/* A prune and STEP_FORGET_MEMORY end the batch; all others but STEP_BATCH belong to it. */
enum step_type {
    STEP_BATCH,
    STEP_WAIT,
    STEP_SIGNAL,
    STEP_ACCESS,
    STEP_BARRIERS,
    STEP_SET_EVENT,
    STEP_RESET_EVENT,
    STEP_WAIT_EVENT,
    STEP_PRUNE,
    STEP_FORGET_MEMORY,
};

struct step {
    enum step_type type;
    /* STEP_BATCH, and `completed` of STEP_PRUNE: as in struct hazard_batch */
    uint32_t queue;
    uint64_t number, completed[PROGRAM_QUEUES], before[PROGRAM_QUEUES];
    bool is_certain;
    /* a semaphore, an event or a memory; the value of a semaphore */
    uint64_t object, value;
    struct dependency dependency; /* dst of a wait; src of a signal and of a set event */
    struct hazard_access access;
    uint32_t command; /* of the access; the next number begins a command */
    struct hazard_barrier barriers[PROGRAM_BARRIERS];
    uint32_t barrier_count;
};

struct program {
    uint64_t seed;
    struct step steps[PROGRAM_STEPS];
    uint32_t count;
};

/* One byte of one hazard. Accesses are named by the index of their step. */
struct finding {
    uint8_t earlier, later, memory, byte, type, is_racing, is_ordered, is_available;
};

struct findings {
    struct finding rows[PROGRAM_FINDINGS];
    uint32_t count;
};

/* ---- findings */

/* Adds a finding for each of the bytes. */
static void findings_add(struct findings *findings, const struct finding *first, uint64_t end)
{
    for (uint64_t byte = first->byte; byte < end; byte++) {
        if (findings->count == PROGRAM_FINDINGS)
            abort();
        findings->rows[findings->count] = *first;
        findings->rows[findings->count++].byte = (uint8_t)byte;
    }
}

static int compare_findings(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(struct finding));
}

/* Sorts, and drops duplicates. */
static void findings_sort(struct findings *findings)
{
    uint32_t kept = 0;
    qsort(findings->rows, findings->count, sizeof(findings->rows[0]), compare_findings);
    for (uint32_t i = 0; i < findings->count; i++)
        if (!kept || compare_findings(&findings->rows[kept - 1], &findings->rows[i]))
            findings->rows[kept++] = findings->rows[i];
    findings->count = kept;
}

static bool findings_equal(const struct findings *a, const struct findings *b)
{
    return a->count == b->count && !memcmp(a->rows, b->rows, a->count * sizeof(a->rows[0]));
}

static void findings_print(const char *title, const struct findings *findings)
{
    static const char *const types[] = {"read after write", "write after read",
                                        "write after write"};
    printf("%s: %u\n", title, findings->count);
    for (uint32_t i = 0; i < findings->count; i++) {
        const struct finding *row = &findings->rows[i];
        printf("  %u -> %u, memory %u byte %u: %s%s%s%s\n", row->earlier, row->later, row->memory,
               row->byte, types[row->type], row->is_racing ? ", racing" : "",
               row->is_ordered ? ", ordered" : "", row->is_available ? ", available" : "");
    }
}

/* ---- playing */

struct player {
    struct hazards *hazards;
    const struct program *program;
    struct findings *findings;
    uint64_t numbers[PROGRAM_STEPS]; /* of accesses */
    uint32_t queues[PROGRAM_STEPS];
    uint64_t last_number;
    const struct step *batch;
    uint32_t step, command;
    const struct step *signals[PROGRAM_STEPS]; /* so far */
    uint32_t signal_count;
};

/* The step of the access, or one beyond the program if it is described wrongly. The number of the
 * access that is being added is not known yet: it has no entry. */
static uint8_t find_step(const struct player *player, const struct hazard_side *side, bool is_later)
{
    const struct step *steps = player->program->steps;
    uint32_t step = is_later ? player->step : 0;
    while (!is_later && step < player->step && player->numbers[step] != side->number)
        step++;
    bool is_right = steps[step].type == STEP_ACCESS && steps[step].access.kind == side->kind &&
                    (is_later ? player->batch->queue : player->queues[step]) == side->queue;
    return is_right ? (uint8_t)step : PROGRAM_STEPS;
}

static void note_hazard(void *user, const struct hazard *hazard)
{
    struct player *player = user;
    struct finding finding = {
        find_step(player, &hazard->earlier, false),
        find_step(player, &hazard->later, true),
        (uint8_t)hazard->bytes.memory,
        (uint8_t)hazard->bytes.begin,
        (uint8_t)hazard->type,
        hazard->is_racing,
        hazard->is_ordered,
        hazard->type != WRITE_AFTER_READ && hazard->is_available,
    };
    if (hazard->later.number <= player->last_number)
        finding.later = PROGRAM_STEPS;
    findings_add(player->findings, &finding, hazard->bytes.end);
}

static void play_access(struct player *player, const struct step *step)
{
    if (step->command != player->command)
        hazards_begin_command(player->hazards);
    player->command = step->command;
    uint64_t number = hazards_access(player->hazards, &step->access);
    if (number <= player->last_number)
        abort();
    player->last_number = player->numbers[player->step] = number;
    player->queues[player->step] = player->batch->queue;
}

static void end_batch(struct player *player)
{
    if (player->batch)
        hazards_end_batch(player->hazards);
    player->batch = NULL;
}

static void begin_batch(struct player *player, const struct step *step)
{
    struct hazard_batch batch = {step->queue,  step->number,   step->completed,
                                 step->before, PROGRAM_QUEUES, step->is_certain};
    end_batch(player);
    hazards_begin_batch(player->hazards, &batch);
    player->batch = step;
}

/* Signals are numbered by their steps. */
static uint64_t number_of(const struct player *player, const struct step *signal)
{
    return signal ? (uint64_t)(signal - player->program->steps) + 1 : 0;
}

static void play_wait(const struct player *player, const struct step *step)
{
    const struct step *end = NULL;
    for (uint32_t i = 0; i < player->signal_count && step->value; i++) {
        const struct step *signal = player->signals[i];
        if (signal->object == step->object && signal->value >= step->value &&
            (!end || signal->value < end->value))
            end = signal;
    }
    hazards_wait(player->hazards, number_of(player, end), &step->dependency);
}

static void play_signal(struct player *player, const struct step *step)
{
    const struct step *previous = NULL;
    for (uint32_t i = 0; i < player->signal_count; i++) {
        const struct step *signal = player->signals[i];
        if (signal->object == step->object && signal->value < step->value &&
            (!previous || signal->value > previous->value))
            previous = signal;
    }
    player->signals[player->signal_count++] = step;
    hazards_signal(player->hazards, number_of(player, step), number_of(player, previous),
                   &step->dependency);
}

static void play_between_batches(struct player *player, const struct step *step)
{
    end_batch(player);
    if (step->type == STEP_PRUNE)
        hazards_prune(player->hazards, step->completed, PROGRAM_QUEUES);
    else
        hazards_forget_memory(player->hazards, step->object);
}

static void play_step(struct player *player, const struct step *step)
{
    struct hazards *hazards = player->hazards;
    switch (step->type) {
    case STEP_BATCH:
        begin_batch(player, step);
        return;
    case STEP_WAIT:
        play_wait(player, step);
        return;
    case STEP_SIGNAL:
        play_signal(player, step);
        return;
    case STEP_ACCESS:
        play_access(player, step);
        return;
    case STEP_BARRIERS:
        hazards_barriers(hazards, step->barriers, step->barrier_count);
        return;
    case STEP_SET_EVENT:
        hazards_set_event(hazards, step->object, step->dependency.src);
        return;
    case STEP_RESET_EVENT:
        hazards_reset_event(hazards, step->object);
        return;
    case STEP_WAIT_EVENT:
        hazards_wait_event(hazards, step->object, step->barriers, step->barrier_count);
        return;
    default:
        play_between_batches(player, step);
    }
}

/* What the hazard check finds. The result is sorted. */
static void program_play(const struct program *program, struct findings *findings)
{
    struct player player = {.program = program, .findings = findings};
    player.hazards = hazards_create(note_hazard, &player);
    findings->count = 0;
    for (player.step = 0; player.step < program->count; player.step++)
        play_step(&player, &program->steps[player.step]);
    end_batch(&player);
    hazards_destroy(player.hazards);
    findings_sort(findings);
}

/* ---- printing */

static const char *const kind_names[ACCESS_KINDS] = {
    "build_accel_read",     "build_accel_write",   "build_shader_read", "build_indirect",
    "build_micromap_read",  "accel_copy_read",     "accel_copy_write",  "accel_transfer_read",
    "accel_transfer_write", "transfer_read",       "transfer_write",    "fill_write",
    "marker_write",         "micromap_read",       "micromap_write",    "micromap_shader_read",
    "micromap_copy_read",   "micromap_copy_write", "host_read",         "host_write",
    "compute_trace",        "rays_trace",          "compute_write",     "rays_write",
    "graphics_write",
};

/* The names of the bits; the others as a number. */
static void print_set(uint32_t set, const char *const *names, uint32_t count)
{
    uint32_t printed = 0;
    for (uint32_t i = 0; i < count; i++)
        if (set >> i & 1)
            printf("%s%s", printed++ ? "|" : "", names[i]);
    if (!printed || set >> count)
        printf("%s0x%" PRIx32, printed ? "|" : "", set >> count << count);
}

static void print_kinds(kind_set kinds)
{
    print_set(kinds, kind_names, ACCESS_KINDS);
}

static void print_stages(stage_set stages)
{
    static const char *const names[] = {"build", "accel_copy", "copy", "fill",         "micromap",
                                        "host",  "compute",    "rays", "draw_indirect"};
    if (stages == ALL_SYNC_STAGES)
        printf("all");
    else
        print_set(stages, names, SYNC_ACCESS_STAGES);
}

static void print_bytes(const struct hazard_bytes *bytes)
{
    printf(" memory %" PRIu64 " [%" PRIu64 ", %" PRIu64 ")", bytes->memory, bytes->begin,
           bytes->end);
}

static void print_barrier(const struct hazard_barrier *barrier)
{
    printf("\n      ");
    print_stages(barrier->dependency.src);
    printf(" ");
    print_kinds(barrier->dependency.src_kinds);
    printf(" -> ");
    print_stages(barrier->dependency.dst);
    printf(" ");
    print_kinds(barrier->dependency.dst_kinds);
    if (barrier->is_global)
        printf(" global");
    else
        print_bytes(&barrier->bytes);
    printf("%s", barrier->is_acquisition ? " acquisition" : "");
}

static void print_counts(const char *name, const uint64_t *counts)
{
    printf(" %s", name);
    for (uint32_t i = 0; i < PROGRAM_QUEUES; i++)
        printf(" %" PRIu64, counts[i]);
}

static void print_step(const struct step *step)
{
    static const char *const names[] = {"batch",      "  wait",       "  signal", "  access",
                                        "  barriers", "  set",        "  reset",  "  wait event",
                                        "prune",      "forget memory"};
    printf("%s", names[step->type]);
    if (step->type == STEP_BATCH) {
        printf(" queue %u number %" PRIu64, step->queue, step->number);
        print_counts("before", step->before);
        printf("%s", step->is_certain ? "" : " uncertain");
    }
    if (step->type == STEP_BATCH || step->type == STEP_PRUNE)
        print_counts("completed", step->completed);
    else if (step->type == STEP_ACCESS)
        printf(" %s of command %u", kind_names[step->access.kind], step->command);
    else if (step->type != STEP_BARRIERS)
        printf(" object %" PRIu64 " value %" PRIu64 " ", step->object, step->value);
    if (step->type == STEP_ACCESS)
        print_bytes(&step->access.bytes);
    if (step->type == STEP_SIGNAL || step->type == STEP_SET_EVENT)
        print_stages(step->dependency.src);
    if (step->type == STEP_WAIT)
        print_stages(step->dependency.dst);
    for (uint32_t i = 0; i < step->barrier_count; i++)
        print_barrier(&step->barriers[i]);
    printf("\n");
}

static void program_print(const struct program *program)
{
    printf("program of seed %" PRIu64 ":\n", program->seed);
    for (uint32_t i = 0; i < program->count; i++) {
        printf("%3u ", i);
        print_step(&program->steps[i]);
    }
}

/* Removes a step. With a batch, all its steps go. */
static void program_remove(struct program *program, uint32_t step)
{
    uint32_t end = step + 1;
    while (program->steps[step].type == STEP_BATCH && end < program->count &&
           program->steps[end].type != STEP_BATCH)
        end++;
    memmove(&program->steps[step], &program->steps[end],
            (program->count - end) * sizeof(program->steps[0]));
    program->count -= end - step;
}

/* ---- random programs */

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

static void generate_barriers(struct generator *generator)
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
            generate_barriers(generator);
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

static void generate_signal(struct generator *generator, const uint64_t *clock)
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

static struct step *generate_batch(struct generator *generator, uint32_t queue)
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
    struct step *batch = generate_batch(generator, queue);
    for (uint32_t waits = queue ? below(generator, 3) : 0; waits; waits--)
        add_wait(generator, batch);
    add_commands(generator);
    generator->batch_queues[generator->batch_count] = queue;
    uint64_t *clock = generator->clocks[generator->batch_count++];
    memcpy(clock, batch->before, sizeof(batch->before));
    clock[queue] = batch->number;
    memcpy(generator->before[queue], clock, sizeof(batch->before));
    for (uint32_t signals = below(generator, 5) / 2; signals; signals--)
        generate_signal(generator, clock);
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

/* The program of a seed: 10 to 40 steps. */
static void program_generate(struct program *program, uint64_t seed)
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

/* ---- the model */

/* A model of the hazard check, as close to the specification's definitions as can be (chapter
 * Synchronization and Cache Control, Execution and Memory Dependencies).
 *
 * It lists all accesses and all dependencies. For each byte of each access it computes which
 * dependencies the access happens before, by the definition of execution dependency chains, and
 * whether it is available there. It judges one byte at a time, so a buffer barrier is a barrier
 * with access scopes for some bytes and without for others. */
enum { MODEL_LINKS = PROGRAM_STEPS * 16, MODEL_SIGNALS = PROGRAM_STEPS };

/* How far an access has come when a dependency is through. VISIBLE: to all accesses. */
enum reach { NOT_REACHED, ORDERED, AVAILABLE, VISIBLE };

struct access {
    const struct hazard_access *is;
    uint32_t step, command, queue;
    uint64_t batch;
};

/* One dependency: from what a queue executed before a step, to what a queue executes after one. */
struct link {
    struct hazard_barrier barrier;
    /* Semaphores and host waits: their access scopes include all memory access of the device,
     * whatever the stages. */
    bool is_full;
    uint32_t from_queue, from_step, to_queue, to_step;
};

/* A signal of a semaphore or of an event. */
struct signal {
    bool is_event, is_reset;
    uint64_t object, value;
    uint32_t queue, step, batch; /* batch: its step */
    const struct dependency *src;
};

struct model {
    struct access accesses[PROGRAM_STEPS];
    struct link links[MODEL_LINKS];
    struct signal signals[MODEL_SIGNALS];
    uint32_t access_count, link_count, signal_count;
    /* of a byte of an access, when a link is through */
    uint8_t reached[PROGRAM_STEPS][PROGRAM_BYTES][MODEL_LINKS];
    const struct program *program;
    const struct step *batch;
    struct findings *findings;
};

static bool bytes_contain(const struct hazard_bytes *bytes, uint64_t memory, uint64_t byte)
{
    return bytes->memory == memory && bytes->begin <= byte && byte < bytes->end;
}

static bool barrier_holds(const struct hazard_barrier *barrier, uint64_t memory, uint64_t byte)
{
    return barrier->is_global || bytes_contain(&barrier->bytes, memory, byte);
}

static bool has_stage(stage_set stages, enum access_kind kind)
{
    return stages >> access_stage(kind) & 1;
}

static bool has_kind(kind_set kinds, enum access_kind kind)
{
    return kinds >> kind & 1;
}

/* ---- dependencies */

/* The first access scope of a chain is that of its first dependency: only an access that is
 * directly in a dependency's first scope is made available by it. */
static enum reach direct_reach(const struct access *access, uint64_t byte, const struct link *link)
{
    const struct dependency *dependency = &link->barrier.dependency;
    if (access->queue != link->from_queue || access->step >= link->from_step ||
        !has_stage(dependency->src, access->is->kind))
        return NOT_REACHED;
    bool is_available = has_kind(dependency->src_kinds, access->is->kind) &&
                        barrier_holds(&link->barrier, access->is->bytes.memory, byte);
    return is_available ? AVAILABLE : ORDERED;
}

/* A chain exists if the second scope of one dependency and the first scope of the next intersect.
 */
static bool is_continued(const struct link *first, const struct link *next)
{
    return first->to_queue == next->from_queue && first->to_step < next->from_step &&
           (first->barrier.dependency.dst & next->barrier.dependency.src);
}

static enum reach reach_of(const struct model *model, uint32_t access, uint64_t byte,
                           const struct link *link)
{
    enum reach reach = direct_reach(&model->accesses[access], byte, link);
    for (uint32_t i = 0; i < model->link_count && reach < VISIBLE; i++)
        if (model->reached[access][byte][i] > reach && is_continued(&model->links[i], link))
            reach = model->reached[access][byte][i];
    if (reach && link->is_full)
        return VISIBLE;
    if (reach == ORDERED && link->barrier.is_acquisition &&
        barrier_holds(&link->barrier, model->accesses[access].is->bytes.memory, byte))
        return AVAILABLE;
    return reach;
}

/* Links are added in the order of their ends, so all that may precede one are there. */
static void add_link(struct model *model, const struct link *link)
{
    if (model->link_count == MODEL_LINKS)
        abort();
    for (uint32_t access = 0; access < model->access_count; access++)
        for (uint64_t byte = 0; byte < PROGRAM_BYTES; byte++)
            model->reached[access][byte][model->link_count] =
                (uint8_t)reach_of(model, access, byte, link);
    model->links[model->link_count++] = *link;
}

static void note_barriers(struct model *model, const struct step *step, uint32_t from_step,
                          const struct dependency *src)
{
    uint32_t here = (uint32_t)(step - model->program->steps);
    for (uint32_t i = 0; i < step->barrier_count; i++) {
        struct link link = {step->barriers[i],   false, model->batch->queue, from_step,
                            model->batch->queue, here};
        if (src)
            link.barrier.dependency.src = src->src;
        add_link(model, &link);
    }
}

/* The first step of the queue that is in none of its completed batches. */
static uint32_t completed_end(const struct model *model, uint32_t queue, uint64_t completed)
{
    uint32_t here = (uint32_t)(model->batch - model->program->steps), step = 0;
    for (; step < here; step++) {
        const struct step *batch = &model->program->steps[step];
        if (batch->type == STEP_BATCH && batch->queue == queue && batch->number > completed)
            break;
    }
    return step;
}

/* All that a queue has executed before `end` happens before this step. */
static void order_all(struct model *model, uint32_t queue, uint32_t end, const struct step *step)
{
    const uint32_t here = (uint32_t)(step - model->program->steps);
    add_link(
        model,
        &(struct link){
            {{ALL_SYNC_STAGES, ALL_SYNC_STAGES}}, true, queue, end, model->batch->queue, here});
}

static void order_everything(struct model *model, const struct step *step)
{
    for (uint32_t queue = 0; queue < PROGRAM_QUEUES; queue++)
        order_all(model, queue, (uint32_t)(step - model->program->steps), step);
}

static void note_batch(struct model *model, const struct step *step)
{
    model->batch = step;
    if (!step->is_certain)
        order_everything(model, step);
    for (uint32_t queue = 0; queue < PROGRAM_QUEUES && step->is_certain; queue++)
        if (step->completed[queue])
            order_all(model, queue, completed_end(model, queue, step->completed[queue]), step);
}

/* ---- semaphores */

static void note_signal(struct model *model, const struct step *step, bool is_event)
{
    const struct step *steps = model->program->steps;
    model->signals[model->signal_count++] = (struct signal){is_event,
                                                            false,
                                                            step->object,
                                                            step->value,
                                                            model->batch->queue,
                                                            (uint32_t)(step - steps),
                                                            (uint32_t)(model->batch - steps),
                                                            &step->dependency};
}

/* The first scope of a signal has the signals of the queue's earlier batches (signal operation
 * order). Signals with smaller values of the semaphore happen before it, too. */
static bool is_signalled_before(const struct signal *first, const struct signal *second)
{
    return first->step < second->step && !first->is_event &&
           ((first->queue == second->queue && first->batch != second->batch) ||
            (first->object == second->object && first->value < second->value));
}

static const struct signal *find_semaphore(const struct model *model, uint64_t semaphore,
                                           uint64_t value)
{
    const struct signal *found = NULL;
    for (uint32_t i = 0; i < model->signal_count; i++) {
        const struct signal *signal = &model->signals[i];
        if (!signal->is_event && signal->object == semaphore && signal->value >= value &&
            (!found || signal->value < found->value))
            found = signal;
    }
    return value ? found : NULL;
}

/* A wait for an unknown signal may follow anything. */
static void wait_semaphore(struct model *model, const struct step *step)
{
    const struct signal *waited = find_semaphore(model, step->object, step->value);
    bool is_before[MODEL_SIGNALS] = {false};
    if (!waited)
        order_everything(model, step);
    for (uint32_t i = model->signal_count; waited && i--;) {
        const struct signal *signal = &model->signals[i];
        is_before[i] = signal == waited;
        for (uint32_t later = i + 1; later < model->signal_count; later++)
            is_before[i] |= is_before[later] && is_signalled_before(signal, &model->signals[later]);
        if (!is_before[i])
            continue;
        struct link link = {{{signal->src->src, step->dependency.dst}},
                            true,
                            signal->queue,
                            signal->step,
                            model->batch->queue,
                            (uint32_t)(step - model->program->steps)};
        add_link(model, &link);
    }
}

/* ---- events */

/* vkCmdSetEvent has no effect on an event that is set. But programs do not describe what the host
 * resets (vkResetEvent): so an event that is set twice has both first scopes. */
static void step_event(struct model *model, const struct step *step)
{
    for (uint32_t i = 0; i < model->signal_count; i++) {
        struct signal *event = &model->signals[i];
        if (!event->is_event || event->is_reset || event->object != step->object)
            continue;
        if (step->type == STEP_RESET_EVENT ||
            (step->type == STEP_SET_EVENT && event->queue != model->batch->queue))
            event->is_reset = true;
        else if (step->type == STEP_WAIT_EVENT && event->queue == model->batch->queue)
            note_barriers(model, step, event->step, event->src);
    }
    if (step->type == STEP_SET_EVENT)
        note_signal(model, step, true);
}

/* ---- accesses */

struct order {
    bool is_ordered, is_available, is_visible;
};

static struct order order_of(const struct model *model, uint32_t earlier,
                             const struct access *later, uint64_t byte)
{
    struct order order = {0};
    for (uint32_t i = 0; i < model->link_count; i++) {
        const struct link *link = &model->links[i];
        enum reach reach = model->reached[earlier][byte][i];
        if (!reach || link->to_queue != later->queue ||
            !has_stage(link->barrier.dependency.dst, later->is->kind))
            continue;
        order.is_ordered = true;
        if (reach < AVAILABLE)
            continue;
        order.is_available = true;
        if (reach == VISIBLE)
            order.is_visible = true;
        if (has_kind(link->barrier.dependency.dst_kinds, later->is->kind) &&
            barrier_holds(&link->barrier, later->is->bytes.memory, byte))
            order.is_visible = true;
    }
    return order;
}

static void compare(struct model *model, uint32_t index, const struct access *later, uint64_t byte)
{
    const struct access *earlier = &model->accesses[index];
    bool wrote = access_is_write(earlier->is->kind), writes = access_is_write(later->is->kind);
    struct order order = order_of(model, index, later, byte);
    if (earlier->is->kind == ACCESS_MARKER_WRITE && later->is->kind == ACCESS_MARKER_WRITE)
        return;
    if (wrote ? order.is_visible : order.is_ordered)
        return;
    /* Queues execute their batches in order; the host does not. */
    bool has_order =
        earlier->queue == later->queue && (later->queue || earlier->batch == model->batch->number);
    bool is_racing = !has_order && earlier->batch > model->batch->before[earlier->queue];
    struct finding finding = {
        (uint8_t)earlier->step,
        (uint8_t)later->step,
        (uint8_t)later->is->bytes.memory,
        (uint8_t)byte,
        !wrote   ? WRITE_AFTER_READ
        : writes ? WRITE_AFTER_WRITE
                 : READ_AFTER_WRITE,
        is_racing,
        order.is_ordered,
        wrote && order.is_available,
    };
    findings_add(model->findings, &finding, byte + 1);
}

/* Compares with the last write and, for a write, with the last read since then of each queue and
 * kind. Accesses of the same command are left out. */
static void find_hazards(struct model *model, const struct access *later, uint64_t byte)
{
    kind_set seen[PROGRAM_QUEUES] = {0};
    for (uint32_t i = model->access_count; i--;) {
        const struct access *earlier = &model->accesses[i];
        enum access_kind kind = earlier->is->kind;
        if (!bytes_contain(&earlier->is->bytes, later->is->bytes.memory, byte))
            continue;
        bool is_same = earlier->command == later->command;
        if (access_is_write(kind)) {
            if (!is_same)
                compare(model, i, later, byte);
            return;
        }
        if (!access_is_write(later->is->kind) || is_same || has_kind(seen[earlier->queue], kind))
            continue;
        seen[earlier->queue] |= 1u << kind;
        compare(model, i, later, byte);
    }
}

static void add_access(struct model *model, const struct step *step)
{
    uint32_t here = (uint32_t)(step - model->program->steps);
    struct access access = {&step->access, here, step->command, model->batch->queue,
                            model->batch->number};
    for (uint64_t byte = step->access.bytes.begin; byte < step->access.bytes.end; byte++)
        find_hazards(model, &access, byte);
    memset(model->reached[model->access_count], NOT_REACHED, sizeof(model->reached[0]));
    model->accesses[model->access_count++] = access;
}

static void forget_memory(struct model *model, uint64_t memory)
{
    static const struct hazard_access none = {ACCESS_BUILD_ACCEL_READ, {0, 0, 0}};
    for (uint32_t i = 0; i < model->access_count; i++)
        if (model->accesses[i].is->bytes.memory == memory)
            model->accesses[i].is = &none;
}

/* What the program's hazards are. The result is sorted. */
static void model_play(const struct program *program, struct findings *findings)
{
    static struct model model;
    model.access_count = model.link_count = model.signal_count = findings->count = 0;
    model.program = program;
    model.findings = findings;
    for (uint32_t i = 0; i < program->count; i++) {
        const struct step *step = &program->steps[i];
        if (step->type == STEP_BATCH)
            note_batch(&model, step);
        else if (step->type == STEP_WAIT)
            wait_semaphore(&model, step);
        else if (step->type == STEP_SIGNAL)
            note_signal(&model, step, false);
        else if (step->type == STEP_ACCESS)
            add_access(&model, step);
        else if (step->type == STEP_BARRIERS)
            note_barriers(&model, step, i, NULL);
        else if (step->type == STEP_FORGET_MEMORY)
            forget_memory(&model, step->object);
        else
            step_event(&model, step);
    }
    findings_sort(findings);
}

/* ---- the test */

static bool differs(const struct program *program, struct findings *model, struct findings *engine)
{
    model_play(program, model);
    program_play(program, engine);
    return !findings_equal(model, engine);
}

/* Removes steps and barriers as long as the program differs. */
static void shrink(struct program *program)
{
    static struct findings model, engine;
    for (uint32_t i = program->count; i--;) {
        struct program smaller = *program;
        program_remove(&smaller, i);
        if (differs(&smaller, &model, &engine)) {
            *program = smaller;
            i = program->count;
            continue;
        }
        smaller = *program;
        if (smaller.steps[i].barrier_count > 1) {
            smaller.steps[i].barrier_count--;
            if (differs(&smaller, &model, &engine))
                *program = smaller;
        }
    }
}

/* Returns the number of findings. */
static uint32_t compare_verdicts(const struct program *program, struct findings *model)
{
    static struct findings engine;
    if (!differs(program, model, &engine))
        return model->count;
    struct program shrunk = *program;
    shrink(&shrunk);
    differs(&shrunk, model, &engine);
    program_print(&shrunk);
    findings_print("the model finds", model);
    findings_print("the check finds", &engine);
    fail_msg("they differ; ASSAY_TEST_SEED=%" PRIu64 " repeats it", program->seed);
    return 0;
}

TEST(random_programs_agree_with_the_model)
{
    static struct program program;
    static struct findings findings;
    uint64_t seed = random_of("hazards_random").state, count = 0, clean = 0;
    for (uint32_t i = 0; i < HAZARD_PROGRAMS; i++) {
        program_generate(&program, seed + i);
        uint32_t found = compare_verdicts(&program, &findings);
        count += found;
        clean += !found;
    }
    print_message("%u programs, %" PRIu64 " findings, %" PRIu64 " programs without\n",
                  HAZARD_PROGRAMS, count, clean);
}
