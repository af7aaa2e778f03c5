/* SPDX-License-Identifier: Apache-2.0 */
/* A journal lists what a command buffer does to acceleration structures, in recorded order; each
 * submission replays it. The journal of one host command has no order. It is the only list: what
 * settings need of a command stands in it, too, or hangs on an entry.
 *
 * Only the journal's command buffer changes it, and only while the journal is not shared; the
 * application synchronizes use of the command buffer. A submission, or a primary command buffer
 * that executes the journal's command buffer, shares the journal. The next recording then begins a
 * new journal. An application may by mistake record further after a submission: a walk ends where
 * the journal ended when the walk was started, so it reads no entry that is being added.
 *
 * Entries have several sizes, JOURNAL_ENTRY_MAX bytes at most. An input takes 32 bytes; builds that
 * follow each other and read the same buffer add one input. */
#ifndef ASSAY_STATE_COMMANDS_JOURNAL_H
#define ASSAY_STATE_COMMANDS_JOURNAL_H

#include <limits.h>

#include "src/base/array.h"
#include "src/model/inputs.h"
#include "src/state/builds/built.h"
#include "src/state/builds/places.h"
#include "src/state/commands/label_stack.h"
#include "src/state/commands/used_range.h"
#include "src/state/order/clock.h"
#include "vuid-tables/rules.h"

struct bound_shaders;
struct call_site;
struct hazard_entry;
struct recent_memory;
struct recorded_build;
struct recorded_command;

/* Each entry begins with its kind and its size. */
enum journal_kind {
#define ENTRY(kind, event, type, use) kind,
#include "src/state/commands/journal_entries.def"
#undef ENTRY
    JOURNAL_KINDS,
};
_Static_assert(JOURNAL_KINDS <= UCHAR_MAX, "an entry has room for its kind");

/* What a command does with the structures of its entry. */
enum journal_use {
    NO_USE,
    READS_SRC = 1,
    WRITES_DST = 2,
    READS_AND_WRITES = READS_SRC | WRITES_DST,
};

/* A command sets or resets an event, or waits for it. */
enum journal_event_use { EVENT_SET, EVENT_RESET, EVENT_WAIT };

/* What writes dst; the member `info` of a JOURNAL_FILL. If it reads device memory, src_id is the
 * address; 0: the address was in no known buffer. */
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

/* What a command does with src: of a copy, and of JOURNAL_READ. */
struct journal_read {
    bool compacts;
    VkQueryType query;     /* VK_QUERY_TYPE_MAX_ENUM: it is no query */
    VkDeviceSize dst_size; /* of a copy, in bytes: the size that dst was created with, or, of a
                            * serialization, of the memory at the address dst; 0: unknown */
    uint32_t number;       /* of a query in its pool */
    /* The layer's own query for the compacted size of src of a compacting copy; null: none */
    VkQueryPool size_pool;
    uint32_t size_query;
};

/* Where builds were recorded, for messages. */
struct journal_origin {
    struct label_stack labels;    /* a copy */
    const struct call_site *site; /* lives as long as the device; NULL: unknown */
};

/* Where a structure lies, as known at recording. */
enum journal_backing {
    BACKED_BY_MEMORY = 1, /* in live memory */
    BACKED_BY_SPARSE = 2, /* in a sparse buffer */
};

struct journal_entry {
    unsigned char kind;    /* enum journal_kind */
    unsigned char size;    /* in units of JOURNAL_UNIT bytes; set by the journal */
    unsigned char command; /* enum build_command */
    bool judged;           /* has a source to check, and was validated at recording */
    unsigned char dst_backing, src_backing; /* of enum journal_backing */
    bool geometry_by_pointer;               /* the geometry is in ppGeometries */
    uint32_t info;   /* builds and updates: index in pInfos; JOURNAL_FILL: enum journal_fill;
                      * JOURNAL_READ: index of the structure in the query; see the other kinds */
    uint32_t origin; /* see journal_note_origin() */
    /* Structures by handle (see journal_entry_type) and by id; the id changes if the handle is
     * reused. */
    uint64_t dst, src;
    uint64_t dst_id, src_id;
    union {
        /* A build, also FILL_BUILDS_MICROMAP, and FILL_READS_ACCEL if it has shapes: the new state
         * of dst. An update: its parameters. */
        struct built built;
        struct journal *secondary;
        struct noted_ranges *ranges; /* owned */
        struct {
            VkDeviceSize offset, size, memory_offset;
        } binding;
        struct journal_micromap micromap;
        struct journal_read read;
        struct placed placed;
        VkDeviceSize number;
    };
};

/* The type of the structures that a command names, if it has entries. */
VkObjectType journal_object_type(enum build_command command);

/* The type of the structures of an entry that uses some. */
static inline VkObjectType journal_entry_type(const struct journal_entry *entry)
{
    if (entry->kind == JOURNAL_USE_MICROMAP)
        return entry->micromap.is_ext ? VK_OBJECT_TYPE_MICROMAP_EXT
                                      : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    return journal_object_type((enum build_command)entry->command);
}

static inline bool journal_fill_reads_memory(const struct journal_entry *entry)
{
    return entry->info == FILL_READS_ACCEL || entry->info == FILL_READS_MICROMAP;
}

/* If inputs of builds are copied, the entry of a build has room for a pointer behind it. */
enum {
    JOURNAL_UNIT = 8,
    JOURNAL_ENTRY_MAX = sizeof(struct journal_entry) + sizeof(struct recorded_build *)
};
_Static_assert(JOURNAL_ENTRY_MAX <= 128, "a recorded build takes little memory");
struct journal_input {
    unsigned char kind, size;  /* as in struct journal_entry */
    unsigned char role;        /* enum input_role; INPUT_ROLES: of a build at addresses, whose
                                * member `info` is (enum addressed_member) */
    unsigned char command : 7; /* enum build_command */
    bool geometry_by_pointer : 1;
    uint32_t position; /* of the build in the command buffer */
    uint32_t info;
    uint32_t geometry;
    uint64_t buffer_id; /* see struct address_facts */
    union {
        VkDeviceAddress address;
        VkBuffer buffer; /* for COMMAND_NV */
    };
};
_Static_assert(sizeof(struct journal_input) == 32, "a build has several inputs");
_Static_assert(COMMAND_COUNT <= 1 << 7, "an input has room for its command");

enum { JOURNAL_RECENT_INPUTS = 32, JOURNAL_INPUTS_AT_ONCE = 5 };
#define JOURNAL_CHUNK                                                                              \
    (struct chunk_sizes)                                                                           \
    {                                                                                              \
        64 * sizeof(struct journal_entry), JOURNAL_INPUTS_AT_ONCE * sizeof(struct journal_input)   \
    }
_Static_assert(JOURNAL_ENTRY_MAX <= JOURNAL_INPUTS_AT_ONCE * sizeof(struct journal_input),
               "there is room for an entry");

/* Which batches had certainly executed, and which had been submitted, when a host command began. */
struct host_view {
    struct execution_clock executed, submitted;
};

struct journal {
    atomic_uint references;
    uint32_t label_changes;         /* of the labels of the last origin */
    VkCommandBuffer command_buffer; /* null: a host command */
    struct host_view *host;         /* owned; NULL unless a host command that reads */
    uint64_t destroy_count;         /* resources_destroy_count when recording began */
    struct chunk_list entries;
    struct chunk_place call;        /* the end before the entries of the last call */
    struct journal_origin *origins; /* each differs from the one before */
    uint32_t origin_count, origin_capacity;
    uint64_t recent_inputs[JOURNAL_RECENT_INPUTS]; /* buffer ids, by their low bits */
    /* What entries refer to if inputs of builds are copied: struct recording of
     * src/snapshots/recording.h; owned, may be NULL. */
    void *work;
    void (*release_work)(void *work);
    struct recent_memory *recent_memory; /* owned; see hazard_memory_id() */
    /* Setting hazards: the end of the entries of the last command with shaders, and its name. */
    const void *shaders_end;
    const char *shaders_name;
    struct bound_shaders *bound; /* owned; NULL: nothing is known to be bound */
    uint32_t secondary_count;    /* JOURNAL_EXECUTE entries */
    bool binds;                  /* all entries are JOURNAL_BIND */
    /* journal_clear() clears those that follow: side by side, they take two instructions. */
    bool has_condition;        /* setting hazards: conditional rendering may leave dispatches out */
    bool has_references;       /* see journal_entry_has_references */
    bool has_sources_to_check; /* see journal_entry_has_source_to_check */
    bool has_events;           /* it or a secondary has event entries */
    bool writes_queries;       /* it or a secondary has JOURNAL_WRITE_QUERIES, or a JOURNAL_READ
                                * that is a query */
    struct unknown unknown;    /* memory ran out for entries: the others prove nothing */
    struct unknown
        accesses_unknown; /* memory ran out for HAZARD entries: all before counts as ordered */
    /* It or a secondary has builds whose data, indices or references level content will find. */
    bool awaits_inputs;
    bool has_copies; /* it or a secondary has a JOURNAL_COPY */
    /* Setting hazards: it or a secondary has builds that read buffers which no command writes. */
    bool reads_host_data;
    uint32_t place_count; /* JOURNAL_PLACE entries; has_references is set with it */
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

/* Whether an entry, of any type, is of a kind: journal_is_build() and so on. */
#define ENTRY(number, event, type, use)                                                            \
    static inline bool journal_is_##event(const void *entry)                                       \
    {                                                                                              \
        return ((const struct journal_entry *)entry)->kind == (number);                            \
    }
#include "src/state/commands/journal_entries.def"
#undef ENTRY

/* Whether it has all entries. A command buffer for which memory ran out has no journal: NULL. */
static inline bool journal_is_complete(const struct journal *journal)
{
    return journal && !unknown_is_set(&journal->unknown);
}

static inline bool journal_entry_is_query(const struct journal_entry *entry)
{
    return journal_is_read(entry) && entry->read.query != VK_QUERY_TYPE_MAX_ENUM;
}

/* enum journal_use */
static inline unsigned journal_entry_use(const struct journal_entry *entry)
{
    static const unsigned char uses[JOURNAL_KINDS] = {
#define ENTRY(kind, event, type, use) use,
#include "src/state/commands/journal_entries.def"
#undef ENTRY
    };
    return uses[entry->kind];
}

/* Whether dst is a structure that is written. */
static inline bool journal_entry_writes(const struct journal_entry *entry)
{
    return journal_entry_use(entry) & WRITES_DST;
}

/* Whether the entry is a compacting copy. */
static inline bool journal_entry_compacts(const struct journal_entry *entry)
{
    return journal_is_copy(entry) && entry->read.compacts;
}

/* Whether the validation of an entry depends on the build of its source. */
static inline bool journal_entry_has_source_to_check(const struct journal_entry *entry)
{
    return journal_entry_use(entry) & READS_SRC;
}

static inline bool journal_entry_writes_query(const struct journal_entry *entry)
{
    return journal_is_write_queries(entry) || journal_entry_is_query(entry);
}

/* Whether the entry owns the references in `built`. */
static inline bool journal_entry_has_built(const struct journal_entry *entry)
{
    return journal_is_build(entry) || journal_is_update(entry) ||
           (journal_is_fill(entry) && entry->info == FILL_READS_ACCEL);
}

static inline bool journal_entry_has_references(const struct journal_entry *entry)
{
    if (journal_entry_has_built(entry))
        return entry->built.shapes || entry->built.compacted_size;
    return journal_is_execute(entry) || journal_is_ranges(entry);
}

/* ---- writing */

/* Returns an entry of so many bytes, of which only `size` is set. Returns NULL if memory runs out.
 */
static inline void *journal_append(struct journal *journal, size_t size)
{
    struct journal_entry *entry;
    if (!chunk_list_make_room(&journal->entries, JOURNAL_CHUNK))
        return NULL;
    entry = (void *)journal->entries.next;
    journal->entries.next += size;
    entry->size = (unsigned char)(size / JOURNAL_UNIT);
    return entry;
}

/* Returns a new entry, of which only `size` is set. The caller sets all else of it and then calls
 * journal_end_entry. The entry takes over the references in `built`, `secondary` or `ranges`.
 * Returns NULL if memory runs out; the journal is incomplete then. */
static inline struct journal_entry *journal_begin_entry(struct journal *journal)
{
    struct journal_entry *entry = journal_append(journal, sizeof(*entry));
    if (!entry)
        unknown_set(&journal->unknown, UNKNOWN_COMMANDS);
    return entry;
}

/* Returns a new entry of a build or update, like journal_begin_entry(); its kind is set, too.
 * `is_copied`: the build's inputs may be copied. */
static inline struct journal_entry *journal_begin_build(struct journal *journal, bool is_update,
                                                        bool is_copied)
{
    struct recorded_build **copies;
    struct journal_entry *entry =
        journal_append(journal, sizeof(*entry) + (is_copied ? sizeof(*copies) : 0));
    if (!entry) {
        unknown_set(&journal->unknown, UNKNOWN_COMMANDS);
        return NULL;
    }
    entry->kind = is_update ? JOURNAL_UPDATE : JOURNAL_BUILD;
    copies = (void *)(entry + 1);
    if (is_copied)
        *copies = NULL;
    return entry;
}

/* The copies of a build's inputs, which journal->work owns; NULL: there are none. */
static inline struct recorded_build *journal_copies(const struct journal_entry *entry)
{
    bool has_room = entry->size * JOURNAL_UNIT > (int)sizeof(*entry);
    return has_room ? *(struct recorded_build *const *)(const void *)(entry + 1) : NULL;
}
static inline void journal_set_copies(struct journal_entry *entry, struct recorded_build *copies)
{
    *(struct recorded_build **)(void *)(entry + 1) = copies;
}

/* Not needed for an entry without references and without a source to check. */
static inline void journal_end_entry(struct journal *journal, const struct journal_entry *entry)
{
    journal->has_references |= journal_entry_has_references(entry);
    journal->has_sources_to_check |= journal_entry_has_source_to_check(entry);
    journal->writes_queries |= journal_entry_writes_query(entry);
}

/* New entries, whose other members the caller sets before journal_add(): a copy, a write of dst
 * from memory, and a read of src (`query`: as in struct journal_read). */
static inline struct journal_entry journal_copy_entry(enum build_command command, bool compacts)
{
    return (struct journal_entry){
        .kind = JOURNAL_COPY,
        .command = (unsigned char)command,
        .read = {.compacts = compacts, .query = VK_QUERY_TYPE_MAX_ENUM},
    };
}
static inline struct journal_entry journal_fill_entry(enum build_command command,
                                                      enum journal_fill fill)
{
    return (struct journal_entry){
        .kind = JOURNAL_FILL, .command = (unsigned char)command, .info = fill};
}
static inline struct journal_entry journal_read_entry(enum build_command command, VkQueryType query)
{
    return (struct journal_entry){
        .kind = JOURNAL_READ, .command = (unsigned char)command, .read.query = query};
}

/* Adds a copy of `entry` and takes over its references. Releases them if memory runs out. */
void journal_add(struct journal *journal, const struct journal_entry *entry);

/* These also set the kind. */
#define ADDS(event, number)                                                                        \
    static inline void journal_add_##event(struct journal *journal, struct journal_entry entry)    \
    {                                                                                              \
        entry.kind = (number);                                                                     \
        journal_add(journal, &entry);                                                              \
    }
ADDS(primitives, JOURNAL_PRIMITIVES)
ADDS(use_micromap, JOURNAL_USE_MICROMAP)
ADDS(ranges, JOURNAL_RANGES)
ADDS(reset_queries, JOURNAL_RESET_QUERIES)
ADDS(write_queries, JOURNAL_WRITE_QUERIES)
ADDS(answer, JOURNAL_ANSWER)
ADDS(use_event, JOURNAL_USE_EVENT)
#undef ADDS

/* Adds the place of copies of a build that writes no structure that is known. The caller may set
 * `origin`. Returns NULL if memory runs out. */
struct journal_entry *journal_add_inputs(struct journal *journal, enum build_command command,
                                         uint32_t info, uint32_t position);
/* Adds an execution of the secondary command buffer whose journal is given, and a reference to it.
 */
void journal_add_secondary(struct journal *journal, struct journal *secondary);
void journal_add_place(struct journal *journal, const struct placed *placed);
void journal_add_binding(struct journal *journal, const struct sparse_binding *binding);
struct sparse_binding journal_binding(const struct journal_entry *entry);

/* Notes where a build or command is recorded: under which open labels (NULL: a host command), and
 * from which site. Returns the value of journal_entry.origin; 0: nothing is known, or memory ran
 * out. */
uint32_t journal_keep_origin(struct journal *journal, const struct label_stack *labels,
                             const struct call_site *site);
static inline uint32_t journal_note_origin(struct journal *journal,
                                           const struct label_stack *labels,
                                           const struct call_site *site)
{
    return (labels && labels->count) || site ? journal_keep_origin(journal, labels, site) : 0;
}
/* Returns the origin of the build at a position in the command buffer; 0: unknown. */
uint32_t journal_origin_at(const struct journal *journal, uint32_t position);
/* What an origin says; NULL: nothing. Labels live as long as the entries. */
static inline const struct label_stack *journal_labels(const struct journal *journal,
                                                       uint32_t origin)
{
    return origin ? &journal->origins[origin - 1].labels : NULL;
}
static inline const struct call_site *journal_site(const struct journal *journal, uint32_t origin)
{
    return origin ? journal->origins[origin - 1].site : NULL;
}

/* Returns room for JOURNAL_INPUTS_AT_ONCE inputs. The caller fills some of them and then calls
 * journal_end_inputs. Returns NULL if memory runs out; the journal stays complete, because an input
 * only serves to report destroyed buffers. */
static inline struct journal_input *journal_begin_inputs(struct journal *journal)
{
    bool has_room = chunk_list_make_room(&journal->entries, JOURNAL_CHUNK);
    return has_room ? (void *)journal->entries.next : NULL;
}

/* Returns an input, whose other members the caller sets. */
static inline struct journal_input journal_input_of(enum input_role role, unsigned char command,
                                                    uint32_t position, uint64_t buffer_id)
{
    return (struct journal_input){
        .kind = JOURNAL_USE_BUFFER,
        .size = sizeof(struct journal_input) / JOURNAL_UNIT,
        .role = (unsigned char)role,
        .command = command,
        .position = position,
        .buffer_id = buffer_id,
    };
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
    journal->entries.next = (char *)end;
}

static inline struct chunk_place journal_end(const struct journal *journal)
{
    return chunk_list_end(&journal->entries);
}
/* Removes all entries that were added after a position. */
void journal_take_back(struct journal *journal, struct chunk_place place);

/* Begins a call of the application: the entries that follow are its own until the next one. */
static inline void journal_begin_call(struct journal *journal)
{
    journal->call = journal_end(journal);
}

/* Empties the journal. Keeps its memory for the next recording. */
void journal_clear(struct journal *journal);

/* ---- reading */

struct journal_walk;

/* What a reader does with entries: a function for each kind that it reads. A walk skips the other
 * kinds. */
struct journal_events {
    union {
        struct {
#define ENTRY(kind, event, type, use) void (*event)(struct journal_walk * walk, const type *entry);
#include "src/state/commands/journal_entries.def"
#undef ENTRY
        };
        void (*of_kind[JOURNAL_KINDS])(void);
    };
};
_Static_assert(sizeof(struct journal_events) == JOURNAL_KINDS * sizeof(void (*)(void)),
               "each kind has its function");

/* One function for several kinds: builds; what writes a structure; what uses one. */
#define ON_BUILDS(function) .build = (function), .update = (function)
#define ON_WRITES(function) ON_BUILDS(function), .copy = (function), .fill = (function)
#define ON_USES(function) ON_WRITES(function), .read = (function), .use_micromap = (function)

/* A walk over the entries that `events` has functions for, up to where the journal ended when the
 * walk was started. The caller may change `place`, from which the walk goes on, and set `end` to an
 * earlier position. */
struct journal_walk {
    const struct journal_events *events;
    void *user; /* for the functions */
    const struct journal *journal;
    struct chunk_place place, end; /* `place` is behind the entry that a function gets */
    bool is_over;                  /* a function may set it: the walk ends behind the entry */
};

/* Starts before all entries, or before the entries of the last call. */
struct journal_walk journal_start(const struct journal *journal,
                                  const struct journal_events *events, void *user);
struct journal_walk journal_start_call(const struct journal *journal,
                                       const struct journal_events *events, void *user);
/* Returns the next entry that has a function, which is not called; NULL at the end. An entry of
 * another type than struct journal_entry begins like one. */
struct journal_entry *journal_next(struct journal_walk *walk);

/* Calls the function of the entry's kind, if `events` has one. */
static inline void journal_hand(struct journal_walk *walk, const struct journal_events *events,
                                const void *entry)
{
    switch ((enum journal_kind)((const struct journal_entry *)entry)->kind) {
#define ENTRY(kind, event, type, use)                                                              \
    case kind:                                                                                     \
        if (events->event)                                                                         \
            events->event(walk, entry);                                                            \
        break;
#include "src/base/unknown.h"
#include "src/state/commands/journal_entries.def"
#undef ENTRY
    case JOURNAL_KINDS:
        break;
    }
}

/* Hands all that is left of a walk, or all entries of a journal, to the functions. Returns false if
 * one of them has ended the walk. */
bool journal_go_on(struct journal_walk *walk);
bool journal_walk(const struct journal *journal, const struct journal_events *events, void *user);
/* The function of a reader that walks secondary command buffers as it does the primary one. It is
 * recursive: the device limits how deep they nest (VK_EXT_nested_command_buffer). */
void journal_walk_secondary(struct journal_walk *walk, const struct journal_entry *entry);

/* A walk over the secondary command buffers alone. Returns NULL at the end. */
struct journal_walk journal_start_secondaries(const struct journal *journal);
struct journal *journal_next_secondary(struct journal_walk *walk);

/* For the command buffer that records the journal, which alone may change entries, and only those
 * of the last call: a walk over its builds, by journal_next(); its first copy, or NULL; and a note
 * that an entry was validated when it was recorded. */
struct journal_walk journal_start_builds_of_call(const struct journal *journal);
struct journal_entry *journal_find_copy_of_call(const struct journal *journal);
void journal_set_judged(const struct journal_entry *entry);

#endif
