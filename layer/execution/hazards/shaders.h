/* SPDX-License-Identifier: Apache-2.0 */
/* What shaders must have read and written. Descriptors and code are not followed, so this tells two
 * mistakes only:
 *
 * - A command that traces rays executes, and no top-level structure is visible to it: whichever it
 *   traces, it reads too early.
 * - A build reads data that have changed since an earlier build read the same bytes, and no access
 *   that is known can have written them. So a shader did, and no write by shaders since then is
 *   visible to the build.
 *
 * One thread at a time, without a lock, as src/hazards/hazards.h. If memory runs out, something is
 * not told. */
#ifndef ASSAY_LAYER_EXECUTION_HAZARDS_SHADERS_H
#define ASSAY_LAYER_EXECUTION_HAZARDS_SHADERS_H

#include "src/base/handle_table.h"
#include "src/hazards/hazards.h"

enum { TOP_LEVELS_KEPT = 64 };

/* Elements that a build has read: vertices, boxes or instances. */
struct data_read {
    struct hazard_bytes bytes; /* from the first to the last one */
    uint64_t stride, size; /* between elements, and of each; what lies between them is not read */
    uint64_t hash;         /* of the elements */
};

struct shader_judge {
    struct hazards *hazards;
    struct top_level {
        uint64_t structure;        /* handle */
        struct hazard_bytes first; /* its first byte */
        bool is_built;             /* by a build; else by a copy, and perhaps not top-level */
    } tops[TOP_LEVELS_KEPT];
    uint32_t top_count;
    bool lacks_tops;            /* others may exist */
    struct handle_table inputs; /* what builds have read, by id of memory + 1 */
    uint32_t input_count;
    /* See hazards_first_open_write(); 0: not yet known for the current command. */
    uint64_t first_open;
};

/* `judge` is zero-initialized. */
void shader_judge_begin(struct shader_judge *judge, struct hazards *hazards);
void shader_judge_end(struct shader_judge *judge);

/* The next command begins. */
void shader_judge_begin_command(struct shader_judge *judge);

/* A top-level structure was written. Without memory (id 0): one that is not known. */
void shader_judge_add_top(struct shader_judge *judge, const struct top_level *top);
void shader_judge_remove_top(struct shader_judge *judge, uint64_t structure);
/* The current command traces rays. Returns whether it does so too early; then fills `hazard`. */
bool shader_judge_trace(struct shader_judge *judge, enum access_kind kind, struct hazard *hazard);

/* The bytes were written by an access that is known. */
void shader_judge_write(struct shader_judge *judge, const struct hazard_bytes *bytes);
/* The current command has read data, by an access of that kind. Returns whether a shader wrote them
 * too late; then fills `hazard`. */
bool shader_judge_read(struct shader_judge *judge, enum access_kind kind,
                       const struct data_read *data, struct hazard *hazard);
void shader_judge_forget_memory(struct shader_judge *judge, uint64_t memory);

#endif
