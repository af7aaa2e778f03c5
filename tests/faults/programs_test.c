/* SPDX-License-Identifier: Apache-2.0 */
/* faults_programs_test --frames N: the programs of tests/programs/frames, each again and again with
 * one instance. The layer must not need more memory for N than for half of them.
 *
 * faults_programs_test [--programs N] [--threaded N] [--only N]: random programs (tests/execution),
 * and the same with a fault: an allocation of the layer fails, a command of the driver fails, or
 * the device is lost. No fault may crash the layer, leak memory, or bring a finding that the model
 * does not expect. Handles and addresses of the driver are used again, so that what the layer
 * believes of objects that are gone counts for others.
 *
 * ASSAY_TEST_SEED and --only repeat a program. One with threads may need several attempts. */
#include <inttypes.h>
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/execution/random_test.h"
#include "tests/fixture/linked.h"
#include "tests/fixture/scarce_memory.h"

enum { THREADS = 3, STEPS = 24 };

enum fault {
    NO_FAULT,
    ALLOCATION_FAILS,
    ALLOCATIONS_FAIL,
    DRIVER_FAILS,
    DEVICE_LOST,
    LOST_AT_BUILD,
    FAULTS
};
static const struct {
    const char *name;
    uint32_t count; /* of programs, for each one without a fault */
} faults[FAULTS] = {
    {"no fault", 1},         {"a failed allocation", 12}, {"failed allocations", 6},
    {"a failed command", 6}, {"a lost device", 3},        {"a build that loses the device", 6},
};

/* What is played. */
static struct {
    uint64_t seed, number;
    enum fault fault;
    uint32_t variant; /* of the fault */
    uint32_t threads;
} current;
static struct platform platform;
static struct random_test tests[THREADS]; /* each thread's; the first one is the only one mostly */
static struct play shared;                /* by threads */
static struct program whole;              /* what all threads expect */

/* ---- allocations of the driver do not fail */

void *__real_driver_allocate(void *old, size_t size);
void *__wrap_driver_allocate(void *old, size_t size);

void *__wrap_driver_allocate(void *old, size_t size)
{
    const int before = memory_pause();
    void *block = __real_driver_allocate(old, size);
    memory_resume(before);
    return block;
}

static void fail_allocations(int after, bool for_good)
{
    if (after < 0)
        memory_fail_no_more();
    else if (for_good)
        memory_fail_from(after);
    else
        memory_fail_after(after);
}

/* ---- what is printed if a program fails */

static void print_tests(void)
{
    fprintf(stderr, "ASSAY_TEST_SEED=%" PRIu64 " faults_programs_test --only %" PRIu64 "%s\n",
            current.seed, current.number, current.threads > 1 ? " (by threads)" : "");
    for (uint32_t i = 0; i < current.threads; i++) {
        if (tests[i].play.report.outcome == OUTCOME_PASSED)
            report_program(&tests[i].play.report, tests[i].play.program, tests[i].play.at);
        fprintf(stderr, "%s\n", tests[i].play.report.text);
    }
    fprintf(stderr, "%s\n", shared.report.text);
}

void __sanitizer_set_death_callback(void (*callback)(void)) __attribute__((weak));

static void die(int signal_number)
{
    signal(signal_number, SIG_DFL);
    print_tests();
    raise(signal_number);
}

/* A call has failed that must not, and the process exits. */
static void print_at_exit(void)
{
    if (current.threads)
        print_tests();
}

static void print_at_death(void)
{
    atexit(print_at_exit);
    signal(SIGABRT, die);
    if (__sanitizer_set_death_callback)
        __sanitizer_set_death_callback(print_tests);
    else
        signal(SIGSEGV, die);
}

/* ---- a fault is a line of the program */

static void add_fault(struct random_test *test, struct random *random)
{
    static const char *const commands[] = {
        "vkCreateBuffer",       "vkAllocateMemory",
        "vkBindBufferMemory",   "vkMapMemory",
        "vkCreateFence",        "vkQueueSubmit",
        "vkQueueSubmit2",       "vkCreateComputePipelines",
        "vkCreateShaderModule", "vkCreatePipelineLayout",
        "vkBeginCommandBuffer", "vkEndCommandBuffer",
        "vkResetCommandBuffer", "vkAllocateCommandBuffers",
        "vkCreateCommandPool",  "vkCreateAccelerationStructureKHR",
        "vkWaitForFences",      "vkBuildAccelerationStructuresKHR",
        "vkGetFenceStatus",     "vkDeviceWaitIdle",
    };
    const uint32_t number = 1 + random_below(random, 1 << (1 + random_below(random, 9)));
    const char *command = commands[random_below(random, ARRAY_COUNT(commands))];
    const char *result = random_one_in(random, 2) ? "OUT_OF_DEVICE_MEMORY" : "OUT_OF_HOST_MEMORY";
    test->play.is_scarce = true;
    test->play.was_lost = current.fault >= DRIVER_FAILS; /* the layer may lose it, too */
    if (current.fault == ALLOCATION_FAILS)
        add_line(test, "allocation %u fails", number);
    else if (current.fault == ALLOCATIONS_FAIL)
        add_line(test, "allocations fail from %u", number);
    else if (current.fault == DRIVER_FAILS)
        add_line(test, "fail %s %s %u", command, result, 1 + random_below(random, 8));
    else if (current.fault == DEVICE_LOST)
        add_line(test, "lose device");
    else
        add_line(test, "fault lose at build %u%s", 1 + number % 8, number & 8 ? " early" : "");
    play_lines(test);
}

static void *play_steps(void *of)
{
    struct random_test *test = of;
    struct random random = {current.seed + current.number + current.variant};
    const uint32_t at = random_below(&random, STEPS);
    const bool is_faulty =
        test == tests ? current.fault != NO_FAULT
                      : current.fault == ALLOCATION_FAILS || current.fault == ALLOCATIONS_FAIL;
    for (uint32_t i = 0; i < STEPS; i++) {
        if (is_faulty && i == at)
            add_fault(test, &random);
        random_step(test);
    }
    if (is_faulty)
        add_line(test, "allocations succeed");
    random_finish(test);
    platform.fail_allocations(-1, false);
    return NULL;
}

/* Creates all objects: nothing fails yet. */
static void start(struct random_test *test)
{
    test->random.state = (current.seed ^ current.number << 32) + (uint64_t)(test - tests);
    random_start(test);
}

/* ---- a program */

/* Adds the settings that decide what is checked. All variants of a program have the same ones. */
static void add_settings(struct random_test *test, struct random *random)
{
    static const char *const levels[] = {"execution", "content", "content", "state"};
    const char *level = levels[random_below(random, ARRAY_COUNT(levels))];
    linked_open(&platform, random_one_in(random, 2));
    platform.fail_allocations = fail_allocations;
    platform.pause_allocations = memory_pause;
    platform.resume_allocations = memory_resume;
    add_line(test, "driver recycles");
    add_line(test, "setting level %s", level);
    if (platform.is_cpu)
        add_line(test, "setting backend cpu");
    if (current.fault != NO_FAULT) {
        add_line(test, "setting content_budget_mib 2");
        add_line(test, "setting content_when_full %s", random_one_in(random, 2) ? "skip" : "wait");
    }
    test->play.may_warn = true;
    test->play.is_scarce = strcmp(level, "state") == 0; /* it knows nothing of builds */
}

static void prepare(struct random_test *test, uint32_t index)
{
    static const char *const queues[THREADS] = {"q0", "q1", "q2"};
    struct random random = {current.seed ^ current.number};
    struct program *program = &test->program;
    test->play = (struct play){.platform = &platform};
    program->line_count = program->expected_count = 0;
    program->used = 0;
    test->played = 0;
    test->is_faulty = true;
    test->is_over = false;
    test->queue = current.threads > 1 ? queues[index] : NULL;
    snprintf(program->name, sizeof(program->name), "program %" PRIu64 ", with %s", current.number,
             faults[current.fault].name);
    add_settings(test, &random);
}

static void play_alone(void)
{
    struct play *play = &tests[0].play;
    if (!play_begin(play, &tests[0].program))
        abort();
    start(&tests[0]);
    play_steps(&tests[0]);
    play_end(play);
    play_close(play);
}

/* Messages of threads are judged together. With a fault they are not: what the layer knows then
 * depends on which thread the fault meets. */
static void judge_threads(void)
{
    whole.expected_count = 0;
    shared.program = &whole;
    for (uint32_t i = 0; i < THREADS; i++)
        for (unsigned j = 0; j < tests[i].program.expected_count; j++) {
            PLAY_REQUIRE(&shared, whole.expected_count < PROGRAM_EXPECTATIONS);
            whole.expected[whole.expected_count] = tests[i].program.expected[j];
            whole.expected[whole.expected_count++].line = -1;
        }
    play_judge(&shared, -1);
}

static void play_in_threads(void)
{
    pthread_t threads[THREADS];
    shared = tests[0].play;
    if (!play_begin(&shared, &tests[0].program))
        abort();
    for (uint32_t i = 0; i < THREADS; i++) {
        const struct program *program = &tests[i].program;
        tests[i].play = shared;
        tests[i].play.program = program;
        tests[i].play.is_scarce = true; /* the messages are elsewhere */
        play_create_objects(&tests[i].play);
        start(&tests[i]);
    }
    for (uint32_t i = 0; i < THREADS; i++)
        if (pthread_create(&threads[i], NULL, play_steps, &tests[i]) != 0)
            abort();
    for (uint32_t i = 0; i < THREADS; i++) {
        pthread_join(threads[i], NULL);
        play_destroy_objects(&tests[i].play);
    }
    /* Calls that overlap may leave the order open; and what was said of one batch may come again.
     */
    shared.is_scarce = shared.repeats = true;
    shared.was_lost = tests[0].play.was_lost;
    if (current.fault == NO_FAULT)
        judge_threads();
    play_end(&shared);
    play_close(&shared);
}

/* Returns whether the layer made a mistake. */
static bool play_with(enum fault fault, uint32_t variant)
{
    const int before = allocations_now();
    bool fails = false;
    current.fault = fault;
    current.variant = variant;
    shared.report.text[0] = '\0';
    shared.report.outcome = OUTCOME_PASSED;
    for (uint32_t i = 0; i < current.threads; i++)
        prepare(&tests[i], i);
    if (current.threads > 1)
        play_in_threads();
    else
        play_alone();
    if (allocations_now() != before)
        report_say(&shared.report, "%d blocks of memory are left\n", allocations_now() - before);
    for (uint32_t i = 0; i < current.threads; i++)
        fails |= tests[i].play.report.outcome != OUTCOME_PASSED;
    fails |= shared.report.text[0] != 0;
    if (fails)
        print_tests();
    return fails;
}

/* ---- all programs */

static uint32_t played[FAULTS];

/* Plays a program without a fault, and with some of each kind. */
static bool fails(uint64_t number, uint32_t threads)
{
    current.number = number;
    current.threads = threads;
    for (enum fault fault = NO_FAULT; fault < FAULTS; fault++)
        for (uint32_t variant = 0; variant < faults[fault].count; variant++) {
            played[fault]++;
            if (play_with(fault, variant))
                return true;
        }
    return false;
}

/* ---- what stays behind frames */

/* The first half of them are more objects than the layer remembers of those that are gone, and the
 * second as many, so that a table doubles which remembers one more in each; where they are fewer,
 * memory may grow. The bounds are the noise of tables whose size depends on addresses. */
enum { FRAMES = 800, BLOCKS_MAX = 50, BYTES_MAX = 12000 };

static long bytes_now(void)
{
#ifdef __GLIBC__
    return (long)mallinfo2().uordblks;
#else
    return 0;
#endif
}

/* Returns whether a frame fails, or memory grows. */
static bool frames_fail(const struct source *source, unsigned variant, int frames)
{
    struct play *play = &shared;
    const int before = allocations_now();
    int blocks = 0;
    long bytes = 0;
    program_make(&whole, source, variant, true);
    linked_open(&platform, program_find(&whole, "only", "cpu"));
    *play = (struct play){.platform = &platform};
    for (int i = 0; i < frames && play->report.outcome == OUTCOME_PASSED; i++) {
        if (i == frames / 2) {
            blocks = allocations_now();
            bytes = bytes_now();
        }
        play_program(play, &whole);
    }
    blocks = allocations_now() - blocks;
    bytes = bytes_now() - bytes;
    play_close(play);
    if (play->report.outcome == OUTCOME_PASSED)
        printf("%s: %d frames need %d blocks more (at most %d), %ld bytes more (at most %d)\n",
               whole.name, frames / 2, blocks, BLOCKS_MAX, bytes, BYTES_MAX);
    else
        printf("%s\n", play->report.text);
    if (allocations_now() != before)
        printf("%d blocks of memory are left\n", allocations_now() - before);
    return play->report.outcome != OUTCOME_PASSED || allocations_now() != before ||
           (frames >= FRAMES && (blocks > BLOCKS_MAX || bytes > BYTES_MAX));
}

static int play_frames(int frames)
{
    static struct sources sources;
    bool fails = false;
    sources_read_all(&sources, "frames");
    for (unsigned i = 0; i < sources.count; i++)
        for (unsigned j = 0; j < source_variants(&sources.items[i]); j++)
            fails |= frames_fail(&sources.items[i], j, frames);
    return fails;
}

int main(int count, char **arguments)
{
    enum { FAILURES_MAX = 5 };
    uint64_t programs = 24, threaded = 8, first = 0;
    unsigned failed = 0;
    int frames = 0;
    for (int i = 1; i + 1 < count; i += 2) {
        const uint64_t value = strtoull(arguments[i + 1], NULL, 0);
        if (strcmp(arguments[i], "--programs") == 0)
            programs = value;
        else if (strcmp(arguments[i], "--threaded") == 0)
            threaded = value;
        else if (strcmp(arguments[i], "--only") == 0)
            first = value, programs = threaded = value + 1;
        else if (strcmp(arguments[i], "--frames") == 0)
            frames = (int)value;
        else
            abort();
    }
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    if (frames > 0)
        return play_frames(frames);
    current.seed = random_seed(20261127);
    differences_fill();
    print_at_death();
    for (uint64_t i = first; i < programs && failed < FAILURES_MAX; i++)
        failed += fails(i, 1);
    for (uint64_t i = first; i < threaded && failed < FAILURES_MAX; i++)
        failed += fails(i, THREADS);
    current.threads = 0;
    for (int i = 0; i < FAULTS; i++)
        printf("%u with %s\n", played[i], faults[i].name);
    return failed != 0;
}
