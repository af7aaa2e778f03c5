/* SPDX-License-Identifier: Apache-2.0 */
/* What shaders must have read and written, as far as that is certain:
 *
 * - A command certainly traces rays, and no top-level structure that it may trace is visible to it:
 *   whichever it traces, it reads too early. Or nothing has built the structure.
 * - If there is only one such structure, builds that overwrite it must wait, and neither it nor
 * what its instances refer to may be destroyed meanwhile.
 * - A shader uses a descriptor statically whose structure was destroyed.
 * - A build reads data that have changed since an earlier build read the same bytes, and no access
 *   that is known can have written them. So a shader did, and no write by shaders since then is
 *   visible to the build.
 *
 * One thread at a time, without a lock, as src/hazards/hazards.h. If memory runs out, something is
 * not told. */
#ifndef ASSAY_LAYER_HAZARDS_EXECUTED_SHADERS_H
#define ASSAY_LAYER_HAZARDS_EXECUTED_SHADERS_H

#include "src/base/handle_table.h"
#include "src/base/unknown.h"
#include "src/hazards/hazards.h"
#include "src/report/reporter.h"
#include "src/state/order/clock.h"
#include "src/state/resources/destroyed.h"

enum {
    GONE_KEPT = 64,   /* destroyed top-level structures; the oldest ones are forgotten */
    TRACED_KEPT = 16, /* structures that a command may trace; more are unknown */
};

/* Elements that a build has read: vertices, boxes or instances. */
struct data_read {
    struct hazard_bytes bytes; /* from the first to the last one */
    uint64_t stride, size; /* between elements, and of each; what lies between them is not read */
    uint64_t hash;         /* of the elements */
};

/* A command that traced a structure: its access, and its batch. */
struct top_trace {
    struct hazard_side side; /* number 0: none is certain */
    struct timestamp batch;
    uint64_t untracked; /* of the batch */
};

/* The structure or one of its references, which is destroyed, or without memory. */
struct destroyed_structure {
    uint64_t structure; /* 0: none */
    bool is_freed;      /* its memory was freed */
    char name[DESTROYED_NAME_SIZE];
};

struct top_level {
    uint32_t index;            /* in trace_search.tops */
    uint64_t structure;        /* handle */
    struct hazard_bytes first; /* its first byte */
    bool is_built;             /* by a build; else by a copy: it may not be top-level */
    bool is_gone;              /* it was destroyed, and descriptor sets may still hold it */
    /* The build's command, by its first access; the build's position in the command buffer; and
     * when it executed. */
    uint64_t command;
    uint32_t position;
    struct timestamp batch;
    /* What its instances refer to, as far as it is known; owned. */
    struct top_reference {
        uint64_t structure; /* handle */
        uint64_t memory;    /* id */
    } * references;
    uint32_t reference_count, reference_capacity;
    bool is_sorted;         /* the references, by structure */
    struct top_trace trace; /* the last one */
    uint64_t changed;       /* one of the references that was written since; 0: none */
    struct destroyed_structure destroyed;
};

struct trace_search {
    struct reporter *reporter; /* counts what is forgotten */
    struct hazards *hazards;
    struct top_level **tops;       /* owned */
    struct handle_table by_handle; /* the same */
    uint32_t top_count, top_capacity, gone_count;
    struct top_level *last_built; /* by trace_search_add_reference(); NULL: none */
    struct unknown tops_unknown;  /* others may exist */
    /* What the current command may trace: these, if there are any; else each structure. */
    struct {
        struct top_level *tops[TRACED_KEPT];
        uint32_t count;
        uint32_t unbuilt_count; /* structures that nothing has built */
        uint64_t unbuilt;       /* the last one of them */
        bool is_unknown;        /* nothing is certain */
    } traced;
    struct handle_table inputs; /* what builds have read, by id of memory + 1 */
    uint32_t input_count;
    /* See hazards_first_open_write(); 0: not yet known for the current command. */
    uint64_t first_open;
};

/* `search` is zero-initialized. */
void trace_search_begin(struct trace_search *search, struct reporter *reporter,
                        struct hazards *hazards);
void trace_search_end(struct trace_search *search);

/* The next command begins. */
void trace_search_begin_command(struct trace_search *search);

/* A top-level structure was written. Without memory (id 0): one that is not known. */
void trace_search_add_top(struct trace_search *search, const struct top_level *top);
/* A structure was destroyed. `destroyed`: as it will be reported; NULL if that is done. */
void trace_search_end_top(struct trace_search *search, uint64_t structure,
                          const struct destroyed_structure *destroyed);
/* An instance of the build at `position`, in the command whose first access is `command`, refers to
 * a structure. References of one build follow each other. */
void trace_search_add_reference(struct trace_search *search, uint64_t command, uint32_t position,
                                const struct top_reference *reference);
bool top_level_refers(struct top_level *top, uint64_t structure);
/* Removes the references to a structure, or into memory. Returns the handle of the first one; 0 if
 * there was none. */
uint64_t top_level_drop(struct top_level *top, uint64_t structure, uint64_t memory);
/* Returns NULL if there is none. */
struct top_level *trace_search_find_top(const struct trace_search *search, uint64_t structure);
/* Returns the structure of that handle which lies there (without memory: which was destroyed), or
 * NULL. */
struct top_level *trace_search_find_top_at(const struct trace_search *search, uint64_t structure,
                                           const struct hazard_bytes *first);
/* The current command may trace a structure, which lies there, and others only if this is called
 * for them, too. Without a call it may trace all. `is_alive`: it still lies there now. */
void trace_search_add_traced(struct trace_search *search, uint64_t structure,
                             const struct hazard_bytes *first, bool is_alive);
/* The next access of the current command traces rays. Returns whether it does so too early; then
 * fills `hazard`. */
bool trace_search_trace(struct trace_search *search, enum access_kind kind, struct hazard *hazard);
/* Returns the structure that a command traces, whichever it is; NULL if that is unknown. */
struct top_level *trace_search_only_top(struct trace_search *search);
/* Returns the structure that a command traces and that nothing has built; 0: that is not certain.
 */
uint64_t trace_search_unbuilt(const struct trace_search *search);

/* An access of that number writes bytes of a structure, and does not build it. */
void trace_search_overwrite(struct trace_search *search, const struct hazard_access *write,
                            uint64_t structure, uint64_t number);

/* The bytes were written by an access that is known. */
void trace_search_write(struct trace_search *search, const struct hazard_bytes *bytes);
/* The current command has read data, by an access of that kind. Returns whether a shader wrote them
 * too late; then fills `hazard`. */
bool trace_search_read(struct trace_search *search, enum access_kind kind,
                       const struct data_read *data, struct hazard *hazard);
void trace_search_forget_memory(struct trace_search *search, uint64_t memory);
/* Forgets all that builds have read. */
void trace_search_forget_inputs(struct trace_search *search);

#endif
