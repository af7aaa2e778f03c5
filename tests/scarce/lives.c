/* SPDX-License-Identifier: Apache-2.0 */
#include "lives.h"

#include <dlfcn.h>
#include <malloc.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "injector.h"
#include "tests/unit/random.h"

enum {
    MOST = 1 << 16,       /* allocations of a life */
    KNOWN_MOST = 1 << 18, /* stacks of all lives */
    ENOUGH = 10,          /* applications with a life that ends badly */
};

static uint64_t *stacks; /* of the allocations of a life, shared with its process; 0 ends them */
static unsigned lives, bad;
static unsigned long allocations; /* of lives that lack none */
static unsigned one_of;           /* ASSAY_SCARCE_ONE_OF; 0: not set */
static struct random chance;

void lives_open(void)
{
    const char *more = getenv("ASSAY_SCARCE_ONE_OF");
    one_of = more ? (unsigned)strtoul(more, NULL, 10) : 0;
    if (one_of)
        chance = random_of("scarce");
    /* The loader asks for 800 KB, of which it uses little, whenever it lists extensions. Such a
     * block comes from the system, as zeros, as long as this threshold is fixed: half of each life
     * went to clearing it. */
    mallopt(M_MMAP_THRESHOLD, 128 * 1024);
    stacks = mmap(NULL, MOST * sizeof(*stacks), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS,
                  -1, 0);
    if (stacks != MAP_FAILED && injector_watch(LAYER_LIBRARY))
        return;
    fprintf(stderr, "%s\n", stacks == MAP_FAILED ? "no shared memory" : dlerror());
    exit(2);
}

/* ---- a life */

static enum life_end live_here(const char *(*live)(bool is_scarce), unsigned failing)
{
    injector_fail_at(failing);
    const char *wrong = live(failing != 0);
    if (!wrong)
        return LIFE_SKIPPED;
    if (!wrong[0] && !injector_live())
        return LIFE_WELL;
    fprintf(stderr, "%s\n", wrong);
    if (injector_live())
        fprintf(stderr, "%zu blocks leak, the first allocated at %#zx\n", injector_live(),
                injector_oldest());
    return LIFE_BADLY;
}

/* However the process ends. Where coverage is measured, gcov's part of the library allocates later,
 * and crashes without memory. */
static void end_life(void)
{
    if (injector_failed())
        fprintf(stderr, "(asked for at %#zx)\n", injector_failed());
    injector_record_stacks(NULL, 0);
    injector_fail_at(0);
}

/* What the process wrote to stderr. */
static const char *words_of(FILE *file)
{
    static char text[8192];
    rewind(file);
    text[fread(text, 1, sizeof(text) - 1, file)] = '\0';
    return text;
}

static enum life_end live_in_a_process(const char *name, const char *(*live)(bool is_scarce),
                                       unsigned failing)
{
    FILE *words = tmpfile();
    fflush(NULL);
    const pid_t child = words ? fork() : -1;
    int status;
    if (!child) {
        dup2(fileno(words), STDERR_FILENO);
        atexit(end_life);
        exit((int)live_here(live, failing));
    }
    if (child < 0 || waitpid(child, &status, 0) != child) {
        perror("a life");
        exit(2);
    }
    enum life_end end = WIFEXITED(status) && WEXITSTATUS(status) < LIFE_BADLY
                            ? (enum life_end)WEXITSTATUS(status)
                            : LIFE_BADLY;
    if (end == LIFE_BADLY)
        printf("%s, allocation %u, status %#x: %s\n", name, failing, (unsigned)status,
               words_of(words));
    fclose(words);
    return end;
}

/* ---- which allocations fail */

/* The number of the application, from 1 on, that had such an allocation first. Open addressing with
 * linear probing. */
static unsigned first_with(uint64_t stack, unsigned application)
{
    static struct {
        uint64_t stack;
        unsigned application;
    } known[KNOWN_MOST];
    size_t i = stack % KNOWN_MOST;
    while (known[i].stack && known[i].stack != stack)
        i = (i + 1) % KNOWN_MOST;
    if (!known[i].stack) {
        known[i].stack = stack;
        known[i].application = application;
    }
    return known[i].application;
}

/* Whether an allocation before (step -1) or behind (1) has the same stack. */
static bool repeats(unsigned i, int step)
{
    for (unsigned j = i; (step > 0 || j > 0) && stacks[j];)
        if (stacks[j += (unsigned)step] == stacks[i])
            return true;
    return false;
}

static bool fails(unsigned i, unsigned application)
{
    const char *only = getenv("ASSAY_SCARCE_AT");
    if (only)
        return strtoul(only, NULL, 10) == i + 1;
    const bool is_new = first_with(stacks[i], application) == application;
    return (is_new && (!repeats(i, -1) || !repeats(i, 1))) ||
           (one_of && random_one_in(&chance, one_of));
}

void lives_play(const char *name, const char *(*live)(bool is_scarce))
{
    static unsigned application;
    application++;
    memset(stacks, 0, MOST * sizeof(*stacks));
    injector_record_stacks(stacks, MOST - 1);
    const enum life_end end = live_in_a_process(name, live, 0);
    injector_record_stacks(NULL, 0);
    bool is_bad = end == LIFE_BADLY;
    for (unsigned i = 0; end == LIFE_WELL && stacks[i] && !is_bad; i++) {
        allocations++;
        if (!fails(i, application))
            continue;
        is_bad = live_in_a_process(name, live, i + 1) == LIFE_BADLY;
        lives++;
    }
    bad += is_bad;
}

bool lives_are_enough(void)
{
    return bad >= ENOUGH;
}

int lives_close(unsigned least)
{
    printf("%u lives, for %lu allocations; %u applications ended badly\n", lives, allocations, bad);
    return bad || (lives < least && !getenv("ASSAY_SCARCE_AT"));
}
