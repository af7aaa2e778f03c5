/* SPDX-License-Identifier: Apache-2.0 */
/* What a recording does to acceleration structures, in recorded order, to be replayed at each
 * submission; or what one command of the host does, in no order.
 *
 * Only its command buffer, whose use the application synchronizes, changes a journal, and only
 * while nobody else holds it: a submission, or a primary command buffer that executes it, shares
 * it, and the next recording then begins another.
 *
 * It keeps no more than can be asked later: 128 bytes a build at most, and 32 for each buffer that
 * the build is the first of its neighbours to read. */
#ifndef ASSAY_STATE_COMMANDS_JOURNAL_H
#define ASSAY_STATE_COMMANDS_JOURNAL_H

#include "src/base/chunk_list.h"
#include "src/state/builds/built.h"
#include "src/state/commands/label_stack.h"
#include "src/state/commands/used_range.h"
#include "src/state/order/clock.h"
#include "vuid-tables/rules.h"

enum journal_kind {
    JOURNAL_BUILD,
    JOURNAL_UPDATE,
    JOURNAL_COPY,    /* a clone, or a compacting copy */
    JOURNAL_COMPACT, /* as the latter */
    JOURNAL_FILL,    /* dst gets contents from memory: a deserialization */
    JOURNAL_EXECUTE, /* a secondary command buffer */
    /* A build, whose own entry comes behind, reads a micromap: src. A JOURNAL_FILL of a
     * VkMicromapEXT is whatever writes that. */
    JOURNAL_USE_MICROMAP,
    JOURNAL_RANGES, /* those of a call that uses sparse buffers; comes behind its builds */
    JOURNAL_BIND,   /* dst: a sparse buffer, src: memory */
    /* Queries of compacted sizes; their ids are those of query_pools.h. */
    JOURNAL_QUERY,         /* dst_id: the query, src: the structure */
    JOURNAL_RESET_QUERIES, /* by the host; dst_id: the first, info: how many */
    JOURNAL_ANSWER,        /* the host read `size`; src: the structure, or src_id: the query */
    /* dst: a VkEvent. Waits are noted that may be up to the host (events.h). */
    JOURNAL_SET_EVENT,
    JOURNAL_RESET_EVENT,
    JOURNAL_WAIT_EVENT,
};

/* How a build uses a micromap. */
struct journal_micromap {
    uint32_t position; /* of the build in the command buffer */
    uint32_t geometry;
    uint32_t first, triangle_count; /* see struct micromap_use */
    bool is_ext, is_unindexed;
    bool must_stay;               /* an update, which may not change micromaps */
    uint64_t updated, updated_id; /* what the update reads, as src; 0: it is none */
};

struct journal_entry {
    unsigned char kind;          /* enum journal_kind */
    unsigned char command;       /* enum build_command of builds and updates; of copies it tells
                                    COMMAND_NV from others */
    bool judged;                 /* an update that recording could judge by itself */
    bool dst_backed, src_backed; /* by memory, as far as that was known when it was recorded */
    bool geometry_by_pointer;    /* of ppGeometries */
    bool dst_is_sparse, src_is_sparse; /* of a sparse buffer */
    uint32_t info;                     /* index in pInfos, of builds and updates */
    uint32_t labels;                   /* see journal_note_labels */
    /* Structures by handle (of VkAccelerationStructureNV for COMMAND_NV) and by id; the id tells a
     * handle that was reused. */
    uint64_t dst, src;
    uint64_t dst_id, src_id;
    union {
        struct built built; /* a build: what dst becomes; an update: what it asked for */
        struct journal *secondary;
        struct noted_ranges *ranges; /* owned */
        struct {
            VkDeviceSize offset, size, memory_offset;
        } binding;
        struct journal_micromap micromap;
        VkDeviceSize size;
    };
};

/* What an address that a build uses is to it. */
enum input_role {
    INPUT_VERTEX,
    INPUT_INDEX,
    INPUT_TRANSFORM,
    INPUT_AABBS,
    INPUT_INSTANCES,
    INPUT_MOTION_VERTEX,
    INPUT_SPHERE_VERTEX,
    INPUT_SPHERE_RADIUS,
    INPUT_SPHERE_INDEX,
    INPUT_SWEPT_VERTEX,
    INPUT_SWEPT_RADIUS,
    INPUT_SWEPT_INDEX,
    INPUT_MICROMAP_DATA,
    INPUT_MICROMAP_TRIANGLES,
    INPUT_OPACITY_INDEX,
    INPUT_OPACITY_EXT_INDEX,
    INPUT_DENSE_DATA,
    INPUT_SCRATCH,
    INPUT_UPDATE_SCRATCH,
    INPUT_INDIRECT, /* build ranges */
};

struct journal_input {
    uint64_t buffer_id; /* see struct address_facts */
    union {
        VkDeviceAddress address;
        VkBuffer buffer; /* for COMMAND_NV */
    };
    uint32_t position; /* of the build in the command buffer */
    uint32_t info;
    uint32_t geometry;
    unsigned char role;    /* enum input_role */
    unsigned char command; /* enum build_command */
    bool geometry_by_pointer;
};

enum { JOURNAL_RECENT_INPUTS = 32 };

/* What the host knew when it began a command of its own: which batches had executed, and which had
 * been submitted. */
struct host_view {
    struct execution_clock executed, submitted;
};

struct journal {
    atomic_uint references;
    VkCommandBuffer command_buffer; /* null: a command of the host */
    struct host_view *host;         /* of a command of the host that reads; else NULL */
    uint64_t destroy_count;         /* resources_destroy_count when recording began */
    struct chunk_list entries, inputs;
    struct label_stack *labels; /* each that builds were recorded under */
    uint32_t label_count, label_capacity, label_changes;
    uint64_t recent_inputs[JOURNAL_RECENT_INPUTS]; /* buffer ids, by their low bits */
    /* What a backend will carry out when the journal has its turn; or NULL. */
    void *work;
    void (*release_work)(void *work);
    bool binds;                /* it has entries JOURNAL_BIND, and no others */
    bool has_references;       /* entries hold something that must be released */
    bool has_sources_to_check; /* entries ask what a structure was built with, see
                                  journal_entry_has_source_to_check */
    bool executes;             /* entries execute secondary command buffers */
    bool has_events;           /* its own, or those of secondaries */
    bool incomplete; /* entries were lost for lack of memory: the rest tells nothing for sure */
};

/* NULL without memory. */
struct journal *journal_create(VkCommandBuffer command_buffer);
struct journal *journal_share(struct journal *journal);
void journal_release(struct journal *journal);
bool journal_is_shared(const struct journal *journal);

/* Whether it is, or executes, the other: which may not execute it, then. */
bool journal_contains(const struct journal *journal, const struct journal *other);

/* Whether what an entry means depends on what its source was built with. */
static inline bool journal_entry_has_source_to_check(const struct journal_entry *entry)
{
    return entry->kind == JOURNAL_UPDATE || entry->kind == JOURNAL_COPY ||
           entry->kind == JOURNAL_COMPACT || entry->kind == JOURNAL_USE_MICROMAP;
}

static inline bool journal_entry_has_references(const struct journal_entry *entry)
{
    if (entry->kind == JOURNAL_BUILD || entry->kind == JOURNAL_UPDATE)
        return entry->built.shapes || entry->built.compacted_size;
    return entry->kind == JOURNAL_EXECUTE || entry->kind == JOURNAL_RANGES;
}

/* The place of one more entry, to be filled by the caller, who hands it to journal_end_entry then;
 * NULL without memory, and the journal is incomplete. The entry takes over the references of
 * `built`, or of `secondary`, or `ranges`. */
static inline struct journal_entry *journal_begin_entry(struct journal *journal)
{
    struct journal_entry *entry;
    if (!chunk_list_make_room(&journal->entries, sizeof(*entry))) {
        journal->incomplete = true;
        return NULL;
    }
    entry = (void *)journal->entries.next;
    journal->entries.next += sizeof(*entry);
    return entry;
}

/* May be left out for what neither asks nor holds anything. */
static inline void journal_end_entry(struct journal *journal, const struct journal_entry *entry)
{
    journal->has_references |= journal_entry_has_references(entry);
    journal->has_sources_to_check |= journal_entry_has_source_to_check(entry);
}

/* The same for an entry that is made elsewhere: without memory its references are released. */
void journal_add(struct journal *journal, const struct journal_entry *entry);

void journal_add_binding(struct journal *journal, const struct sparse_binding *binding);
struct sparse_binding journal_binding(const struct journal_entry *entry);

/* Keeps the labels that are open, unless they were kept lately. Returns what finds them again; 0:
 * none. */
uint32_t journal_keep_labels(struct journal *journal, const struct label_stack *labels);
static inline uint32_t journal_note_labels(struct journal *journal,
                                           const struct label_stack *labels)
{
    return labels->count ? journal_keep_labels(journal, labels) : 0;
}
/* Those of the build at a position; NULL: none. */
const struct label_stack *journal_labels_at(const struct journal *journal, uint32_t position);

/* Inputs: some are begun and ended together, CHUNK_ITEMS_AT_ONCE at most. Returns the place of the
 * first; NULL without memory: that is one mistake that goes unseen, nothing more. */
static inline struct journal_input *journal_begin_inputs(struct journal *journal)
{
    bool has_room = chunk_list_make_room(&journal->inputs, sizeof(struct journal_input));
    return has_room ? (void *)journal->inputs.next : NULL;
}

/* Whether the use of a buffer is to be noted: unless it was noted lately. */
static inline bool journal_notes_buffer(struct journal *journal, uint64_t buffer_id)
{
    uint64_t *recent = &journal->recent_inputs[buffer_id % JOURNAL_RECENT_INPUTS];
    bool is_new = *recent != buffer_id;
    *recent = buffer_id;
    return is_new;
}

/* `end` is behind the last of those that were filled. */
static inline void journal_end_inputs(struct journal *journal, struct journal_input *end)
{
    journal->inputs.next = (char *)end;
}

/* A place in a journal: what was added after it can be walked, or taken back. */
struct journal_mark {
    struct chunk_place entries, inputs;
};

static inline struct journal_mark journal_mark(const struct journal *journal)
{
    return (struct journal_mark){chunk_list_end(&journal->entries),
                                 chunk_list_end(&journal->inputs)};
}
void journal_take_back(struct journal *journal, const struct journal_mark *mark);

/* Where the entries, or the inputs, are walked. */
struct journal_cursor {
    const struct chunk_list *list;
    struct chunk_place place;
};

struct journal_cursor journal_start(const struct journal *journal);
struct journal_cursor journal_start_after(const struct journal *journal,
                                          const struct journal_mark *mark);
struct journal_cursor journal_start_inputs(const struct journal *journal);
/* The next; NULL at the end. */
struct journal_entry *journal_next(struct journal_cursor *cursor);
const struct journal_input *journal_next_input(struct journal_cursor *cursor);

/* Empties it; its memory is kept for what is recorded next. */
void journal_clear(struct journal *journal);

#endif
