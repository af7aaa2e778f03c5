/* SPDX-License-Identifier: Apache-2.0 */
/* The fuzz target of calls: bytes become a program (tests/programs), which the player plays on the
 * null driver, without a loader. Only a crash, or what a sanitizer finds, is a failure: the program
 * is printed then, as a case that tests/programs can keep. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fuzz.h"
#include "tests/fixture/linked.h"
#include "tests/player/play.h"

enum { TEXT_SIZE = 2048, LINES = 90, DEPTH_MAX = 12 };

static const char *const grammar[] = {
#define RULE(name, ...) ":" #name, __VA_ARGS__,
#include "grammar.def"
#undef RULE
    NULL};

/* ---- bytes to text */

struct expansion {
    const uint8_t *at, *end;
    char text[TEXT_SIZE];
    size_t used;
    unsigned depth;
};

static uint8_t take(struct expansion *expansion)
{
    return expansion->at < expansion->end ? *expansion->at++ : 0;
}

/* The first alternative of a rule. */
static const char *const *find_rule(const char *name, size_t length)
{
    const char *const *at = grammar;
    while (*at && !((*at)[0] == ':' && strncmp(*at + 1, name, length) == 0 && !(*at)[1 + length]))
        at++;
    if (!*at) {
        fprintf(stderr, "the grammar has no rule %.*s\n", (int)length, name);
        abort();
    }
    return at + 1;
}

/* Appends a text of a rule. Deep within others it is the first one. */
static void expand(struct expansion *expansion, const char *name, size_t length)
{
    const char *const *rule = find_rule(name, length);
    unsigned count = 0;
    while (rule[count] && rule[count][0] != ':')
        count++;
    const bool is_deep = expansion->depth++ >= DEPTH_MAX;
    const char *text = rule[count == 1 || is_deep ? 0 : take(expansion) % count];
    while (*text) {
        const char *end = *text == '<' ? strchr(text, '>') : NULL;
        if (end) {
            expand(expansion, text + 1, (size_t)(end - text) - 1);
            text = end + 1;
        } else if (expansion->used < TEXT_SIZE - 1) {
            expansion->text[expansion->used++] = *text++;
        } else {
            break;
        }
    }
    expansion->depth--;
}

/* ---- the program */

static struct program program;

static void add_lines(struct expansion *expansion, const char *rule)
{
    expansion->used = 0;
    expand(expansion, rule, strlen(rule));
    expansion->text[expansion->used] = '\0';
    for (char *line = expansion->text, *next; line; line = next) {
        next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        program_add(&program, line, program.line_count + 1);
    }
}

static void make_program(const uint8_t *data, size_t size)
{
    struct expansion expansion = {.at = data, .end = data + size};
    program.source = NULL;
    program.line_count = program.expected_count = 0;
    program.used = 0;
    snprintf(program.name, sizeof(program.name), "found by fuzz_programs");
    add_lines(&expansion, "head");
    const char *rule = program_find(&program, "only", "cpu") ? "line" : "driver_line";
    while (expansion.at < expansion.end && program.line_count < LINES &&
           program.used < sizeof(program.storage) / 2)
        add_lines(&expansion, rule);
}

/* ---- what is printed when it crashes */

/* The null driver's settings are the case's own, and so are those of the layer. */
static void print_case(void)
{
    dprintf(STDERR_FILENO, "\ncase %s\n", program.name);
    for (unsigned i = 0; i < program.line_count; i++)
        dprintf(STDERR_FILENO, "%s\n", program.lines[i].text);
}

static void print_once(void)
{
    static volatile sig_atomic_t is_printed;
    if (!is_printed)
        print_case();
    is_printed = 1;
}

void fuzz_programs_crash(int number)
{
    print_once();
    signal(number, SIG_DFL);
    raise(number);
}

/* The sanitizers call these. */
void __asan_on_error(void);
void __ubsan_on_report(void);

void __asan_on_error(void)
{
    print_once();
}

void __ubsan_on_report(void)
{
    print_once();
}

/* ---- the target */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct platform platform;
    static struct play play;
    make_program(data, size);
    if (getenv("ASSAY_FUZZ_PRINT"))
        print_case();
    linked_open(&platform, program_find(&program, "only", "cpu"));
    memset(&play, 0, sizeof(play));
    play.platform = &platform;
    play_program(&play, &program);
    if (play.report.outcome == OUTCOME_SKIPPED) {
        fprintf(stderr, "the null driver lacks %s\n", play.report.text);
        abort();
    }
    play_close(&play);
    return 0;
}
