/* SPDX-License-Identifier: Apache-2.0 */
/* accuracy_checks null|lavapipe [quick]: what the layer adds to building scenes, at each level:
 * lines of comma-separated values on stdout, a word of progress on stderr.
 *
 * Time is that of the application's thread, from recording the builds to the end of the wait for
 * them, or of the host's command: the difference to a world without the layer that takes its turns,
 * a median; and that of all threads of the process. Memory is what stays allocated once a scene is
 * there and built, likewise. On lavapipe builds execute on threads of the
 * driver's. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scripts/tools/measure.h"
#include "workload.h"

#define COMPARE "VK_ASSAY_VALIDATION_COMPARE_RAYS"

/* How many rays level `content + compare` traces after each build. */
#define COMPARED_RAYS "1000"

enum { MOST_SIDES = 7, MOST_SAMPLES = 101 };

/* A world without the layer, or with it at a level. */
struct side {
    const char *name; /* NULL: without */
    const char *level;
    bool compares, records;
    struct fixture fixture;
    struct workload workload;
    uint32_t times;                                          /* runs in a sample */
    double samples[MOST_SAMPLES], all_samples[MOST_SAMPLES]; /* of the thread; of all threads */
    double bytes;
};

struct bench {
    struct platform platform;
    bool is_quick;
    uint32_t side_count;
    struct side sides[MOST_SIDES];
};

/* ---- fixtures */

static char record_name[] = "/tmp/assay-accuracy-XXXXXX";

static const char *const record_settings[][2] = {
    {"VK_ASSAY_VALIDATION_LOG_FORMAT", "json"},
    {"VK_ASSAY_VALIDATION_LOG_FILENAME", record_name},
    {"VK_ASSAY_VALIDATION_RECORD_BUILDS", "true"},
};

static void set_record(bool is_set)
{
    for (size_t i = 0; i < sizeof(record_settings) / sizeof(record_settings[0]); i++)
        if (is_set)
            setenv(record_settings[i][0], record_settings[i][1], 1);
        else
            unsetenv(record_settings[i][0]);
}

static void take_many_instances(struct null_driver_config *config)
{
    config->as_properties.maxInstanceCount = 1 << 24;
}

static void open_fixture(const struct bench *bench, const struct side *side,
                         struct fixture *fixture)
{
    const struct setup setup = {.level = side->level,
                                .by_environment = side->name == NULL,
                                .configure = bench->platform.is_null ? take_many_instances : NULL};
    if (side->compares)
        setenv(COMPARE, COMPARED_RAYS, 1);
    set_record(side->records);
    const char *missing = fixture_open(fixture, &bench->platform, &setup);
    unsetenv(COMPARE);
    set_record(false);
    if (missing != NULL) {
        fprintf(stderr, "accuracy_checks: no world: %s\n", missing);
        exit(1);
    }
}

static struct side *add_side(struct bench *bench, const char *name, const char *level)
{
    struct side *side = &bench->sides[bench->side_count++];
    *side = (struct side){.name = name, .level = level};
    return side;
}

static void open_sides(struct bench *bench)
{
    for (uint32_t i = 0; i < bench->side_count; i++)
        open_fixture(bench, &bench->sides[i], &bench->sides[i].fixture);
}

/* Whether this build of the layer has the setting: its manifest lists all. */
static bool has_compare(void)
{
    FILE *manifest = fopen(LAYER_MANIFEST, "r");
    char line[4096];
    bool is_found = false;
    while (manifest != NULL && fgets(line, sizeof(line), manifest) != NULL)
        is_found = is_found || strstr(line, "\"compare_rays\"") != NULL;
    if (manifest != NULL)
        fclose(manifest);
    return is_found;
}

static void open_bench(struct bench *bench, const char *platform, bool is_quick)
{
    static const char *const levels[] = {"parameters", "state", "execution", "content"};
    bench->is_quick = is_quick;
    const char *missing = platform_open(&bench->platform, platform);
    if (missing != NULL) {
        fprintf(stderr, "accuracy_checks: %s: %s\n", platform, missing);
        exit(77);
    }
    const int record = mkstemp(record_name);
    if (record < 0) {
        perror("accuracy_checks: no file for the record");
        exit(1);
    }
    close(record);
    add_side(bench, NULL, NULL);
    for (size_t i = 0; i < sizeof(levels) / sizeof(levels[0]); i++)
        add_side(bench, levels[i], levels[i]);
    add_side(bench, "execution + record", "execution")->records = true;
    if (has_compare())
        add_side(bench, "content + compare", "content")->compares = true;
    open_sides(bench);
}

/* Valid scenes have no findings. */
static void close_bench(struct bench *bench)
{
    for (uint32_t i = 0; i < bench->side_count; i++) {
        struct side *side = &bench->sides[i];
        const uint32_t count = side->fixture.instance.messages.count;
        if (count != 0 && !side->compares) {
            fprintf(stderr, "accuracy_checks: %u findings at level %s: %s\n", count, side->name,
                    side->fixture.instance.messages.items[0].text);
            exit(1);
        }
        fixture_close(&side->fixture);
    }
    unlink(record_name);
}

/* ---- time and memory */

static void time_runs(struct side *side, uint32_t sample, uint32_t times)
{
    const struct workload *workload = &side->workload;
    const double begin = read_clock(CLOCK_THREAD_CPUTIME_ID);
    const double all_begin = read_clock(CLOCK_PROCESS_CPUTIME_ID);
    for (uint32_t i = 0; i < times; i++)
        workload_run(workload);
    const double builds = (double)times * workload->count;
    side->all_samples[sample] = (read_clock(CLOCK_PROCESS_CPUTIME_ID) - all_begin) / builds;
    side->samples[sample] = (read_clock(CLOCK_THREAD_CPUTIME_ID) - begin) / builds;
}

/* As many runs as take a millisecond, so that a level of some ns is not lost in the noise of one
 * run; one where the driver takes its time. */
static uint32_t times_of_sample(const struct bench *bench, struct side *side)
{
    uint32_t times = 1;
    if (!bench->platform.is_null)
        return times;
    for (time_runs(side, 0, times); side->samples[0] * side->workload.count * times < 1e6;
         time_runs(side, 0, times))
        times *= 2;
    return times;
}

static void take_samples(struct bench *bench, uint32_t samples)
{
    for (uint32_t i = 0; i < bench->side_count; i++)
        bench->sides[i].times = times_of_sample(bench, &bench->sides[i]);
    for (uint32_t i = 0; i < samples; i++)
        for (uint32_t turn = 0; turn < bench->side_count; turn++) {
            struct side *side = &bench->sides[(i + turn) % bench->side_count];
            time_runs(side, i, side->times);
        }
}

/* In a world that has seen nothing else. */
static void measure_bytes(const struct bench *bench, struct side *side, enum workload_kind kind,
                          enum build_command command)
{
    static struct fixture fixture;
    struct workload workload;
    open_fixture(bench, side, &fixture);
    struct scene *scene = scene_open(&fixture, command);
    const double before = bytes_allocated();
    workload_open(&workload, scene, kind, bench->is_quick);
    workload_run(&workload);
    side->bytes = (bytes_allocated() - before) / workload.count;
    workload_close(&workload);
    scene_close(scene);
    fixture_close(&fixture);
}

static void measure(struct bench *bench, enum workload_kind kind, enum build_command command)
{
    const char *by = command == COMMAND_HOST ? "host" : "device";
    const uint32_t samples = bench->is_quick ? 3 : bench->platform.is_null ? 31 : 7;
    fprintf(stderr, "  checks: %s, %s, by the %s\n", bench->platform.name, workload_names[kind],
            by);
    for (uint32_t i = 0; i < bench->side_count; i++) {
        struct side *side = &bench->sides[i];
        measure_bytes(bench, side, kind, command);
        workload_open(&side->workload, scene_open(&side->fixture, command), kind, bench->is_quick);
        workload_run(&side->workload);
    }
    take_samples(bench, samples);
    const double without = quantile(bench->sides[0].samples, samples, 0.5);
    const double all_without = quantile(bench->sides[0].all_samples, samples, 0.5);
    for (uint32_t i = 1; i < bench->side_count; i++) {
        struct side *side = &bench->sides[i];
        const double spread =
            quantile(side->samples, samples, 0.75) - quantile(side->samples, samples, 0.25);
        printf("%s,\"%s\",%s,%s,%u,%.0f,%.0f,%.0f,%.0f,%.0f\n", bench->platform.name,
               workload_names[kind], by, side->name, side->workload.count, without,
               quantile(side->samples, samples, 0.5) - without, spread / 2,
               quantile(side->all_samples, samples, 0.5) - all_without,
               side->bytes - bench->sides[0].bytes);
    }
    fflush(stdout);
    for (uint32_t i = 0; i < bench->side_count; i++) {
        struct scene *scene = bench->sides[i].workload.scene;
        workload_close(&bench->sides[i].workload);
        scene_close(scene);
    }
}

int main(int count, char **arguments)
{
    static struct bench bench;
    if (count < 2) {
        fputs("usage: accuracy_checks null|lavapipe [quick]\n", stderr);
        return 2;
    }
    open_bench(&bench, arguments[1], count > 2);
    printf(
        "driver,scene,by,level,builds,without_ns,added_ns,spread_ns,added_all_threads_ns,added_"
        "bytes\n");
    for (int kind = 0; kind < WORKLOAD_KINDS; kind++) {
        measure(&bench, (enum workload_kind)kind, COMMAND_DEVICE);
        if (bench.sides[0].fixture.has_host)
            measure(&bench, (enum workload_kind)kind, COMMAND_HOST);
    }
    close_bench(&bench);
    return EXIT_SUCCESS;
}
