/* SPDX-License-Identifier: Apache-2.0 */
/* Reads cases. */
#include "cases.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    struct hazard_cases *cases;
    const char *group;
    unsigned number; /* of the line */
};

static void require(const struct reader *reader, bool is_good, const char *what)
{
    if (is_good)
        return;
    fprintf(stderr, "%s.cases:%u: %s\n", reader->group, reader->number, what);
    exit(2);
}

static struct hazard_case *begin_case(struct reader *reader, const char *name)
{
    struct hazard_cases *cases = reader->cases;
    cases->items = realloc(cases->items, (cases->count + 1) * sizeof(*cases->items));
    require(reader, cases->items, "out of memory");
    struct hazard_case *item = &cases->items[cases->count++];
    *item = (struct hazard_case){.name = name, .group = reader->group};
    return item;
}

static void add_expectation(const struct reader *reader, struct hazard_case *item, char *line)
{
    char *text = strstr(line, ": ");
    require(reader, text && item->expected_count < CASE_EXPECTATIONS, "expect ID: TEXT");
    *text = '\0';
    item->expected[item->expected_count++] = (struct case_expectation){line, text + 2};
}

static void add_line(const struct reader *reader, struct hazard_case *item, char *line)
{
    require(reader, item->line_count < CASE_LINES, "too many lines");
    struct case_line *added = &item->lines[item->line_count++];
    unsigned count = 0;
    added->number = reader->number;
    added->mark = *line == '+' || *line == '-' ? *line++ : ' ';
    for (char *word = strtok(line, " "); word; word = strtok(NULL, " ")) {
        require(reader, count < CASE_WORDS, "too many words");
        added->words[count++] = word;
    }
    require(reader, count, "a line without words");
}

static char *after(char *line, const char *word)
{
    size_t length = strlen(word);
    return strncmp(line, word, length) == 0 ? line + length : NULL;
}

static void read_line(struct reader *reader, char *line)
{
    char *rest;
    if (*line == '\0' || *line == '#')
        return;
    if ((rest = after(line, "case "))) {
        begin_case(reader, rest);
        return;
    }
    require(reader, reader->cases->count, "a line before the first case");
    struct hazard_case *item = &reader->cases->items[reader->cases->count - 1];
    if ((rest = after(line, "expect ")))
        add_expectation(reader, item, rest);
    else if ((rest = after(line, "level ")))
        item->level = rest;
    else
        add_line(reader, item, line);
}

static char *read_text(const struct reader *reader, const char *folder)
{
    enum { TEXT_MAX = 1 << 18 };
    char path[512], *text = calloc(1, TEXT_MAX);
    snprintf(path, sizeof(path), "%s/%s.cases", folder, reader->group);
    FILE *file = fopen(path, "r");
    require(reader, file && text, "cannot be read");
    size_t size = fread(text, 1, TEXT_MAX - 1, file);
    require(reader, size < TEXT_MAX - 1, "is too long");
    fclose(file);
    return text;
}

/* Broken and repaired program must differ. */
static void check_cases(const struct reader *reader, unsigned first)
{
    for (unsigned i = first; i < reader->cases->count; i++) {
        const struct hazard_case *item = &reader->cases->items[i];
        bool has_twin = false;
        for (unsigned j = 0; j < item->line_count; j++)
            has_twin |= item->lines[j].mark != ' ';
        require(reader, has_twin == (item->expected_count > 0), item->name);
    }
}

void cases_read(struct hazard_cases *cases, const char *folder, const char *group)
{
    struct reader reader = {.cases = cases, .group = group};
    unsigned first = cases->count;
    for (char *line = read_text(&reader, folder), *next; line; line = next) {
        next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        reader.number++;
        read_line(&reader, line);
    }
    check_cases(&reader, first);
}

bool case_text_matches(const char *text, const char *wanted)
{
    while (*wanted) {
        const char *end = strstr(wanted, " ... ");
        size_t length = end ? (size_t)(end - wanted) : strlen(wanted);
        char part[256];
        snprintf(part, sizeof(part), "%.*s", (int)length, wanted);
        text = strstr(text, part);
        if (!text)
            return false;
        text += length;
        wanted = end ? end + strlen(" ... ") : wanted + length;
    }
    return true;
}
