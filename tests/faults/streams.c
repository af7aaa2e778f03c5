/* SPDX-License-Identifier: Apache-2.0 */
/* faults_streams [--streams N] [--threaded N] [--stream N]: valid streams of calls, and the same
 * with a fault: an allocation of the layer fails, a command of the driver fails, or the device is
 * lost. No fault may crash the layer, bring a finding about a valid call, or make the layer believe
 * in an object that does not exist.
 *
 * ASSAY_TEST_SEED and --stream repeat a stream. One with threads may need several attempts. */
#include <inttypes.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/null_driver/null_driver.h"

enum { STEPS = 90, DRIVER_COMMANDS = 20, ALL = UINT16_MAX };

enum fault_kind {
    NO_FAULT,
    ALLOCATION_FAILS,
    ALLOCATIONS_FAIL,
    DRIVER_FAILS,
    DEVICE_LOST,
    LOST_AT_BUILD,
    FAULT_KINDS
};
static const char *const fault_names[] = {"no fault",
                                          "a failed allocation of the layer",
                                          "failed allocations from then on",
                                          "a failed command of the driver",
                                          "a lost device",
                                          "a device that a build loses"};

/* What a stream is made of. */
struct stream {
    uint64_t seed;
    uint32_t number;
    uint8_t options; /* of calls_open() */
    bool plants, is_threaded;
    enum fault_kind fault;
    uint32_t at;          /* an allocation, or a step */
    uint32_t allocations; /* out: made without a fault */
};

static struct stream current;
static struct model models[QUEUES];
static atomic_uint findings, unexpected;
static atomic_bool is_scarce; /* an allocation has failed */

/* ---- what is printed if a stream fails */

static void print_stream(void)
{
    fprintf(stderr,
            "ASSAY_TEST_SEED=%" PRIu64 " faults_streams --stream %" PRIu32
            "%s: options %#x, mistakes %s, %s at %" PRIu32 "\n",
            current.seed, current.number, current.is_threaded ? " --threaded 1" : "",
            current.options, current.plants ? "planted" : "none", fault_names[current.fault],
            current.at);
    for (uint32_t i = 0; i < (current.is_threaded ? QUEUES : 1); i++)
        model_print(&models[i]);
}

void __sanitizer_set_death_callback(void (*callback)(void)) __attribute__((weak));

static void die(int signal_number)
{
    signal(signal_number, SIG_DFL);
    print_stream();
    raise(signal_number);
}

static void print_at_death(void)
{
    signal(SIGABRT, die);
    if (__sanitizer_set_death_callback)
        __sanitizer_set_death_callback(print_stream);
    else
        signal(SIGSEGV, die);
}

/* ---- messages */

#define BUILD_ID "VUID-vkCmdBuildAccelerationStructuresKHR-"

static void hear(const VkDebugUtilsMessengerCallbackDataEXT *data)
{
    static const char *const planted[] = {
        BUILD_ID "infoCount-arraylength",
        BUILD_ID "pInfos-03667",
        "VUID-VkAccelerationStructureGeometryAabbsDataKHR-stride-03545",
    };
    const char *id = data->pMessageIdName ? data->pMessageIdName : "";
    for (size_t i = 0; i < sizeof(planted) / sizeof(planted[0]); i++)
        if (strcmp(id, planted[i]) == 0) {
            atomic_fetch_add(&findings, 1);
            return;
        }
    /* The layer may say what it could not check. */
    const bool is_warning = strncmp(id, "VUID-", 5) != 0;
    if (!is_warning || (current.fault == NO_FAULT && !strstr(data->pMessage, "are unchecked"))) {
        atomic_fetch_add(&unexpected, 1);
        fprintf(stderr, "%.400s\n", data->pMessage);
    }
}

/* ---- allocations of the application and of the driver do not fail */

void *__real_calls_allocate(size_t size);
void *__wrap_calls_allocate(size_t size);
void *__real_driver_allocate(void *old, size_t size);
void *__wrap_driver_allocate(void *old, size_t size);

void *__wrap_calls_allocate(size_t size)
{
    const int before = memory_pause();
    void *block = __real_calls_allocate(size);
    memory_resume(before);
    return block;
}

void *__wrap_driver_allocate(void *old, size_t size)
{
    const int before = memory_pause();
    void *block = __real_driver_allocate(old, size);
    memory_resume(before);
    return block;
}

/* ---- a stream */

static void make_fault(struct model *model, struct random *random)
{
    if (current.fault == DRIVER_FAILS) {
        /* An even second operand is no lost device. */
        MODEL_CALL(model, fail_next, (uint8_t)random_below(random, DRIVER_COMMANDS),
                   (uint8_t)(2 * random_below(random, 128)));
    } else if (current.fault == DEVICE_LOST) {
        MODEL_CALL(model, lose_device, 0);
        model->is_lost = true;
    }
}

/* In a build, or before the copies of its inputs. */
static void plan_loss(void)
{
    const struct null_driver_fault fault = {
        .kind = NULL_DRIVER_LOSE,
        .at = NULL_DRIVER_AT_BUILD,
        .number = 1 + current.at / 2,
        .skips_copies = current.at % 2,
    };
    null_driver_plan_fault(current.fault == LOST_AT_BUILD ? &fault : NULL);
}

static void *run(void *context)
{
    struct model *model = context;
    struct random random = {current.seed + current.number + current.at};
    const bool is_faulty = model == models || current.fault != DEVICE_LOST;
    const bool fails = current.fault == ALLOCATION_FAILS || current.fault == ALLOCATIONS_FAIL;
    const int fails_at = fails ? (int)(current.at + model->queue) : INT_MAX;
    if (current.fault == ALLOCATIONS_FAIL)
        memory_fail_from(fails_at);
    else
        memory_fail_after(fails_at);
    for (uint32_t i = 0; i < STEPS; i++) {
        if (is_faulty && i == current.at)
            make_fault(model, &random);
        model_step(model);
    }
    if (model == models)
        current.allocations = (uint32_t)(fails_at - memory_pause());
    if (memory_fail_no_more())
        atomic_store(&is_scarce, true);
    return NULL;
}

static void run_all(uint32_t count)
{
    pthread_t threads[QUEUES];
    for (uint32_t i = 1; i < count; i++)
        if (pthread_create(&threads[i], NULL, run, &models[i]) != 0)
            abort();
    run(&models[0]);
    for (uint32_t i = 1; i < count; i++)
        pthread_join(threads[i], NULL);
}

/* Returns the number of mistakes of the layer. */
static unsigned judge(uint32_t count)
{
    bool is_lost = false;
    unsigned mistakes = 0, failures = 0;
    for (uint32_t i = 0; i < count; i++)
        is_lost |= models[i].is_lost;
    for (uint32_t i = 0; i < count; i++) {
        models[i].is_lost = is_lost;
        failures += picture_compare(&models[i], atomic_load(&is_scarce));
        model_update_all(&models[i]);
        mistakes += models[i].mistakes;
    }
    /* Level state knows nothing of builds; a fault may hide a mistake. */
    const bool are_all_found = current.fault == NO_FAULT && (current.options & 3) != 3;
    if (atomic_load(&findings) > mistakes || (are_all_found && atomic_load(&findings) < mistakes)) {
        failures++;
        fprintf(stderr, "%u findings about %u mistakes\n", atomic_load(&findings), mistakes);
    }
    return failures + atomic_load(&unexpected);
}

static unsigned play(const struct stream *stream)
{
    const uint8_t options[] = {stream->options | 32};
    struct calls calls = {
        .at = options, .end = options + sizeof(options), .has_no_limit = true, .hear = hear};
    const uint32_t count = stream->is_threaded ? QUEUES : 1;
    current = *stream;
    atomic_store(&findings, 0);
    atomic_store(&unexpected, 0);
    atomic_store(&is_scarce, false);
    if (!calls_open(&calls))
        abort();
    for (uint32_t i = 0; i < count; i++) {
        model_begin(&models[i], &calls, i, stream->seed + (uint64_t)stream->number * QUEUES + i);
        models[i].plants = stream->plants;
    }
    plan_loss();
    run_all(count);
    const unsigned failures = judge(count);
    if (failures)
        print_stream();
    calls_close(&calls);
    for (uint32_t i = 0; i < count; i++)
        model_end(&models[i]);
    return failures;
}

/* ---- streams */

static uint32_t played[FAULT_KINDS];

static unsigned play_with(struct stream *stream, enum fault_kind fault, uint32_t at)
{
    stream->fault = fault;
    stream->at = at;
    played[fault]++;
    const unsigned failures = play(stream);
    stream->allocations = current.allocations;
    return failures;
}

/* Plays one stream without a fault and with some of each kind. */
static unsigned play_stream(uint64_t seed, uint32_t number, bool is_threaded)
{
    enum { OF_ALLOCATIONS = 12, OF_DRIVER = 6, OF_LOSSES = 3, OF_BUILDS = 12 };
    struct random random = {seed ^ (uint64_t)number << 32};
    /* Handles and addresses are used once, so that the old ones are known to be gone. */
    struct stream stream = {.seed = seed,
                            .number = number,
                            .options = (uint8_t)random_next(&random) & ~(8 | 16 | 32),
                            .is_threaded = is_threaded};
    unsigned failures = play_with(&stream, NO_FAULT, 0);
    stream.plants = true;
    failures += play_with(&stream, NO_FAULT, 0);
    const uint32_t allocations = stream.allocations;
    for (uint32_t i = 0; i < OF_ALLOCATIONS && allocations && !failures; i++)
        failures += play_with(&stream, ALLOCATION_FAILS, random_below(&random, allocations));
    for (uint32_t i = 0; i < OF_ALLOCATIONS / 2 && allocations && !failures; i++)
        failures += play_with(&stream, ALLOCATIONS_FAIL, random_below(&random, allocations));
    for (uint32_t i = 0; i < OF_DRIVER && !failures; i++)
        failures += play_with(&stream, DRIVER_FAILS, random_below(&random, STEPS));
    for (uint32_t i = 0; i < OF_LOSSES && !failures; i++)
        failures += play_with(&stream, DEVICE_LOST, random_below(&random, STEPS));
    for (uint32_t i = 0; i < 2 * OF_LOSSES && !failures; i++)
        failures += play_with(&stream, LOST_AT_BUILD, random_below(&random, 2 * OF_BUILDS));
    return failures;
}

static void read_arguments(int count, char **arguments, uint32_t *streams, uint32_t *threaded,
                           int64_t *only)
{
    for (int i = 1; i + 1 < count; i += 2) {
        const uint32_t value = (uint32_t)strtoul(arguments[i + 1], NULL, 0);
        if (strcmp(arguments[i], "--streams") == 0)
            *streams = value;
        else if (strcmp(arguments[i], "--threaded") == 0)
            *threaded = value;
        else if (strcmp(arguments[i], "--stream") == 0)
            *only = value;
        else
            abort();
    }
}

int main(int count, char **arguments)
{
    enum { FAILURES_MAX = 5 };
    uint32_t streams = 24, threaded = 8;
    int64_t only = -1;
    unsigned failed = 0;
    read_arguments(count, arguments, &streams, &threaded, &only);
    const uint64_t seed = random_of("faults_streams").state;
    print_at_death();
    if (only >= 0)
        return play_stream(seed, (uint32_t)only, threaded == 1) != 0;
    for (uint32_t i = 0; i < streams && failed < FAILURES_MAX; i++)
        failed += play_stream(seed, i, false) != 0;
    for (uint32_t i = 0; i < threaded && failed < FAILURES_MAX; i++)
        failed += play_stream(seed, i, true) != 0;
    for (int i = 0; i < FAULT_KINDS; i++)
        printf("%u with %s\n", played[i], fault_names[i]);
    return failed != 0;
}
