/* SPDX-License-Identifier: Apache-2.0 */
/* Programs of Vulkan commands as text, with what the layer must report. docs/contributing.md has
 * the notation. A file (NAME.cases) is read to sources; a source becomes a program for each choice
 * of rows of its tables, and for its twin. */
#ifndef ASSAY_TESTS_PLAYER_PROGRAM_H
#define ASSAY_TESTS_PLAYER_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>

enum {
    PROGRAM_WORDS = 256,
    PROGRAM_LINES = 256,
    PROGRAM_EXPECTATIONS = 256,
    PROGRAM_STORAGE = 96 * 1024,
    SOURCE_TABLES = 3, /* of one case */
    TABLE_COLUMNS = 10,
};

/* ---- what a file says */

struct source_line {
    char mark;        /* '+': in the repaired program alone; '-': in the broken one alone; ' ' */
    const char *text; /* without the mark */
    unsigned number;  /* in the file */
};

/* define NAME[(PARAMETERS)] TEXT: $NAME stands for the text. */
struct definition {
    const char *name, *parameters, *text; /* parameters: "" or "A, B" */
    struct definition *next;
};

/* each NAME | COLUMN ...: a case that names the table is played for each row, in which $COLUMN
 * stands for the row's text. */
struct table {
    const char *name;
    const char *columns[TABLE_COLUMNS];
    unsigned column_count, row_count;
    struct table_row {
        const char *name, *values[TABLE_COLUMNS];
    } * rows;
    struct table *next;
};

struct source {
    const char *group, *name;  /* group: the file, with its folder */
    struct source_line *lines; /* those that are common to the file's cases come first */
    unsigned line_count;
    const struct table *tables[SOURCE_TABLES];
    unsigned table_count;
    const struct definition *definitions; /* of the file */
    bool has_twin;                        /* something is marked, or in braces */
};

struct sources {
    struct source *items;
    unsigned count;
    /* The definitions of common.cases, for the other files of the folder, or for all folders. */
    struct definition *definitions;
    struct table *tables;
};

/* Adds the cases of a file, which stay allocated. A mistake in the file ends the process. */
void sources_read(struct sources *sources, const char *path, const char *group);
/* Adds those of a folder, or of all folders; `chosen`: FOLDER, FOLDER/FILE, or NULL. */
void sources_read_all(struct sources *sources, const char *chosen);

/* ---- what is played */

struct program_line {
    const char *text;               /* as it is printed, without what is expected */
    char *words[PROGRAM_WORDS + 1]; /* commands with ";" between them; NULL behind the last */
    const char *result;             /* that `returns` names, or NULL */
    unsigned number;                /* in the file */
    bool is_changed;                /* the twin has no such line, or another one */
};

/* expect ID: TEXT ... TEXT. ID is the end of a message's id, or the name of a rule. */
struct expectation {
    const char *id, *text;
    int line;      /* index of the line that has to report it; -1: any line */
    bool is_plain; /* `says`: no mistake, so that the twin reports it, too */
};

struct program {
    const struct source *source; /* NULL: the program was generated */
    char name[192];
    unsigned variant; /* of the source */
    bool is_repaired;
    struct program_line lines[PROGRAM_LINES];
    unsigned line_count;
    struct expectation expected[PROGRAM_EXPECTATIONS];
    unsigned expected_count;
    char storage[PROGRAM_STORAGE]; /* of all texts */
    size_t used;
};

/* How many programs a source has for one twin, and the one of that index. */
unsigned source_variants(const struct source *source);
void program_make(struct program *program, const struct source *source, unsigned variant,
                  bool is_repaired);
/* Adds a line to a program that is generated. */
struct program_line *program_add(struct program *program, const char *text, unsigned number);
/* The line returns this result. */
void program_note_result(struct program *program, unsigned line, const char *result);
/* Whether a line begins with these words; NULL: any second one. */
const struct program_line *program_find(const struct program *program, const char *first,
                                        const char *second);

/* Ends the process, because a file is wrong. */
_Noreturn void program_fail(const char *group, unsigned number, const char *what);

#endif
