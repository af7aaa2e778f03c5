/* SPDX-License-Identifier: Apache-2.0 */
/* A program that prints the tables for scripts: one line for each id, fields separated by tabs. */
#include <stdio.h>
#include <string.h>

#include "vuid-tables/rules.h"

static const char *or_dash(const char *text)
{
    return text ? text : "-";
}

static void print_columns(const struct rule_info *row, enum vuid vuid)
{
    const char *separator = "";
    for (int command = 0; command < COMMAND_COUNT; command++) {
        if (row->vuid[command] != vuid)
            continue;
        printf("%s%s", separator, build_command_name((enum build_command)command));
        separator = ",";
    }
}

static void print_retired(enum vuid vuid)
{
    const char *first = vuid_retired(vuid, 0);
    printf("%s", or_dash(first));
    for (unsigned n = 1; vuid_retired(vuid, n); n++)
        printf(",%s", vuid_retired(vuid, n));
}

int main(int argc, char **argv)
{
    if (argc != 1) {
        FILE *out = strcmp(argv[1], "--help") == 0 ? stdout : stderr;
        fprintf(out,
                "usage: vuid_dump\n"
                "prints a line for each id in scope, with tabs between these fields: id, "
                "rule, subject, level, capability that the rule waits for, commands, retired ids, "
                "hint\n");
        return out == stderr;
    }

    for (int vuid = VUID_NONE + 1; vuid < VUID_COUNT; vuid++) {
        const struct rule_info *row = &rule_infos[rule_of_vuid((enum vuid)vuid)];
        printf("%s\t%s\t%s\t%s\t%s\t", vuid_texts[vuid].id, row->name, or_dash(row->subject),
               level_name(row->level), or_dash(row->waits_for));
        print_columns(row, (enum vuid)vuid);
        putchar('\t');
        print_retired((enum vuid)vuid);
        printf("\t%s\n", or_dash(row->hint));
    }
    return fflush(stdout) != 0;
}
