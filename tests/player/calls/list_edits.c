/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the edits of the programs of calls, for edits.py: their file, and the line. */
#include <stdio.h>
#include <string.h>

#include "tests/player/program.h"

static void print_edits(const struct source *source, unsigned variant, bool is_repaired)
{
    static struct program program;
    program_make(&program, source, variant, is_repaired);
    for (unsigned i = 0; i < program.line_count; i++) {
        const char *text = program.lines[i].text;
        if (strncmp(text, "edit ", 5) == 0 || strncmp(text, "configure ", 10) == 0)
            printf("%s\t%s\n", source->group, text);
    }
}

int main(void)
{
    static struct sources sources;
    sources_read_all(&sources, "calls");
    for (unsigned i = 0; i < sources.count; i++)
        for (unsigned j = 0; j < source_variants(&sources.items[i]); j++) {
            print_edits(&sources.items[i], j, false);
            print_edits(&sources.items[i], j, true);
        }
    return 0;
}
