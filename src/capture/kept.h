/* SPDX-License-Identifier: Apache-2.0 */
/* The lines of what was built before a capture begins: for each live structure those that a replay
 * needs to build it. Their arrays are held in memory by the folder.
 *
 * The caller serializes access. */
#ifndef ASSAY_CAPTURE_KEPT_H
#define ASSAY_CAPTURE_KEPT_H

#include "src/capture/folder.h"

struct capture_kept {
    struct handle_table structures; /* lists of lines, by the id of the structure */
};

/* A command has written the structure `dst`, from `src` or, if that is 0, anew. Without memory,
 * nothing is kept of the structure. */
void capture_kept_add(struct capture_kept *kept, struct capture_folder *folder, uint64_t dst,
                      uint64_t src, const char *line, size_t size);
/* The structure is destroyed. */
void capture_kept_remove(struct capture_kept *kept, struct capture_folder *folder, uint64_t id);
/* Writes what is kept of a structure, once, and numbers the lines. */
void capture_kept_write(struct capture_kept *kept, struct capture_folder *folder, uint64_t id,
                        uint64_t *number);
void capture_kept_release(struct capture_kept *kept);

#endif
