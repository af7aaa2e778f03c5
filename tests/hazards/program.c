/* SPDX-License-Identifier: Apache-2.0 */
#include "program.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- findings */

void findings_add(struct findings *findings, const struct finding *first, uint64_t end)
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

void findings_sort(struct findings *findings)
{
    uint32_t kept = 0;
    qsort(findings->rows, findings->count, sizeof(findings->rows[0]), compare_findings);
    for (uint32_t i = 0; i < findings->count; i++)
        if (!kept || compare_findings(&findings->rows[kept - 1], &findings->rows[i]))
            findings->rows[kept++] = findings->rows[i];
    findings->count = kept;
}

bool findings_equal(const struct findings *a, const struct findings *b)
{
    return a->count == b->count && !memcmp(a->rows, b->rows, a->count * sizeof(a->rows[0]));
}

void findings_print(const char *title, const struct findings *findings)
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

void program_play(const struct program *program, struct findings *findings)
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

void program_print(const struct program *program)
{
    printf("program of seed %" PRIu64 ":\n", program->seed);
    for (uint32_t i = 0; i < program->count; i++) {
        printf("%3u ", i);
        print_step(&program->steps[i]);
    }
}

void program_remove(struct program *program, uint32_t step)
{
    uint32_t end = step + 1;
    while (program->steps[step].type == STEP_BATCH && end < program->count &&
           program->steps[end].type != STEP_BATCH)
        end++;
    memmove(&program->steps[step], &program->steps[end],
            (program->count - end) * sizeof(program->steps[0]));
    program->count -= end - step;
}
