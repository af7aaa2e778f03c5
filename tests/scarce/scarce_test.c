/* SPDX-License-Identifier: Apache-2.0 */
/* The layer with memory running out: an application lives through its life again and again, and
 * each time another of the layer's allocations fails. Whatever was lost, nothing crashes, nothing
 * leaks, and no message goes out that is not true.
 *
 * If several allocations have the same callers, only the first and the last of them fail. With
 * ASSAY_SCARCE_ALL all of them do: scripts/test --all.
 *
 * Each life is a process, so that a crash tells which allocation it was. */
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "application_parts.h"
#include "injector.h"
#include "tests/state/unit_test.h"

/* How a life ended. */
enum end { WELL, WELL_WITHOUT_FAILURE, IN_SETTINGS_LIBRARY, BADLY };

/* The library that reads settings is in C++, and throws where it gets no memory; nothing in the
 * layer catches that. */
static void end_in_abort(int signal)
{
    _exit(outcome.is_creating_instance ? IN_SETTINGS_LIBRARY : BADLY);
}

static enum end live(unsigned failing)
{
    signal(SIGABRT, end_in_abort);
    injector_fail_at(failing);
    application_live();
    bool has_failed = injector_failed() != 0;
    if (has_failed)
        fprintf(stderr, "(asked for at %#zx) ", injector_failed());
    if (outcome.wrong[0]) {
        fprintf(stderr, "%s\n", outcome.wrong);
        return BADLY;
    }
    if (injector_live()) {
        fprintf(stderr, "%zu blocks leak, the first allocated at %#zx\n", injector_live(),
                injector_oldest());
        return BADLY;
    }
    if (!has_failed && outcome.expected != outcome.mistakes) {
        fprintf(stderr, "%u of %u mistakes were found\n", outcome.expected, outcome.mistakes);
        return BADLY;
    }
    return has_failed ? WELL : WELL_WITHOUT_FAILURE;
}

/* What the child wrote to stderr. */
static const char *words_of(FILE *file)
{
    static char text[8192];
    rewind(file);
    text[fread(text, 1, sizeof(text) - 1, file)] = '\0';
    return text;
}

/* In the child cmocka's handlers would end the test, and with it the child, as if all were well. */
static void leave_signals_alone(void)
{
    static const int signals[] = {SIGBUS, SIGFPE, SIGILL, SIGSEGV, SIGSYS};
    for (size_t i = 0; i < sizeof(signals) / sizeof(signals[0]); i++)
        signal(signals[i], SIG_DFL);
}

static enum end live_in_a_process(unsigned failing)
{
    FILE *words = tmpfile();
    assert_non_null(words);
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (!child) {
        leave_signals_alone();
        dup2(fileno(words), STDERR_FILENO);
        _exit((int)live(failing));
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    enum end end = WIFEXITED(status) ? (enum end)WEXITSTATUS(status) : BADLY;
    if (end == IN_SETTINGS_LIBRARY && !strstr(words_of(words), "std::bad_alloc"))
        end = BADLY;
    if (end >= BADLY)
        fprintf(stderr, "allocation %u, status %#x: %s\n", failing, (unsigned)status,
                words_of(words));
    fclose(words);
    return end < BADLY ? end : BADLY;
}

/* ---- which allocations fail */

enum { MOST = 1 << 16 /* allocations */, ENOUGH = 10 /* lives that end badly */ };

/* Lives a life in which nothing fails, and returns hashes of the calls that led to each allocation;
 * 0 ends them. */
static const uint64_t *record_stacks(void)
{
    uint64_t *stacks = mmap(NULL, MOST * sizeof(*stacks), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_true(stacks != MAP_FAILED);
    injector_record_stacks(stacks, MOST - 1);
    assert_int_equal(live_in_a_process(0), WELL_WITHOUT_FAILURE);
    injector_record_stacks(NULL, 0);
    return stacks;
}

/* Whether an allocation before (step -1) or behind (1) has the same stack. */
static bool repeats(const uint64_t *stacks, unsigned i, int step)
{
    for (unsigned j = i; (step > 0 || j > 0) && stacks[j];)
        if (stacks[j += (unsigned)step] == stacks[i])
            return true;
    return false;
}

/* ASSAY_SCARCE_AT repeats one life. */
TEST(test_a_life_without_each_allocation)
{
    const uint64_t *stacks = record_stacks();
    const char *only = getenv("ASSAY_SCARCE_AT"), *has_all = getenv("ASSAY_SCARCE_ALL");
    unsigned count = 0, lives = 0, bad = 0, aborted = 0;
    for (; stacks[count] && bad < ENOUGH; count++) {
        const bool is_chosen =
            only ? strtoul(only, NULL, 10) == count + 1
                 : has_all || !repeats(stacks, count, -1) || !repeats(stacks, count, 1);
        if (!is_chosen)
            continue;
        const enum end end = live_in_a_process(count + 1);
        bad += end == BADLY;
        aborted += end == IN_SETTINGS_LIBRARY;
        lives++;
    }
    printf("%u allocations, %u lives, of which %u ended in the settings library\n", count, lives,
           aborted);
    assert_int_equal(bad, 0);
    assert_true(only || lives > 100);
}

const char *unit_test_open(const char *argument)
{
    setenv("VK_DRIVER_FILES", DRIVER_MANIFEST, 1);
    setenv("VK_LAYER_PATH", LAYER_FOLDER, 1);
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error,warn", 1);
    setenv("VK_ASSAY_VALIDATION_BACKEND", BACKEND, 1);
    setenv("VK_ASSAY_VALIDATION_LEVEL", LEVEL, 1);
#ifdef GUARD
    setenv("VK_ASSAY_VALIDATION_GUARD", GUARD, 1);
#endif
    if (!injector_watch(LAYER_LIBRARY)) {
        fprintf(stderr, "%s\n", dlerror());
        exit(EXIT_FAILURE);
    }
    return NULL;
}
