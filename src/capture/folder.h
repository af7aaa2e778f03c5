/* SPDX-License-Identifier: Apache-2.0 */
/* The folder of a capture: lines of JSON in builds.jsonl, and arrays that NumPy opens in data/.
 * docs/capture.md describes both.
 *
 * What is written stays valid if the process is killed: an array gets its name when it is complete,
 * before the line that names it. The caller serializes access. */
#ifndef ASSAY_CAPTURE_FOLDER_H
#define ASSAY_CAPTURE_FOLDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "src/base/handle_table.h"
#include "src/report/log/lines.h"

enum { CAPTURE_HASH_SIZE = 33 }; /* hexadecimal digits, and the terminating zero */

struct capture_folder {
    char path[LOG_PATH_SIZE];
    FILE *lines;   /* NULL: not open */
    char *pending; /* lines that are not written yet; owned */
    size_t pending_size;
    uint64_t written, limit;   /* bytes */
    struct handle_table known; /* the arrays that it has, by half of their hashes */
    struct handle_table held;  /* the arrays that are held in memory, likewise */
    bool holds;                /* new arrays are held */
    int error;                 /* of the first failure; nothing is written afterwards */
    bool is_full;              /* the limit is reached; the same */
};

/* The rows of an array, `size` bytes each, without gaps. `type` is a dtype as Python spells it, and
 * `columns` the rest of the shape, such as ", 3". */
struct capture_array {
    const char *type;
    char columns[24];
    uint64_t count, size;
    const void *rows;
};

/* Makes the folder, and the one that it is in. Returns 0 or an error number: EEXIST if the folder
 * has a capture. */
int capture_folder_open(struct capture_folder *folder, const char *path, uint64_t limit);
/* Accepts a folder that is not open. */
void capture_folder_close(struct capture_folder *folder);

/* Return false if nothing was written: folder->error or folder->is_full says why. Lines are in the
 * file once capture_folder_flush() returns, at the latest. */
bool capture_folder_add_line(struct capture_folder *folder, const char *line, size_t size);
bool capture_folder_flush(struct capture_folder *folder);
/* Numbers the line among those of commands: `line` is an object without n. `is_kept`: the command
 * ran before the capture began. */
bool capture_folder_add_command(struct capture_folder *folder, uint64_t number, bool is_kept,
                                const char *line, size_t size);
/* Writes the array unless the folder has it, and sets `hash`, which is the file's name. If the
 * folder holds new arrays, keeps it in memory instead, with one reference more. */
bool capture_folder_add_array(struct capture_folder *folder, const struct capture_array *array,
                              char hash[CAPTURE_HASH_SIZE]);

/* For all arrays that a line names: writes those that are held, or lets go of one reference to
 * each. */
bool capture_folder_write_held(struct capture_folder *folder, const char *line, size_t size);
void capture_folder_let_go(struct capture_folder *folder, const char *line, size_t size);

#endif
