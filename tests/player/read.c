/* SPDX-License-Identifier: Apache-2.0 */
/* Reads files of programs. */
#include "tests/player/program.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    struct sources *sources;
    char *group;
    unsigned number; /* of the line */
    struct source_line *common;
    unsigned common_count;
    struct definition *definitions;
    struct table *tables;
    struct source *source; /* NULL: the lines are common */
};

_Noreturn void program_fail(const char *group, unsigned number, const char *what)
{
    fprintf(stderr, "%s.cases:%u: %s\n", group, number, what);
    exit(2);
}

static void require(const struct reader *reader, bool is_good, const char *what)
{
    if (!is_good)
        program_fail(reader->group, reader->number, what);
}

static void *grow(const struct reader *reader, void *items, size_t count, size_t size)
{
    void *grown = realloc(items, (count + 1) * size);
    require(reader, grown != NULL, "out of memory");
    return grown;
}

static char *after(char *line, const char *word)
{
    size_t length = strlen(word);
    return strncmp(line, word, length) == 0 ? line + length : NULL;
}

/* ---- tables and definitions */

static char *trim(char *text)
{
    text += strspn(text, " ");
    for (size_t length = strlen(text); length && text[length - 1] == ' ';)
        text[--length] = '\0';
    return text;
}

/* Splits at " | ". Returns the number of cells. */
static unsigned split_cells(const struct reader *reader, char *text, const char **cells)
{
    unsigned count = 0;
    while (text) {
        char *end = strstr(text, "| ");
        if (end)
            *end = '\0';
        require(reader, count <= TABLE_COLUMNS, "too many columns");
        cells[count] = trim(text);
        if (strcmp(cells[count], "-") == 0)
            cells[count] = "";
        count++;
        text = end ? end + 2 : NULL;
    }
    return count;
}

static void begin_table(struct reader *reader, char *text)
{
    const char *cells[TABLE_COLUMNS + 1];
    struct table *table = calloc(1, sizeof(*table));
    require(reader, table != NULL, "out of memory");
    table->column_count = split_cells(reader, text, cells) - 1;
    table->name = cells[0];
    memcpy(table->columns, cells + 1, sizeof(table->columns));
    table->next = reader->tables;
    reader->tables = table;
}

static void add_row(const struct reader *reader, char *text)
{
    const char *cells[TABLE_COLUMNS + 1];
    struct table *table = reader->tables;
    require(reader, table != NULL, "a row without a table");
    const unsigned count = split_cells(reader, text, cells);
    require(reader, count == table->column_count + 1, "a row needs a cell for each column");
    table->rows = grow(reader, table->rows, table->row_count, sizeof(*table->rows));
    struct table_row *row = &table->rows[table->row_count++];
    row->name = cells[0];
    memcpy(row->values, cells + 1, sizeof(row->values));
}

static void add_definition(struct reader *reader, char *text)
{
    struct definition *definition = calloc(1, sizeof(*definition));
    char *end = text + strcspn(text, " (");
    require(reader, definition != NULL && *end, "define NAME TEXT");
    *definition = (struct definition){text, "", end + 1, reader->definitions};
    if (*end == '(') {
        char *close = strchr(end, ')');
        require(reader, close && close[1] == ' ', "define NAME(PARAMETERS) TEXT");
        definition->parameters = end + 1;
        definition->text = close + 2;
        *close = '\0';
    }
    *end = '\0';
    reader->definitions = definition;
}

/* ---- cases */

static const struct table *find_table(const struct reader *reader, const char *name)
{
    const struct table *table = reader->tables;
    while (table && strcmp(table->name, name) != 0)
        table = table->next;
    require(reader, table != NULL, "there is no such table");
    return table;
}

/* Cuts a text at the first "; " that stands in no brackets and quotation marks. Returns what is
 * behind it, or NULL. */
static char *cut_line(char *text)
{
    int depth = 0;
    bool is_quoted = false;
    for (char *at = text; *at; at++) {
        is_quoted ^= *at == '"';
        if (!is_quoted)
            depth += (strchr("([{", *at) != NULL) - (strchr(")]}", *at) != NULL);
        if (!is_quoted && depth == 0 && at[0] == ';' && at[1] == ' ') {
            *at = '\0';
            return at + 2;
        }
    }
    return NULL;
}

static void begin_case(struct reader *reader, char *name)
{
    struct sources *sources = reader->sources;
    char *tables = strstr(name, " for each ");
    sources->items = grow(reader, sources->items, sources->count, sizeof(*sources->items));
    struct source *source = reader->source = &sources->items[sources->count++];
    *source = (struct source){.group = reader->group, .name = name};
    if (tables) {
        *tables = '\0';
        for (char *word = strtok(tables + strlen(" for each "), " "); word;
             word = strtok(NULL, " ")) {
            if (strcmp(word, "and") == 0)
                continue;
            require(reader, source->table_count < SOURCE_TABLES, "too many tables");
            source->tables[source->table_count++] = find_table(reader, word);
        }
    }
    for (unsigned i = 0; i < reader->common_count; i++) {
        source->lines = grow(reader, source->lines, i, sizeof(*source->lines));
        source->lines[source->line_count++] = reader->common[i];
    }
    source->definitions = reader->definitions;
}

static void add_line(struct reader *reader, char *line)
{
    struct source_line added = {' ', line, reader->number};
    if (*line == '+' || *line == '-') {
        added.mark = *line;
        added.text = line + 1 + strspn(line + 1, " ");
    }
    if (!reader->source) {
        reader->common =
            grow(reader, reader->common, reader->common_count, sizeof(*reader->common));
        reader->common[reader->common_count++] = added;
        return;
    }
    struct source *source = reader->source;
    source->lines = grow(reader, source->lines, source->line_count, sizeof(*source->lines));
    source->lines[source->line_count++] = added;
    source->definitions = reader->definitions;
}

/* Adds lines that stand in one. */
static void add_lines(struct reader *reader, char *text)
{
    while (text) {
        char *next = cut_line(text);
        add_line(reader, text);
        text = next;
    }
}

/* Cuts off what stands behind a colon. */
static char *cut_at_colon(char *text)
{
    char *colon = strstr(text, ": ");
    if (!colon)
        return NULL;
    *colon = '\0';
    return colon + 2;
}

static void read_line(struct reader *reader, char *line)
{
    char *rest;
    if (*line == '\0' || *line == '#')
        return;
    if ((rest = after(line, "case "))) {
        char *lines = cut_at_colon(rest);
        begin_case(reader, rest);
        add_lines(reader, lines);
    } else if ((rest = after(line, "define "))) {
        add_definition(reader, rest);
    } else if ((rest = after(line, "each "))) {
        begin_table(reader, rest);
    } else if ((rest = after(line, "row "))) {
        add_row(reader, rest);
    } else if (strcmp(line, "common") == 0 || after(line, "common: ")) {
        reader->source = NULL;
        reader->common_count = 0;
        add_lines(reader, cut_at_colon(line));
    } else {
        add_line(reader, line);
    }
}

/* Cuts off the first line, to which the lines below it belong that begin with four blanks. Returns
 * what is behind them, or NULL, and the count of these lines. */
static char *take_line(char *text, unsigned *count)
{
    static const char joint[] = "\n    ";
    char *end = strchr(text, '\n');
    for (*count = 1; end && strncmp(end, joint, strlen(joint)) == 0; ++*count) {
        *end = ' ';
        memmove(end + 1, end + strlen(joint), strlen(end + strlen(joint)) + 1);
        end = strchr(end, '\n');
    }
    if (!end)
        return NULL;
    *end = '\0';
    return end + 1;
}

static char *read_text(const struct reader *reader, const char *path)
{
    enum { TEXT_MAX = 1 << 18 };
    char *text = calloc(1, TEXT_MAX);
    FILE *file = fopen(path, "r");
    require(reader, file && text, "cannot be read");
    size_t size = fread(text, 1, TEXT_MAX - 1, file);
    require(reader, size < TEXT_MAX - 1, "is too long");
    fclose(file);
    return text;
}

/* Whether the broken program of a source differs from the repaired one, which it does if and only
 * if it has a mistake. */
static bool has_twin(const struct reader *reader, const struct source *source, unsigned variant)
{
    static struct program broken, repaired;
    bool is_other = false, has_mistake = false;
    program_make(&broken, source, variant, false);
    program_make(&repaired, source, variant, true);
    is_other = broken.line_count != repaired.line_count;
    for (unsigned i = 0; i < broken.line_count && !is_other; i++)
        is_other = strcmp(broken.lines[i].text, repaired.lines[i].text) != 0;
    for (unsigned i = 0; i < broken.expected_count; i++)
        has_mistake |= !broken.expected[i].is_plain;
    has_mistake |= program_find(&broken, "breaks", NULL) != NULL;
    if (is_other != has_mistake) {
        char what[256];
        snprintf(what, sizeof(what), "%s: %s", repaired.name,
                 has_mistake ? "`expect` and `breaks` need +, - or {WRONG / RIGHT}"
                             : "+, - or {WRONG / RIGHT} needs `expect` or `breaks`");
        require(reader, false, what);
    }
    return has_mistake;
}

static void check_twins(const struct reader *reader, unsigned first)
{
    for (unsigned i = first; i < reader->sources->count; i++) {
        struct source *source = &reader->sources->items[i];
        source->has_twin = has_twin(reader, source, 0);
        for (unsigned j = 1; j < source_variants(source); j++)
            require(reader, has_twin(reader, source, j) == source->has_twin,
                    "a table has rows with mistakes, and rows without");
    }
}

void sources_read(struct sources *sources, const char *path, const char *group)
{
    struct reader reader = {.sources = sources,
                            .group = strdup(group),
                            .definitions = sources->definitions,
                            .tables = sources->tables};
    unsigned first = sources->count;
    unsigned count = 1;
    for (char *line = read_text(&reader, path), *next; line; line = next) {
        reader.number += count;
        next = take_line(line, &count);
        read_line(&reader, line);
    }
    check_twins(&reader, first);
    free(reader.common);
    if (sources->count == first) /* no program has it */
        free(reader.group);
    if (strcmp(strrchr(group, '/'), "/common") == 0) {
        sources->definitions = reader.definitions;
        sources->tables = reader.tables;
    }
}

/* ---- folders */

enum { FILES_MAX = 64 }; /* of a folder */

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Lists the names in a folder, sorted. Returns their number. */
static unsigned list_folder(const char *path, char *names[FILES_MAX])
{
    DIR *folder = opendir(path);
    unsigned count = 0;
    for (const struct dirent *entry; folder && (entry = readdir(folder)) && count < FILES_MAX;)
        if (entry->d_name[0] != '.')
            names[count++] = strdup(entry->d_name);
    if (folder)
        closedir(folder);
    qsort(names, count, sizeof(names[0]), compare_names);
    return count;
}

/* Cases that implicit_cases.py has written. */
static void read_generated(struct sources *sources, const char *chosen)
{
    static const char group[] = "calls/implicit";
    if (!chosen || strncmp(group, chosen, strlen(chosen)) == 0)
        sources_read(sources, GENERATED_CASES, group);
}

static const char *root(void)
{
    const char *folder = getenv("ASSAY_PROGRAMS"); /* where scripts/nvidia has packed them */
    return folder ? folder : PROGRAMS_FOLDER;
}

/* Reads a file of a folder, unless its name does not begin with the chosen one. */
static void read_file(struct sources *sources, const char *folder, const char *name,
                      const char *chosen, bool reads_common)
{
    char path[1024], group[256];
    const char *end = strstr(name, ".cases");
    if (!end)
        return;
    snprintf(path, sizeof(path), "%s/%s/%s", root(), folder, name);
    snprintf(group, sizeof(group), "%s/%.*s", folder, (int)(end - name), name);
    const bool is_common = strcmp(name, "common.cases") == 0;
    if (is_common == reads_common &&
        (!chosen || strncmp(group, chosen, is_common ? strlen(folder) : strlen(chosen)) == 0))
        sources_read(sources, path, group);
}

void sources_read_all(struct sources *sources, const char *chosen)
{
    char *folders[FILES_MAX], *files[FILES_MAX], path[1024];
    const unsigned folder_count = list_folder(root(), folders);
    snprintf(path, sizeof(path), "%s/common.cases", root());
    sources_read(sources, path, "./common");
    struct definition *const definitions = sources->definitions;
    for (unsigned i = 0; i < folder_count; i++) {
        snprintf(path, sizeof(path), "%s/%s", root(), folders[i]);
        const unsigned file_count = list_folder(path, files);
        sources->definitions = definitions;
        sources->tables = NULL;
        for (unsigned j = 0; j < file_count; j++)
            read_file(sources, folders[i], files[j], chosen, true);
        for (unsigned j = 0; j < file_count; j++) {
            read_file(sources, folders[i], files[j], chosen, false);
            free(files[j]);
        }
        if (strcmp(folders[i], "calls") == 0 && !getenv("ASSAY_PROGRAMS"))
            read_generated(sources, chosen);
        free(folders[i]);
    }
    if (!sources->count) {
        fprintf(stderr, "no programs in %s/%s\n", root(), chosen ? chosen : "");
        exit(2);
    }
}
