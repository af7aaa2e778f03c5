/* SPDX-License-Identifier: Apache-2.0 */
/* Makes programs of what files say: replaces what stands for other text, and splits lines. */
#include "tests/player/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT_SIZE = 4096, ARGUMENTS = 8, DEPTH = 16 };

struct expander {
    struct program *program;
    const struct source *source;
    unsigned variant, number, depth;
    bool is_repaired;
};

/* Arguments of the definition whose text is being replaced. */
struct arguments {
    const char *names; /* "A, B" */
    char values[ARGUMENTS][256];
};

static _Noreturn void fail(const struct expander *expander, const char *what)
{
    program_fail(expander->source ? expander->source->group : "generated", expander->number, what);
}

static char *keep(struct program *program, const char *text, size_t length)
{
    char *kept = program->storage + program->used;
    if (program->used + length + 1 > sizeof(program->storage)) {
        fprintf(stderr, "a program is too long\n");
        exit(2);
    }
    memcpy(kept, text, length);
    kept[length] = '\0';
    program->used += length + 1;
    return kept;
}

/* ---- $NAME, ${NAME} and $NAME(ARGUMENTS) */

static size_t name_length(const char *text)
{
    return strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789");
}

static bool is_name(const char *name, const char *text, size_t length)
{
    return strncmp(name, text, length) == 0 && name[length] == '\0';
}

static const char *find_argument(const struct arguments *arguments, const char *name, size_t length)
{
    const char *at = arguments ? arguments->names : "";
    for (unsigned i = 0; *at; i++) {
        size_t size = name_length(at);
        if (size == length && strncmp(at, name, length) == 0)
            return arguments->values[i];
        at += size;
        at += strspn(at, ", ");
    }
    return NULL;
}

static unsigned row_of(const struct source *source, unsigned table, unsigned variant)
{
    for (unsigned i = source->table_count - 1; i > table; i--)
        variant /= source->tables[i]->row_count;
    return variant % source->tables[table]->row_count;
}

static const char *find_cell(const struct expander *expander, const char *name, size_t length)
{
    for (unsigned i = 0; i < expander->source->table_count; i++) {
        const struct table *table = expander->source->tables[i];
        for (unsigned j = 0; j < table->column_count; j++)
            if (is_name(table->columns[j], name, length))
                return table->rows[row_of(expander->source, i, expander->variant)].values[j];
    }
    return NULL;
}

static void replace(struct expander *expander, const char *text, const struct arguments *arguments,
                    char *to, size_t *used);

static void append(const struct expander *expander, char *to, size_t *used, const char *text,
                   size_t length)
{
    if (*used + length >= TEXT_SIZE)
        fail(expander, "the line is too long");
    memcpy(to + *used, text, length);
    *used += length;
    to[*used] = '\0';
}

/* Returns the length of an argument, which may have commas in brackets. */
static size_t argument_length(const char *text)
{
    const char *at = text;
    for (int depth = 0; *at && (depth > 0 || (*at != ',' && *at != ')')); at++)
        depth += (strchr("([{", *at) != NULL) - (strchr(")]}", *at) != NULL);
    return (size_t)(at - text);
}

/* Reads "(a, b)", in which names are replaced, too. Returns what is behind it. */
static const char *read_arguments(struct expander *expander, const char *text,
                                  const struct arguments *outer, struct arguments *to)
{
    text += *text == '(';
    for (unsigned i = 0; *text != ')'; i++) {
        char value[TEXT_SIZE] = "", raw[256];
        size_t used = 0;
        text += strspn(text, ", ");
        const size_t length = argument_length(text);
        if (i == ARGUMENTS || length >= sizeof(raw) || !text[length])
            fail(expander, "arguments without an end");
        snprintf(raw, sizeof(raw), "%.*s", (int)length, text);
        replace(expander, raw, outer, value, &used);
        snprintf(to->values[i], sizeof(to->values[i]), "%.255s", value);
        text += length;
    }
    return text + 1;
}

/* Replaces one name. Returns what is behind it. */
static const char *replace_name(struct expander *expander, const char *name,
                                const struct arguments *arguments, char *to, size_t *used)
{
    const bool is_in_braces = *name == '{';
    name += is_in_braces;
    const size_t length = name_length(name);
    const char *behind = name + length + is_in_braces;
    const char *text = find_argument(arguments, name, length);
    struct arguments inner = {.names = ""};
    if (!text)
        text = find_cell(expander, name, length);
    for (const struct definition *definition = expander->source->definitions; definition && !text;
         definition = definition->next) {
        if (!is_name(definition->name, name, length))
            continue;
        text = definition->text;
        inner.names = definition->parameters;
        if (*inner.names)
            behind = read_arguments(expander, behind, arguments, &inner);
    }
    if (!text || expander->depth == DEPTH) {
        char what[128];
        snprintf(what, sizeof(what), text ? "$%.*s contains itself" : "$%.*s is not defined",
                 (int)length, name);
        fail(expander, what);
    }
    expander->depth++;
    replace(expander, text, &inner, to, used);
    expander->depth--;
    return behind;
}

static void replace(struct expander *expander, const char *text, const struct arguments *arguments,
                    char *to, size_t *used)
{
    while (*text) {
        size_t length = strcspn(text, "$");
        append(expander, to, used, text, length);
        text += length;
        if (*text)
            text = replace_name(expander, text + 1, arguments, to, used);
    }
}

/* The end of what begins with a brace, and the slash in it, or NULL: then it is a block of an edit.
 */
static char *close_brace(const struct expander *expander, char *open, char **middle)
{
    int depth = 0;
    *middle = NULL;
    for (char *at = open; *at; at++) {
        depth += (strchr("([{", *at) != NULL) - (strchr(")]}", *at) != NULL);
        if (depth == 1 && !*middle && *at == '/')
            *middle = at;
        if (depth == 0)
            return at;
    }
    fail(expander, "{WRONG / RIGHT}");
}

/* {WRONG / RIGHT}: a part of the line that only the broken, or the repaired program has. Returns
 * whether there is one.
 */
static bool choose(const struct expander *expander, char *text)
{
    bool found = false;
    for (char *open = text; (open = strchr(open, '{'));) {
        char *middle, *close = close_brace(expander, open, &middle);
        if (!middle) {
            open++;
            continue;
        }
        const char *from = expander->is_repaired ? middle + 1 : open + 1;
        const char *end = expander->is_repaired ? close : middle;
        from += strspn(from, " ");
        while (end > from && end[-1] == ' ')
            end--;
        const size_t length = from < end ? (size_t)(end - from) : 0;
        memmove(open, from, length);
        memmove(open + length, close + 1, strlen(close + 1) + 1);
        found = true;
    }
    return found;
}

/* ---- lines */

static void add_expectation(const struct expander *expander, const char *text, int line,
                            bool is_plain)
{
    struct program *program = expander->program;
    const char *colon = strstr(text, ": ");
    if (!colon || program->expected_count == PROGRAM_EXPECTATIONS)
        fail(expander, "expect ID: TEXT");
    program->expected[program->expected_count++] =
        (struct expectation){keep(program, text, (size_t)(colon - text)),
                             keep(program, colon + 2, strlen(colon + 2)), line, is_plain};
}

/* Takes off " expect ..." and " says ...", of which a line may have several. */
static void cut_expectations(const struct expander *expander, char *text, int line)
{
    static const char *const words[] = {" expect ", " says "};
    for (;;) {
        char *last = NULL;
        unsigned found = 0;
        for (unsigned i = 0; i < 2; i++)
            for (char *at = strstr(text, words[i]); at; at = strstr(at + 1, words[i]))
                if (!last || at > last) {
                    last = at;
                    found = i;
                }
        if (!last)
            return;
        add_expectation(expander, last + strlen(words[found]), line, found == 1);
        *last = '\0';
    }
}

static void split(struct program_line *line, char *text)
{
    unsigned count = 0;
    char *rest = NULL;
    for (char *word = strtok_r(text, " ", &rest); word && count < PROGRAM_WORDS;
         word = strtok_r(NULL, " ", &rest))
        line->words[count++] = word;
    line->words[count] = NULL;
    if (count > 1 && strcmp(line->words[count - 2], "returns") == 0) {
        line->result = line->words[count - 1];
        line->words[count - 2] = NULL;
    }
}

/* c0 OPTIONS: COMMANDS is begin c0 OPTIONS; COMMANDS; end */
static bool is_recording(const char *text)
{
    const char *colon = strstr(text, ": ");
    return text[0] == 'c' && text[1] >= '0' && text[1] <= '9' && colon &&
           strcspn(text, ";") > (size_t)(colon - text);
}

struct program_line *program_add(struct program *program, const char *text, unsigned number)
{
    char words[2 * TEXT_SIZE] = "";
    size_t used = 0;
    struct program_line *line = &program->lines[program->line_count];
    if (++program->line_count > PROGRAM_LINES) {
        fprintf(stderr, "a program has too many lines\n");
        exit(2);
    }
    *line = (struct program_line){.text = keep(program, text, strlen(text)), .number = number};
    const bool records = is_recording(text);
    const char *colon = records ? strstr(text, ": ") : NULL;
    if (records)
        used = (size_t)snprintf(words, sizeof(words), "begin ");
    for (; *text && used < sizeof(words) - 16; text++)
        if (*text == ';' || text == colon)
            used += (size_t)snprintf(words + used, sizeof(words) - used, " ; ");
        else
            words[used++] = *text;
    snprintf(words + used, sizeof(words) - used, "%s", records ? " ; end" : "");
    split(line, keep(program, words, strlen(words)));
    return line;
}

void program_note_result(struct program *program, unsigned line, const char *result)
{
    char text[TEXT_SIZE];
    const int length =
        snprintf(text, sizeof(text), "%s returns %s", program->lines[line].text, result);
    program->lines[line].text = keep(program, text, (size_t)length);
    program->lines[line].result = result;
}

static void add_line(struct expander *expander, const struct source_line *source)
{
    struct program *program = expander->program;
    char text[TEXT_SIZE] = "";
    size_t used = 0;
    expander->number = source->number;
    replace(expander, source->text, NULL, text, &used);
    const bool is_changed = choose(expander, text) || source->mark != ' ';
    if (strncmp(text, "expect ", 7) == 0) {
        add_expectation(expander, text + 7, -1, false);
    } else if (strncmp(text, "says ", 5) == 0) {
        add_expectation(expander, text + 5, -1, true);
    } else {
        const bool is_below = text[0] == ' ';
        cut_expectations(expander, text, (int)program->line_count - is_below);
        if (strspn(text, " ") != strlen(text))
            program_add(program, text, source->number)->is_changed = is_changed;
    }
}

unsigned source_variants(const struct source *source)
{
    unsigned count = 1;
    for (unsigned i = 0; i < source->table_count; i++)
        count *= source->tables[i]->row_count;
    return count;
}

static void name_program(struct program *program, unsigned variant)
{
    const struct source *source = program->source;
    size_t length = (size_t)snprintf(program->name, sizeof(program->name), "%s: %s", source->group,
                                     source->name);
    for (unsigned i = 0; i < source->table_count; i++)
        length += (size_t)snprintf(program->name + length, sizeof(program->name) - length, "/%s",
                                   source->tables[i]->rows[row_of(source, i, variant)].name);
    snprintf(program->name + length, sizeof(program->name) - length, "%s",
             source->has_twin && program->is_repaired ? " (repaired)" : "");
}

void program_make(struct program *program, const struct source *source, unsigned variant,
                  bool is_repaired)
{
    struct expander expander = {program, source, variant, 0, 0, is_repaired};
    program->source = source;
    program->variant = variant;
    program->is_repaired = is_repaired;
    program->line_count = program->expected_count = 0;
    program->used = 0;
    name_program(program, variant);
    for (unsigned i = 0; i < source->line_count; i++)
        if (source->lines[i].mark != (is_repaired ? '-' : '+'))
            add_line(&expander, &source->lines[i]);
    if (program_find(program, "closes", NULL) && !program_find(program, "close", NULL))
        program_add(program, "close", expander.number);
}

const struct program_line *program_find(const struct program *program, const char *first,
                                        const char *second)
{
    for (unsigned i = 0; i < program->line_count; i++) {
        char *const *words = program->lines[i].words;
        if (words[0] && strcmp(words[0], first) == 0 &&
            (!second || (words[1] && strcmp(words[1], second) == 0)))
            return &program->lines[i];
    }
    return NULL;
}
