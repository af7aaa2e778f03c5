/* SPDX-License-Identifier: Apache-2.0 */
/* Sequences: made, run, read, reduced and printed. */
#include "tests/unit/property.h"

#include <inttypes.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "tests/fixture/scarce_memory.h"
#include "tests/unit/random.h"

#ifdef _WIN32
#define sigsetjmp(buffer, saves) setjmp(buffer)
#define siglongjmp longjmp
#define sigjmp_buf jmp_buf
#endif

enum { REDUCING_SECONDS = 20, STUCK_SECONDS = 20, TEXT_SIZE = 400 };

struct sequence {
    struct property_step *steps;
    size_t count;
};

/* The sequence that runs. */
static struct {
    sigjmp_buf failed;
    const struct property_step *step; /* NULL: after the last one */
    char text[TEXT_SIZE];             /* what has failed */
    bool is_reduced;
} now;

/* ---- failures */

static void fail_sequence(const char *file, int line)
{
    const size_t length = strlen(now.text);
    snprintf(now.text + length, sizeof(now.text) - length, " (%s:%d)", file, line);
    siglongjmp(now.failed, 1);
}

void property_expect(bool holds, const char *text, const char *file, int line)
{
    if (holds)
        return;
    snprintf(now.text, sizeof(now.text), "%s", text);
    fail_sequence(file, line);
}

void property_expect_equal(uint64_t a, uint64_t b, const char *text, const char *file, int line)
{
    if (a == b)
        return;
    snprintf(now.text, sizeof(now.text), "%s: %#" PRIx64 " and %#" PRIx64, text, a, b);
    fail_sequence(file, line);
}

/* A container that crashes, or loops for ever, fails like one that answers wrongly. */
static void fail_by_signal(int number)
{
    snprintf(now.text, sizeof(now.text), "signal %d", number);
    siglongjmp(now.failed, 1);
}

static void catch_signals(void (*handler)(int))
{
    static const int signals[] = {SIGSEGV, SIGABRT, SIGFPE,
#ifndef _WIN32
                                  SIGBUS, SIGALRM
#endif
    };
    for (size_t i = 0; i < sizeof(signals) / sizeof(signals[0]); i++)
        signal(signals[i], handler);
}

static void set_alarm(unsigned seconds)
{
#ifndef _WIN32
    alarm(seconds);
#endif
}

void property_begin_call(void)
{
#ifndef _WIN32 /* see memory_fail_after() */
    if (now.step && now.step->memory >= 0)
        memory_fail_after(now.step->memory);
#endif
}

bool property_end_call(void)
{
    return now.step && now.step->memory >= 0 && memory_fail_no_more();
}

/* ---- running */

static bool run(const struct property *property, const struct sequence *sequence)
{
    void *volatile state = calloc(1, property->size);
    volatile bool holds = false;
    assert_non_null(state);
    now.step = NULL;
    set_alarm(now.is_reduced ? 1 : STUCK_SECONDS);
    if (sigsetjmp(now.failed, 1) == 0) {
        if (property->begin)
            property->begin(state);
        for (size_t i = 0; i < sequence->count; i++) {
            now.step = &sequence->steps[i];
            property->operations[now.step->operation].apply(state, now.step->operands);
            if (property->check && (i + 1) % property->check_steps == 0)
                property->check(state);
        }
        now.step = NULL;
        if (property->check)
            property->check(state);
        if (property->end)
            property->end(state);
        holds = true;
    }
    set_alarm(0);
    memory_pause();
    free(state);
    return holds;
}

/* ---- text */

static const struct property_operation *operation_of(const struct property *property,
                                                     const char *name, size_t length)
{
    for (uint32_t i = 0; i < PROPERTY_OPERATIONS && property->operations[i].name; i++)
        if (strncmp(property->operations[i].name, name, length) == 0 &&
            !property->operations[i].name[length])
            return &property->operations[i];
    fail_msg("%s: no operation \"%.*s\"", property->name, (int)length, name);
    return NULL;
}

/* Reads a step, and returns the text after it. */
static const char *read_step(const struct property *property, const char *text,
                             struct property_step *step)
{
    const size_t length = strcspn(text, " ;");
    const struct property_operation *operation = operation_of(property, text, length);
    *step = (struct property_step){.operation = (uint32_t)(operation - property->operations),
                                   .memory = -1};
    text += length;
    for (uint32_t i = 0; *(text += strspn(text, " ")) && *text != ';';) {
        char *end;
        const bool is_memory = *text == '!';
        const unsigned long number = strtoul(text + is_memory, &end, 0);
        if (end == text + is_memory || (!is_memory && i == PROPERTY_OPERANDS))
            fail_msg("%s: no operand: %s", property->name, text);
        if (is_memory)
            step->memory = (int)number;
        else
            step->operands[i++] = (uint32_t)number;
        text = end;
    }
    return text + strspn(text, "; ");
}

static struct sequence read_sequence(const struct property *property, const char *text)
{
    struct sequence sequence = {.steps = calloc(strlen(text) + 1, sizeof(*sequence.steps))};
    assert_non_null(sequence.steps);
    while (*text)
        text = read_step(property, text, &sequence.steps[sequence.count++]);
    return sequence;
}

static void print_sequence(const struct property *property, const struct sequence *sequence)
{
    printf("ASSAY_TEST_STEPS=\"%s:", property->name);
    for (size_t i = 0; i < sequence->count; i++) {
        const struct property_step *step = &sequence->steps[i];
        const struct property_operation *operation = &property->operations[step->operation];
        printf("%s %s", i ? ";" : "", operation->name);
        for (uint32_t j = 0; j < PROPERTY_OPERANDS && operation->bounds[j]; j++)
            printf(" %" PRIu32, step->operands[j]);
        if (step->memory >= 0)
            printf(" !%d", step->memory);
    }
    printf("\"\n");
    fflush(stdout);
}

/* ---- reducing */

static bool is_time_left(time_t start)
{
    return time(NULL) - start < REDUCING_SECONDS;
}

/* Removes steps, first many at once. */
static void remove_steps(const struct property *property, struct sequence *sequence, time_t start)
{
    struct property_step *kept = malloc((sequence->count + 1) * sizeof(*kept));
    assert_non_null(kept);
    for (size_t size = sequence->count; size; size = size > 1 ? (size + 1) / 2 : 0)
        for (size_t i = sequence->count; i && is_time_left(start);) {
            const size_t from = i > size ? i - size : 0;
            const struct sequence shorter = {kept, sequence->count - (i - from)};
            memcpy(kept, sequence->steps, from * sizeof(*kept));
            memcpy(kept + from, sequence->steps + i, (sequence->count - i) * sizeof(*kept));
            if (!run(property, &shorter)) {
                memcpy(sequence->steps, kept, shorter.count * sizeof(*kept));
                sequence->count = shorter.count;
            }
            i = from;
        }
    free(kept);
}

static void reduce_operands(const struct property *property, struct sequence *sequence,
                            time_t start)
{
    for (size_t i = 0; i < sequence->count; i++) {
        const int memory = sequence->steps[i].memory;
        sequence->steps[i].memory = -1;
        if (memory >= 0 && (!is_time_left(start) || run(property, sequence)))
            sequence->steps[i].memory = memory;
        for (uint32_t j = 0; j < PROPERTY_OPERANDS; j++) {
            uint32_t *operand = &sequence->steps[i].operands[j];
            for (uint32_t less = *operand; less && is_time_left(start); less /= 2) {
                *operand -= less;
                if (run(property, sequence))
                    *operand += less;
                less = less < *operand ? less : *operand;
            }
        }
    }
}

static void fail_reduced(const struct property *property, struct sequence *sequence)
{
    const time_t start = time(NULL);
    size_t before;
    printf("%s fails: %s\n", property->name, now.text);
    fflush(stdout);
    now.is_reduced = true;
    do {
        before = sequence->count;
        remove_steps(property, sequence, start);
        reduce_operands(property, sequence, start);
    } while (sequence->count < before);
    run(property, sequence);
    print_sequence(property, sequence);
    catch_signals(SIG_DFL);
    now.is_reduced = false;
    free(sequence->steps);
    fail_msg("%s: %s", property->name, now.text);
}

/* ---- making */

uint64_t property_hash(uint32_t operand)
{
    return random_next(&(struct random){operand});
}

static struct property_step step_of(const struct property *property, uint32_t at,
                                    struct random *random)
{
    const struct property_operation *operation = &property->operations[at];
    struct property_step step = {.operation = at, .memory = -1};
    for (uint32_t i = 0; i < PROPERTY_OPERANDS && operation->bounds[i]; i++)
        step.operands[i] = random_below(random, operation->bounds[i]);
    if (operation->scarce && random_one_in(random, operation->scarce))
        step.memory = (int)random_below(random, 3);
    return step;
}

static struct property_step random_step(const struct property *property, struct random *random,
                                        bool is_late)
{
    uint32_t total = 0, at = 0;
    uint32_t weights[PROPERTY_OPERATIONS] = {0};
    for (uint32_t i = 0; i < PROPERTY_OPERATIONS && property->operations[i].name; i++) {
        const struct property_operation *operation = &property->operations[i];
        weights[i] = is_late && operation->late_weight ? operation->late_weight : operation->weight;
        total += weights[i];
    }
    for (uint32_t choice = random_below(random, total); choice >= weights[at]; at++)
        choice -= weights[at];
    return step_of(property, at, random);
}

/* Fills a sequence of `property->steps` steps. */
static void make_random(const struct property *property, struct random *random,
                        struct sequence *sequence)
{
    sequence->count = 0;
    for (uint32_t i = 0; i < PROPERTY_OPERATIONS && property->operations[i].name; i++)
        if (!property->operations[i].weight && !property->operations[i].late_weight)
            sequence->steps[sequence->count++] = step_of(property, i, random);
    while (sequence->count < property->steps) {
        const bool is_late = sequence->count >= property->steps / 2;
        sequence->steps[sequence->count++] = random_step(property, random, is_late);
    }
}

static void run_text(const struct property *property, const char *text)
{
    struct sequence sequence = read_sequence(property, text);
    if (!run(property, &sequence))
        fail_reduced(property, &sequence);
    free(sequence.steps);
}

static void run_random(const struct property *property)
{
    struct random random = random_of(property->name);
    struct sequence sequence = {.steps = calloc(property->steps, sizeof(*sequence.steps))};
    assert_non_null(sequence.steps);
    for (uint32_t i = 0; i < property->sequences; i++) {
        make_random(property, &random, &sequence);
        if (!run(property, &sequence))
            fail_reduced(property, &sequence);
    }
    free(sequence.steps);
}

void property_run(const struct property *property)
{
    const char *given = getenv("ASSAY_TEST_STEPS");
    const size_t length = strlen(property->name);
    catch_signals(fail_by_signal);
    if (given && strncmp(given, property->name, length) == 0 && given[length] == ':') {
        run_text(property, given + length + 1 + strspn(given + length + 1, " "));
    } else if (!given) {
        for (const char *const *text = property->cases; text && *text; text++)
            run_text(property, *text);
        run_random(property);
    }
    catch_signals(SIG_DFL);
}
