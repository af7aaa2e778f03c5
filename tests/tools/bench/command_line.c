/* SPDX-License-Identifier: Apache-2.0 */
/* Reading a command line. */
#include "command_line.h"

#include <stdio.h>
#include <stdlib.h>

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

uint32_t command_line_count(const struct command_line *line, const char *text)
{
    char *end;
    uint32_t number = command_line_number(line, text, &end);
    if (*end)
        command_line_wrong(line, "not a number", text);
    return number;
}

static void read_option(const struct command_line *line, void *options, int option)
{
    switch (option) {
    case 'h':
        fputs(line->usage, stdout);
        exit(0);
    case '?': /* getopt has said what is wrong */
        fprintf(stderr, "\n%s", line->usage);
        exit(2);
    default:
        line->read_option(options, option);
    }
}

void command_line_read(const struct command_line *line, void *options, int argc, char **argv)
{
    int option;
    while ((option = getopt_long(argc, argv, "", line->names, NULL)) != -1)
        read_option(line, options, option);
    if (optind < argc)
        command_line_wrong(line, "unknown argument", argv[optind]);
}
