/* SPDX-License-Identifier: Apache-2.0 */
/* What the command lines of the benchmarks have in common. */
#ifndef BENCH_COMMAND_LINE_H
#define BENCH_COMMAND_LINE_H

#include <getopt.h>
#include <stdint.h>

/* Of one program; each names its options by a character. */
struct command_line {
    const char *program, *usage;
    const struct option *names; /* up to one whose name is NULL; "help" is 'h' */
    void (*read_option)(void *options, int option); /* its value is in optarg */
};

/* Reads all of it. The process ends where it is wrong, or asks for help. */
void command_line_read(const struct command_line *line, void *options, int argc, char **argv);

/* Ends the process. */
_Noreturn void command_line_wrong(const struct command_line *line, const char *what,
                                  const char *value);

/* The number that a text begins with, and where that ends; or that it is. */
uint32_t command_line_number(const struct command_line *line, const char *text, char **end);
uint32_t command_line_count(const struct command_line *line, const char *text);

#endif
