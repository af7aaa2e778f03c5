/* SPDX-License-Identifier: Apache-2.0 */
/* programs_test PLATFORM FOLDER[/FILE]...: plays programs (tests/programs) with memory running out.
 * Messages that a program expects may be missing then, but no others come. ASSAY_SCARCE_FILTER is a
 * part of the names of the programs to play. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lives.h"
#include "tests/player/play.h"

static struct platform platform;
static struct program program;
static struct sources sources;
static struct play play;

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
 * cannot query what was not built. */
static bool depends_on_backend(void)
{
    return platform.is_cpu && (has_words("fitting", NULL) || has_words("scratch", "build") ||
                               has_words("scratch", "update") || has_words("host", "query"));
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

int main(int argc, char **argv)
{
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    setvbuf(stdout, NULL, _IOLBF, 0);
    const char *missing = argc < 3 ? "PLATFORM FOLDER..." : platform_open(&platform, argv[1]);
    if (missing) {
        fprintf(stderr, "%s\n", missing);
        return 2;
    }
    lives_open();
    for (int i = 2; i < argc; i++)
        sources_read_all(&sources, argv[i]);
    for (unsigned i = 0; i < sources.count && !lives_are_enough(); i++) {
        program_make(&program, &sources.items[i], 0, !sources.items[i].has_twin);
        if (is_played())
            lives_play(program.name, live);
    }
    return lives_close(getenv("ASSAY_SCARCE_FILTER") ? 0 : 100);
}
