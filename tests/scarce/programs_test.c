/* SPDX-License-Identifier: Apache-2.0 */
/* programs_test PLATFORM FOLDER[/FILE]...: plays programs (tests/programs) with memory running out:
 * each life of a program lacks another of the layer's allocations. Whatever was lost, nothing
 * crashes, nothing leaks, and no message comes that the program does not expect, though some that
 * it expects may be missing. ASSAY_SCARCE_FILTER is a part of the names of the programs to play.
 *
 * Where the same calls within the layer lead to several allocations, only the first and the last of
 * them fail, once for all programs. With ASSAY_SCARCE_ONE_OF=N, which scripts/test --all sets, one
 * of N of all allocations fails, too, by chance (ASSAY_TEST_SEED). ASSAY_SCARCE_AT repeats one
 * life.
 *
 * Each life is a process, so that a crash tells which allocation it was. */
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
#include "tests/player/play.h"
#include "tests/unit/random.h"

static struct platform platform;
static struct program program;
static struct sources sources;
static struct play play;

enum {
    MOST = 1 << 16,       /* allocations of a life */
    KNOWN_MOST = 1 << 18, /* stacks of all lives */
    ENOUGH = 10,          /* programs with a life that ends badly */
};

static uint64_t *stacks; /* of the allocations of a life, shared with its process; 0 ends them */
static unsigned lives, bad;
static unsigned long allocations; /* of lives that lack none */
static unsigned one_of;           /* ASSAY_SCARCE_ONE_OF; 0: not set */
static struct random chance;

/* How a life ended. */
enum life_end { LIFE_WELL, LIFE_SKIPPED, LIFE_BADLY };

/* ---- a life */

/* A call has failed that must not, even if it is repeated. */
static void tell_line(void)
{
    const struct program_line *line = &program.lines[play.at];
    if (play.program)
        fprintf(stderr, "a call fails in line %u: %s\n", line->number, line->text);
}

static const char *live(bool is_scarce)
{
    play = (struct play){.platform = &platform, .is_scarce = is_scarce, .repeats = is_scarce};
    atexit(tell_line);
    play_program(&play, &program);
    play_close(&play);
    play.program = NULL;
    return play.report.outcome == OUTCOME_SKIPPED  ? NULL
           : play.report.outcome == OUTCOME_FAILED ? play.report.text
                                                   : "";
}

static enum life_end live_here(unsigned failing)
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

static enum life_end live_in_a_process(unsigned failing)
{
    FILE *words = tmpfile();
    fflush(NULL);
    const pid_t child = words ? fork() : -1;
    int status;
    if (!child) {
        dup2(fileno(words), STDERR_FILENO);
        atexit(end_life);
        exit((int)live_here(failing));
    }
    if (child < 0 || waitpid(child, &status, 0) != child) {
        perror("a life");
        exit(2);
    }
    enum life_end end = WIFEXITED(status) && WEXITSTATUS(status) < LIFE_BADLY
                            ? (enum life_end)WEXITSTATUS(status)
                            : LIFE_BADLY;
    if (end == LIFE_BADLY)
        printf("%s, allocation %u, status %#x: %s\n", program.name, failing, (unsigned)status,
               words_of(words));
    fclose(words);
    return end;
}

/* ---- which allocations fail */

/* The number of the program, from 1 on, that had such an allocation first. Open addressing with
 * linear probing. */
static unsigned first_with(uint64_t stack, unsigned number)
{
    static struct {
        uint64_t stack;
        unsigned number;
    } known[KNOWN_MOST];
    size_t i = stack % KNOWN_MOST;
    while (known[i].stack && known[i].stack != stack)
        i = (i + 1) % KNOWN_MOST;
    if (!known[i].stack) {
        known[i].stack = stack;
        known[i].number = number;
    }
    return known[i].number;
}

/* Whether an allocation before (step -1) or behind (1) has the same stack. */
static bool repeats(unsigned i, int step)
{
    for (unsigned j = i; (step > 0 || j > 0) && stacks[j];)
        if (stacks[j += (unsigned)step] == stacks[i])
            return true;
    return false;
}

static bool fails(unsigned i, unsigned number)
{
    const char *only = getenv("ASSAY_SCARCE_AT");
    if (only)
        return strtoul(only, NULL, 10) == i + 1;
    const bool is_new = first_with(stacks[i], number) == number;
    return (is_new && (!repeats(i, -1) || !repeats(i, 1))) ||
           (one_of && random_one_in(&chance, one_of));
}

/* Plays the program: first without a failure, then again and again, until a life ends badly. */
static void play_lives(void)
{
    static unsigned number;
    number++;
    memset(stacks, 0, MOST * sizeof(*stacks));
    injector_record_stacks(stacks, MOST - 1);
    const enum life_end end = live_in_a_process(0);
    injector_record_stacks(NULL, 0);
    bool is_bad = end == LIFE_BADLY;
    for (unsigned i = 0; end == LIFE_WELL && stacks[i] && !is_bad; i++) {
        allocations++;
        if (!fails(i, number))
            continue;
        is_bad = live_in_a_process(i + 1) == LIFE_BADLY;
        lives++;
    }
    bad += is_bad;
}

/* ---- which programs */

static bool has_words(const char *first, const char *second)
{
    for (unsigned i = 0; i < program.line_count; i++)
        for (char *const *word = program.lines[i].words; *word; word++)
            if (play_is(word[0], first) && (!second || play_is(word[1], second)))
                return true;
    return false;
}

/* Backend cpu says that a build needs 0 bytes if it has no memory to look at it, and the host
 * cannot query what a command buffer did not build. */
static bool depends_on_backend(void)
{
    return platform.is_cpu && (has_words("fitting", NULL) || has_words("scratch", "build") ||
                               has_words("scratch", "update") || has_words("size", "less") ||
                               (has_words("host", "query") && !has_words("host", "build")));
}

/* A life repeats calls that lack memory. Such a program counts on the failure of one. */
static bool needs_failure(void)
{
    for (unsigned i = 0; i < program.line_count; i++)
        if (program.lines[i].result && strncmp(program.lines[i].result, "OUT_OF", 6) == 0)
            return true;
    return false;
}

/* What the log or the driver counts depends on what was lost. The program itself says so where the
 * layer gives a second advice for want of what the first needs. */
static bool depends_on_memory(void)
{
    return has_words("only", "memory") || has_words("records", NULL) || has_words("count", NULL) ||
           needs_failure() || depends_on_backend();
}

static bool is_played(void)
{
    const char *filter = getenv("ASSAY_SCARCE_FILTER");
    enum vuid vuid;
    enum build_command command;
    return !depends_on_memory() && program_subject(&program, &vuid, &command) &&
           (!filter || strstr(program.name, filter));
}

static bool is_shared(const struct table *table)
{
    unsigned cases = 0;
    for (unsigned i = 0; i < sources.count; i++)
        for (unsigned j = 0; j < sources.items[i].table_count; j++)
            cases += sources.items[i].tables[j] == table;
    return cases > 1;
}

/* The rows of a table of one case stand for as many cases. Of tables that several cases share, the
 * first row is enough. */
static bool is_chosen(const struct source *source, unsigned variant)
{
    for (unsigned i = source->table_count; i-- > 0;) {
        const struct table *table = source->tables[i];
        if (variant % table->row_count && is_shared(table))
            return false;
        variant /= table->row_count;
    }
    return true;
}

static void play_rows(const struct source *source)
{
    for (unsigned i = 0; i < source_variants(source) && bad < ENOUGH; i++) {
        if (!is_chosen(source, i))
            continue;
        program_make(&program, source, i, !source->has_twin);
        if (is_played())
            play_lives();
    }
}

/* Ends the process if it cannot watch the layer. */
static void watch_layer(void)
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

int main(int argc, char **argv)
{
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    setvbuf(stdout, NULL, _IOLBF, 0);
    const char *missing = argc < 3 ? "PLATFORM FOLDER..." : platform_open(&platform, argv[1]);
    if (missing) {
        fprintf(stderr, "%s\n", missing);
        return 2;
    }
    watch_layer();
    for (int i = 2; i < argc; i++)
        sources_read_all(&sources, argv[i]);
    for (unsigned i = 0; i < sources.count; i++)
        play_rows(&sources.items[i]);
    printf("%u lives, for %lu allocations; %u programs ended badly\n", lives, allocations, bad);
    /* Too few lives are no success, either. */
    const bool is_part = getenv("ASSAY_SCARCE_FILTER") || getenv("ASSAY_SCARCE_AT");
    return bad || lives < (is_part ? 1 : 100);
}
