/* SPDX-License-Identifier: Apache-2.0 */
/* Reading a command line. */
#include "command_line.h"

#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#include "scripts/tools/fail.h"

enum { MOST_OPTIONS = 16 };

_Noreturn void command_line_wrong(const struct command_line *line, const char *what,
                                  const char *value)
{
    fprintf(stderr, "%s: %s: %s\n\n%s", line->program, what, value, line->usage);
    exit(2);
}

uint32_t command_line_number(const struct command_line *line, const char *text, char **end)
{
    unsigned long number = strtoul(text, end, 10);
    if (*end == text || number == 0 || number > 10000000)
        command_line_wrong(line, "not a number from 1 to 10000000", text);
    return (uint32_t)number;
}

void command_line_count(const struct command_line *line, const char *value, void *member)
{
    char *end;
    *(uint32_t *)member = command_line_number(line, value, &end);
    if (*end)
        command_line_wrong(line, "not a number", value);
}

void command_line_text(const struct command_line *line, const char *value, void *member)
{
    *(const char **)member = value;
}

void command_line_set(const struct command_line *line, const char *value, void *member)
{
    *(bool *)member = true;
}

void command_line_clear(const struct command_line *line, const char *value, void *member)
{
    *(bool *)member = false;
}

static bool is_choice(const char *choices, const char *value)
{
    size_t length;
    for (;; choices += length + 1) {
        length = strcspn(choices, "|");
        if (strlen(value) == length && strncmp(choices, value, length) == 0)
            return true;
        if (!choices[length])
            return false;
    }
}

void command_line_read(const struct command_line *line, void *options, int argc, char **argv)
{
    struct option names[MOST_OPTIONS + 2] = {{"help", no_argument, NULL, 'h'}};
    int found, which;
    for (uint32_t i = 0; i < line->option_count; i++)
        names[1 + i] = (struct option){line->options[i].name, line->options[i].has_value, NULL, 0};
    while ((found = getopt_long(argc, argv, "", names, &which)) != -1) {
        if (found == 'h') {
            fputs(line->usage, stdout);
            exit(0);
        }
        if (found == '?') { /* getopt has said what is wrong */
            fprintf(stderr, "\n%s", line->usage);
            exit(2);
        }
        const struct command_line_option *option = &line->options[which - 1];
        if (option->choices && !is_choice(option->choices, optarg))
            command_line_wrong(line, "unknown name", optarg);
        option->read(line, optarg, (char *)options + option->member);
    }
    if (optind < argc)
        command_line_wrong(line, "unknown argument", argv[optind]);
}
