/* SPDX-License-Identifier: Apache-2.0 */
/* What the command lines of the benchmarks have in common: a table says what each option sets. */
#ifndef BENCH_COMMAND_LINE_H
#define BENCH_COMMAND_LINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

struct command_line;

/* Reads an option's value into a member of the options; `value` is NULL if the option has none. */
typedef void command_line_reader(const struct command_line *line, const char *value, void *member);

struct command_line_option {
    const char *name;
    command_line_reader *read;
    size_t member;       /* its offset in the options */
    bool has_value;      /* --name value */
    const char *choices; /* the values that it may have, as "one|other"; NULL: any */
};

/* The options of one program. Every program also has --help. */
struct command_line {
    const char *program, *usage;
    const struct command_line_option *options;
    uint32_t option_count;
};

/* Reads all of it. The process ends where it is wrong, or asks for help. */
void command_line_read(const struct command_line *line, void *options, int argc, char **argv);

/* Ends the process. */
_Noreturn void command_line_wrong(const struct command_line *line, const char *what,
                                  const char *value);

/* The number that a text begins with, and where that ends. */
uint32_t command_line_number(const struct command_line *line, const char *text, char **end);

command_line_reader command_line_count; /* a uint32_t */
command_line_reader command_line_text;  /* a const char * */
command_line_reader command_line_set;   /* a bool: true */
command_line_reader command_line_clear; /* a bool: false */

#endif
