/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of each acceleration structure and micromap in execution order: one record for
 * each, by its id (struct accel_facts). Queries of compacted sizes have records, too
 * (src/check/replay/queries.c).
 *
 * A device has one table for all submitted work. Only the hooks of the execution order write it,
 * one thread at a time (src/state/order/order.h): they are the writer. The writer takes the table's
 * lock when it adds or removes a record, or changes what other threads read, and reads without the
 * lock. What `more` leads to is used with the lock held on each thread. Threads that are not the
 * writer call only the functions marked "any thread", which take the lock and call nothing with it
 * held, except those of struct structure_inputs.
 *
 * Each command buffer has a table of the structures that it writes itself. Such a table has no lock
 * and no `more`. */
#ifndef ASSAY_STATE_BUILDS_STRUCTURES_H
#define ASSAY_STATE_BUILDS_STRUCTURES_H

#include "src/base/handle_table.h"
#include "src/state/builds/built.h"
#include "src/state/order/clock.h"

/* A value of first_build: no build has been counted. */
#define STRUCTURE_NEVER_BUILT UINT32_MAX

struct structure {
    struct built built;       /* the last build */
    struct timestamp written; /* when written; count 0: never; unused in a command buffer's table */
    /* Other threads read the members below, with the table's lock held. */
    uint32_t host_writers; /* number of host commands that are writing it: until they end, the
                            * state is unknown */
    uint32_t first_build;  /* count of its first build, for setting guard */
    /* The queue of its first write, and the serial then; if serials are kept. */
    uint32_t first_queue;
    uint64_t first_serial;
    struct structure_more *more; /* what other settings need; NULL until they do */
};

/* Zero-initialized is the empty table of a command buffer. */
struct structures {
    struct handle_table by_id;
    struct structures_shared *shared; /* of a device; NULL in a command buffer's table */
};

/* References to what the owner of `input` retained of a structure's builds. Both functions are
 * called with the table's lock held and take no lock. */
struct structure_inputs {
    void *(*share)(void *input);
    void (*release)(void *input);
};

/* What a device's table keeps for past execution points. */
enum structures_keeping {
    KEEPS_NOTHING,
    KEEPS_SERIALS, /* for structures_were_written() */
    KEEPS_FLAGS,   /* also for structures_allow_disabling() */
};

/* Returns the empty table of a device, or NULL if there is no memory. `inputs`: for
 * structures_set_input(); or NULL. */
struct structures *structures_create(enum structures_keeping keeping,
                                     const struct structure_inputs *inputs);
void structures_destroy(struct structures *structures); /* accepts NULL */

/* ---- the writer */

/* Returns NULL if there is no record. */
struct structure *structures_find(const struct structures *structures, uint64_t id);

/* Prefetch a record that will be looked up soon: first its place in the table; once that is in the
 * cache, the record itself. */
void structures_prefetch(const struct structures *structures, uint64_t id);
void structures_prefetch_found(const struct structures *structures, uint64_t id);

/* Sets the last build of a structure; shares `built`. If there is no memory for a new record,
 * returns false and changes nothing. */
bool structures_set(struct structures *structures, uint64_t id, const struct built *built,
                    struct timestamp written);
/* Sets the last build of a record that was found before; shares `built`. */
void structures_replace(struct structures *structures, struct structure *structure,
                        const struct built *built, struct timestamp written);

/* Called when a host command begins to write a structure. Returns false if there is no memory. */
bool structures_add_writer(struct structures *structures, uint64_t id);
/* Called when it has ended. */
void structures_remove_writer(struct structures *structures, uint64_t id);

/* The build with this count has written the structure. Returns whether it was the first. 0: the
 * structure counts as built at all times. */
bool structures_note_first_build(struct structures *structures, uint64_t id, uint32_t count);

/* Called after a copy from `src_id` to `dst_id` was set: `dst_id` has the input of `src_id`, or, as
 * long as that is unknown, the one that is set later. Not undone, because every input that a
 * structure had can be compared. */
void structures_copy_input(struct structures *structures, uint64_t dst_id, uint64_t src_id);

/* Removes a record if there is one. */
void structures_remove(struct structures *structures, uint64_t id);
/* Removes the records of the structures that structures_note_destroyed() noted. */
void structures_forget_destroyed(struct structures *structures);
/* Removes all records. In a device's table all structures are unknown from then on. */
void structures_release(struct structures *structures);

/* Notes the record of a structure before a command that may fail sets or removes it; `structure` is
 * NULL if there is none. Moves `built` to the note and makes the record BUILT_UNKNOWN. Returns
 * false and changes nothing if there is no memory. */
bool structures_note_undo(struct structures *structures, uint64_t id, struct structure *structure);
/* The commands have failed: restores all noted records, newest first, and removes the notes. The
 * flag for structures_allow_disabling() becomes unknown. The count of a first build goes only
 * with a record that was new. */
void structures_undo(struct structures *structures);
/* The commands have succeeded: removes the notes. */
void structures_keep(struct structures *structures);

/* ---- any thread */

/* Called when structures or queries were destroyed: `count` consecutive ids from `first_id` on. The
 * writer removes their records later. Without memory the records stay, which is harmless: ids are
 * not reused. */
void structures_note_destroyed(struct structures *structures, uint64_t first_id, uint32_t count);

/* When a build executed, and the work that executed before it. */
struct execution_point {
    uint64_t serial;
    struct timestamp now;
    bool is_unordered; /* the commands of its batch are unordered among themselves */
    struct execution_clock follows;
};

/* Finds the serial of the latest write. Returns false if no serials are kept. */
bool structures_find_serial(const struct structures *structures, uint64_t *serial);
/* Returns whether the structure had been built, at an execution point, so that instances may
 * disable its micromaps. Known as long as the flag hasn't changed since that point. UNKNOWN if
 * `structures` or `point` is NULL. */
enum tristate structures_allow_disabling(const struct structures *structures, uint64_t id,
                                         const struct execution_point *point);

/* Whether a structure was written before an execution point of a queue. */
enum structure_written {
    WRITTEN_PERHAPS,
    WRITTEN_NEVER, /* nor after that point */
    WRITTEN_LATER, /* by work that the same queue executed after that point */
};
/* `id` is of a live structure: records of destroyed ones are removed. WRITTEN_PERHAPS if
 * `structures` or `point` is NULL. */
enum structure_written structures_were_written(const struct structures *structures, uint64_t id,
                                               const struct execution_point *point);

/* What a consumer notes of a structure: some bytes, zero at first, that live as long as the record.
 * Locks the table, and returns them. `size`: makes them if they are missing. Returns NULL if there
 * are none, or no record. `*is_known` is false if something may be missing: all records were
 * removed, or memory ran out. The caller unlocks the table in each case. */
void *structures_lock_notes(const struct structures *structures, uint64_t id, size_t size,
                            bool *is_known);
void structures_unlock_notes(const struct structures *structures);

/* Returns the count of the structure's first build, STRUCTURE_NEVER_BUILT, or 0 if it is unknown.
 */
uint32_t structures_first_build(const struct structures *structures, uint64_t id);

/* Sets what is retained of the latest build that was read, and takes the reference. NULL: unknown.
 * Builds are read after they have completed, in execution order, while later ones may have been
 * written already. */
void structures_set_input(struct structures *structures, uint64_t id, void *input);
/* Returns a reference to the input of a structure, which may have been destroyed since, or NULL if
 * it is unknown. */
void *structures_find_input(const struct structures *structures, uint64_t id);
/* Releases the inputs of structures that were destroyed. */
void structures_release_other_inputs(struct structures *structures);

#endif
