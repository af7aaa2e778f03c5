/* SPDX-License-Identifier: Apache-2.0 */
/* A journal lists what a command buffer does to acceleration structures, in recorded order; each
 * submission replays it. The journal of one host command has no order.
 *
 * Only the journal's command buffer changes it, and only while the journal is not shared; the
 * application synchronizes use of the command buffer. A submission, or a primary command buffer
 * that executes the journal's command buffer, shares the journal. The next recording then begins a
 * new journal.
 *
 * An entry takes 128 bytes at most. An input takes 32 bytes; builds that follow each other and read
 * the same buffer add one input. */
#ifndef ASSAY_STATE_COMMANDS_JOURNAL_H
#define ASSAY_STATE_COMMANDS_JOURNAL_H

#include "src/base/chunk_list.h"
#include "src/state/builds/built.h"
#include "src/state/commands/label_stack.h"
#include "src/state/commands/used_range.h"
#include "src/state/order/clock.h"
#include "vuid-tables/rules.h"

struct call_site;
struct hazard_list;

enum journal_kind {
    JOURNAL_BUILD,
    JOURNAL_UPDATE,
    JOURNAL_COPY,       /* a clone */
    JOURNAL_COMPACT,    /* a compacting copy */
    JOURNAL_FILL,       /* dst is written from memory: a deserialization; any write of a micromap */
    JOURNAL_EXECUTE,    /* a secondary command buffer */
    JOURNAL_PRIMITIVES, /* `size`: the number of primitives of the next build; for record_builds */
    JOURNAL_USE_MICROMAP, /* the build of a later entry reads the micromap src */
    JOURNAL_RANGES,       /* the ranges of a call that uses sparse buffers; after its builds */
    JOURNAL_BIND,         /* dst: a sparse buffer, src: memory */
    JOURNAL_CALL,         /* with call sites: before the builds of a call */
    /* Queries of compacted sizes, with the ids of query_pools.h. */
    JOURNAL_QUERY,         /* dst_id: the query, src: the structure */
    JOURNAL_RESET_QUERIES, /* by the host; dst_id: the first query, info: the number of queries */
    JOURNAL_ANSWER,        /* the host read `size`; src: the structure, or src_id: the query */
    /* dst: a VkEvent. Only waits that may have to wait for the host have an entry (events.h). */
    JOURNAL_SET_EVENT,
    JOURNAL_RESET_EVENT,
    JOURNAL_WAIT_EVENT,
};

/* What writes dst; the member `info` of a JOURNAL_FILL. */
enum journal_fill {
    FILL_READS_ACCEL, /* a deserialization of an acceleration structure */
    /* dst is a VkMicromapEXT. */
    FILL_BUILDS_MICROMAP,
    FILL_CLONES_MICROMAP,
    FILL_COMPACTS_MICROMAP,
    FILL_READS_MICROMAP,
};

/* How a build uses a micromap. */
struct journal_micromap {
    uint32_t position; /* of the build in the command buffer */
    uint32_t geometry;
    uint32_t first, triangle_count; /* see struct micromap_use */
    bool is_ext, is_unindexed;
    bool must_stay;               /* the build is an update that must not change micromaps */
    uint64_t updated, updated_id; /* src of the update; 0: the build is no update */
};

/* Who has called: the builds from a position in the command buffer on were recorded from a site. */
struct journal_call {
    uint32_t position;
    const struct call_site *site; /* lives as long as the device; NULL: unknown */
};

struct journal_entry {
    unsigned char kind;    /* enum journal_kind */
    unsigned char command; /* enum build_command; a copy only distinguishes COMMAND_NV */
    bool judged;           /* an update, or use of a micromap, that was validated at recording */
    bool dst_backed, src_backed;       /* known at recording to lie in live memory */
    bool geometry_by_pointer;          /* the geometry is in ppGeometries */
    bool dst_is_sparse, src_is_sparse; /* lies in a sparse buffer */
    uint32_t info;                     /* builds and updates: index in pInfos; JOURNAL_FILL: enum
                                        * journal_fill */
    uint32_t labels;                   /* see journal_note_labels */
    /* Structures by handle (VkAccelerationStructureNV for COMMAND_NV) and by id; the id changes if
     * the handle is reused. */
    uint64_t dst, src;
    uint64_t dst_id, src_id;
    union {
        struct built built; /* a build: the new state of dst; an update: its parameters */
        struct journal *secondary;
        struct noted_ranges *ranges; /* owned */
        struct {
            VkDeviceSize offset, size, memory_offset;
        } binding;
        struct journal_micromap micromap;
        struct journal_call call;
        VkDeviceSize size;
    };
};

/* The use that a build makes of an address. */
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

/* Which batches had certainly executed, and which had been submitted, when a host command began. */
struct host_view {
    struct execution_clock executed, submitted;
};

struct journal {
    atomic_uint references;
    uint32_t label_changes;         /* of the labels that were copied last */
    VkCommandBuffer command_buffer; /* null: a host command */
    struct host_view *host;         /* owned; NULL unless a host command that reads */
    uint64_t destroy_count;         /* resources_destroy_count when recording began */
    struct chunk_list entries, inputs;
    struct label_stack *labels; /* a copy of each label stack under which a build was recorded */
    uint32_t label_count, label_capacity;
    uint64_t recent_inputs[JOURNAL_RECENT_INPUTS]; /* buffer ids, by their low bits */
    /* Commands that a backend executes when the journal is replayed; owned, may be NULL. */
    void *work;
    void (*release_work)(void *work);
    struct hazard_list *hazards; /* owned; see journal_hazards() */
    bool binds;                  /* all entries are JOURNAL_BIND */
    bool has_references;         /* see journal_entry_has_references; or `hazards` is in use */
    bool has_sources_to_check;   /* see journal_entry_has_source_to_check */
    bool executes;               /* has JOURNAL_EXECUTE entries */
    bool has_events;             /* it or a secondary has event entries */
    bool incomplete;             /* memory ran out for entries: the others prove nothing */
};

/* Returns NULL if memory runs out. The caller owns one reference. */
struct journal *journal_create(VkCommandBuffer command_buffer);
/* Adds a reference, and returns `journal`. */
struct journal *journal_share(struct journal *journal);
/* Accepts NULL. */
void journal_release(struct journal *journal);
bool journal_is_shared(const struct journal *journal);

/* Whether `journal` is `other` or executes it; then `other` must not execute `journal`. */
bool journal_contains(const struct journal *journal, const struct journal *other);

/* Whether the validation of an entry depends on the build of its source. */
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

/* Returns a new entry, uninitialized. The caller sets all of it and then calls journal_end_entry.
 * The entry takes over the references in `built`, `secondary` or `ranges`. Returns NULL if memory
 * runs out; the journal is incomplete then. */
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

/* Not needed for an entry without references and without a source to check. */
static inline void journal_end_entry(struct journal *journal, const struct journal_entry *entry)
{
    journal->has_references |= journal_entry_has_references(entry);
    journal->has_sources_to_check |= journal_entry_has_source_to_check(entry);
}

/* Adds a copy of `entry` and takes over its references. Releases them if memory runs out. */
void journal_add(struct journal *journal, const struct journal_entry *entry);

void journal_add_binding(struct journal *journal, const struct sparse_binding *binding);
struct sparse_binding journal_binding(const struct journal_entry *entry);

/* Copies the open labels, unless the last copy equals them. Returns the value of
 * journal_entry.labels; 0: no labels, or memory ran out. */
uint32_t journal_keep_labels(struct journal *journal, const struct label_stack *labels);
static inline uint32_t journal_note_labels(struct journal *journal,
                                           const struct label_stack *labels)
{
    return labels->count ? journal_keep_labels(journal, labels) : 0;
}
/* Returns the label stack for a value of journal_entry.labels; NULL: no labels. */
static inline const struct label_stack *journal_label_stack(const struct journal *journal,
                                                            uint32_t labels)
{
    return labels ? &journal->labels[labels - 1] : NULL;
}
/* Returns the labels of the build at a position; NULL: none. They live as long as the entries. */
const struct label_stack *journal_labels_at(const struct journal *journal, uint32_t position);

/* Adds the site of a call that is about to add its builds, the first of them at `position`; NULL:
 * unknown. If memory runs out, the sites of earlier calls are forgotten, because the builds to come
 * must not be taken for theirs; the journal stays complete. */
void journal_note_call(struct journal *journal, uint32_t position, const struct call_site *site);
/* Returns the site of the call that recorded the build at a position; NULL: unknown. */
const struct call_site *journal_call_site_at(const struct journal *journal, uint32_t position);

/* Returns room for CHUNK_ITEMS_AT_ONCE inputs. The caller fills some of them and then calls
 * journal_end_inputs. Returns NULL if memory runs out; the journal stays complete, because an input
 * only serves to report destroyed buffers. */
static inline struct journal_input *journal_begin_inputs(struct journal *journal)
{
    bool has_room = chunk_list_make_room(&journal->inputs, sizeof(struct journal_input));
    return has_room ? (void *)journal->inputs.next : NULL;
}

/* Whether to add an input for a buffer: false if one was added recently. */
static inline bool journal_notes_buffer(struct journal *journal, uint64_t buffer_id)
{
    uint64_t *recent = &journal->recent_inputs[buffer_id % JOURNAL_RECENT_INPUTS];
    bool is_new = *recent != buffer_id;
    *recent = buffer_id;
    return is_new;
}

/* `end` points behind the last filled input. */
static inline void journal_end_inputs(struct journal *journal, struct journal_input *end)
{
    journal->inputs.next = (char *)end;
}

/* Returns the list of accesses and barriers, to be added to, and creates it if there is none.
 * Called only with setting `hazards`. Returns NULL if memory runs out; the journal is incomplete
 * then. */
struct hazard_list *journal_hazards(struct journal *journal);

/* A position in a journal. Later entries and inputs can be walked, or removed. */
struct journal_mark {
    struct chunk_place entries, inputs;
};

static inline struct journal_mark journal_mark(const struct journal *journal)
{
    return (struct journal_mark){chunk_list_end(&journal->entries),
                                 chunk_list_end(&journal->inputs)};
}
/* Removes all entries and inputs that were added after the mark. */
void journal_take_back(struct journal *journal, const struct journal_mark *mark);

/* A position in a walk over the entries, or the inputs. */
struct journal_cursor {
    const struct chunk_list *list;
    struct chunk_place place;
};

struct journal_cursor journal_start(const struct journal *journal);
struct journal_cursor journal_start_after(const struct journal *journal,
                                          const struct journal_mark *mark);
struct journal_cursor journal_start_inputs(const struct journal *journal);
/* Both return NULL at the end. */
struct journal_entry *journal_next(struct journal_cursor *cursor);
const struct journal_input *journal_next_input(struct journal_cursor *cursor);

/* Empties the journal. Keeps its memory for the next recording. */
void journal_clear(struct journal *journal);

#endif
