/* SPDX-License-Identifier: Apache-2.0 */
/* growth_test [null FINDINGS CYCLES]: memory that grows with findings, or with instances. */
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "tests/loader/loader_test.h"

enum {
    KIB = 1024,
    /* Smaller than one byte for each finding of the long run; noise of the heap is below. */
    FINDINGS_GROWTH = 96 * KIB,
    CYCLES_GROWTH = 1024 * KIB,
};

static unsigned findings = 10000, cycles = 100;

static long resident(void)
{
    long size = 0, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%ld %ld", &size, &pages), 2);
    fclose(file);
    return pages * sysconf(_SC_PAGESIZE);
}

struct reporting {
    const char *limit, *level;
    const char *format, *filename; /* NULL: no log */
    bool is_information;
    unsigned warnings;
};

static const struct reporting reportings[] = {
    {"0", "execution", NULL, NULL, false, 0},
    {"0", "execution", "text", "/dev/null", false, 0},
    {"0", "execution", "json", "/dev/null", true, 0},
    {"10", "execution", "json", "/dev/null", true, 0},
    {"0", "content", "text", "/dev/null", false, 0},
    {"0", "execution", "text", "/dev/full", false, 1},
    {"0", "execution", "json", "/dev/full", false, 1},
    {"0", "execution", "text", "/nonexistent/log", false, 1},
};

static void set(const char *name, const char *value)
{
    if (value)
        setenv(name, value, 1);
    else
        unsetenv(name);
}

static void use(const struct reporting *reporting)
{
    set("VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT", reporting->limit);
    set("VK_ASSAY_VALIDATION_LEVEL", reporting->level);
    set("VK_ASSAY_VALIDATION_LOG_FORMAT", reporting->format);
    set("VK_ASSAY_VALIDATION_LOG_FILENAME", reporting->filename);
    set("VK_ASSAY_VALIDATION_REPORT_FLAGS", reporting->is_information ? "error,warn,info" : NULL);
}

/* One finding, each about another structure. */
static void make_mistake(struct scene *scene, unsigned i)
{
    VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[INDEXED];
    info.dstAccelerationStructure =
        (VkAccelerationStructureKHR)(((uintptr_t)i << 8) + 0x700000000001u);
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &info,
                                                 scene->ranges_argument);
    if (i % 100 == 99) { /* the journal grows with the recording, not with findings */
        scene->vk->EndCommandBuffer(scene->command_buffer);
        scene_begin(scene, scene->command_buffer, 0);
    }
}

static void report_often(const struct reporting *reporting)
{
    static struct fixture fixture;
    static const struct setup plain = {.by_environment = true};
    struct timespec begin, end;
    use(reporting);
    set("VK_INSTANCE_LAYERS", LAYER_NAME);
    fixture.instance.messages.answer = VK_FALSE;
    assert_null(fixture_open(&fixture, &platform, &plain));
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    for (unsigned i = 0; i < findings / 10; i++)
        make_mistake(scene, i);
    const long before = resident();
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (unsigned i = findings / 10; i < findings; i++)
        make_mistake(scene, i);
    clock_gettime(CLOCK_MONOTONIC, &end);
    const long growth = resident() - before;
    const double ns =
        (double)(end.tv_sec - begin.tv_sec) * 1e9 + (double)(end.tv_nsec - begin.tv_nsec);
    print_message(
        "limit %s, level %s, log %s: %u findings, %u messages, %ld KiB more, %.1f us "
        "a finding\n",
        reporting->limit, reporting->level, reporting->format ? reporting->format : "none",
        findings, fixture.instance.messages.count, growth / KIB,
        ns / 1000 / (findings - findings / 10));
    if (reporting->limit[0] == '0')
        assert_int_equal(fixture.instance.messages.count, findings + reporting->warnings);
    assert_true(growth < FINDINGS_GROWTH);
    scene_close(scene);
    fixture_close(&fixture);
    use(&(struct reporting){0});
    unsetenv("VK_INSTANCE_LAYERS");
}

static void live(const char *level)
{
    static struct fixture fixture;
    const struct setup setup = {.by_environment = true, .level = level};
    assert_null(fixture_open(&fixture, &platform, &setup));
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    scene_call(scene);
    scene->info_count = 0;
    scene_call(scene);
    scene_submit_call(scene);
    scene_close(scene);
    fixture_close(&fixture);
}

/* How much a process grows that makes these cycles, after a tenth of them. */
static long growth_of_cycles(const char *level, bool has_layer)
{
    int ends[2];
    long growth = 0;
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        set("VK_INSTANCE_LAYERS", has_layer ? LAYER_NAME : NULL);
        for (unsigned i = 0; i < cycles / 10; i++)
            live(level);
        growth = -resident();
        for (unsigned i = cycles / 10; i < cycles; i++)
            live(level);
        growth += resident();
        _exit(write(ends[1], &growth, sizeof(growth)) == sizeof(growth) ? 0 : 1);
    }
    close(ends[1]);
    assert_int_equal(read(ends[0], &growth, sizeof(growth)), sizeof(growth));
    close(ends[0]);
    waitpid(child, NULL, 0);
    return growth;
}

TEST(test_cycles)
{
    static const char *const levels[] = {"execution", "content"};
    for (size_t i = 0; i < LENGTH(levels); i++) {
        const long without = growth_of_cycles(levels[i], false),
                   with = growth_of_cycles(levels[i], true);
        print_message("level %s: %u cycles, %ld KiB more, without the layer %ld KiB\n", levels[i],
                      cycles, with / KIB, without / KIB);
        assert_true(with - without < CYCLES_GROWTH);
    }
}

/* Last: the layer stays loaded. */
TEST(test_findings)
{
    for (size_t i = 0; i < LENGTH(reportings); i++)
        report_often(&reportings[i]);
}

const char *loader_test_open(void)
{
    char **numbers = unit_test_arguments;
    if (numbers[0] && numbers[1] && numbers[2]) {
        findings = (unsigned)atoi(numbers[1]);
        cycles = (unsigned)atoi(numbers[2]);
    }
    return NULL;
}
