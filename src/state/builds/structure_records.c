/* SPDX-License-Identifier: Apache-2.0 */
/* The records of structures. */
#include "src/state/builds/structure_records.h"

#include <stdlib.h>

#include "src/base/array.h"

/* The largest undo capacity, in records, that is kept for reuse. */
enum { UNDO_RETAINED = 1024 };

struct structures *structures_create(enum structures_keeping keeping,
                                     const struct structure_inputs *inputs)
{
    struct structures *structures = calloc(1, sizeof(*structures));
    struct structures_shared *shared = calloc(1, sizeof(*shared));
    if (!structures || !shared) {
        free(structures);
        free(shared);
        return NULL;
    }
    shared->keeping = keeping;
    shared->inputs = inputs;
    pthread_mutex_init(&shared->lock, NULL);
    structures->shared = shared;
    return structures;
}

void structures_destroy(struct structures *structures)
{
    if (!structures)
        return;
    structures_release(structures);
    pthread_mutex_destroy(&structures->shared->lock);
    free(structures->shared->undo);
    free(structures->shared->destroyed);
    free(structures->shared);
    free(structures);
}

/* ---- records */

struct structure *structures_find(const struct structures *structures, uint64_t id)
{
    return handle_table_find(&structures->by_id, id);
}

void structures_prefetch(const struct structures *structures, uint64_t id)
{
    handle_table_prefetch(&structures->by_id, id);
}

void structures_prefetch_found(const struct structures *structures, uint64_t id)
{
    const struct structure *structure = structures_find(structures, id);
    if (!structure)
        return;
    __builtin_prefetch(structure, 1);
    __builtin_prefetch((const char *)(structure + 1) - 1, 1);
}

static struct structure *find_or_add_structure(struct structures *structures, uint64_t id)
{
    struct structure *structure = structures_find(structures, id);
    if (structure)
        return structure;
    structure = calloc(1, sizeof(*structure));
    if (!structure)
        return NULL;
    structure->first_build = STRUCTURE_NEVER_BUILT;
    lock_shared(structures);
    bool is_added = handle_table_set(&structures->by_id, id, structure);
    unlock_shared(structures);
    if (is_added)
        return structure;
    free(structure);
    return NULL;
}

/* If there is no memory, the flag stays unknown. */
static void note_flag(struct structures_shared *shared, struct structure *structure)
{
    uint64_t serial = shared->serial;
    if (structure->built.state != BUILT_BEFORE) {
        if (structure->more)
            structure->more->since = 0;
        return;
    }
    struct structure_more *more = more_of(structure);
    bool allows = structure->built.flags &
                  VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR;
    if (!more || (more->since && more->allows_disabling == allows))
        return;
    more->allows_disabling = allows;
    more->since = serial;
    more->written = structure->written;
}

static void note_first_write(struct structure *structure, uint64_t serial)
{
    if (structure->first_serial)
        return;
    structure->first_queue = structure->written.queue;
    structure->first_serial = serial;
}

void structures_replace(struct structures *structures, struct structure *structure,
                        const struct built *built, struct timestamp written)
{
    struct structures_shared *shared = structures->shared;
    struct built own = built_share(built); /* `built` may point to structure->built */
    built_release(&structure->built);
    structure->built = own;
    structure->written = written;
    if (!shared || (!shared->keeping && !shared->inputs))
        return;
    lock_shared(structures);
    note_first_write(structure, ++shared->serial);
    if (shared->keeping == KEEPS_FLAGS)
        note_flag(shared, structure);
    if (structure->more)
        structure->more->copy_of = 0;
    unlock_shared(structures);
}

bool structures_set(struct structures *structures, uint64_t id, const struct built *built,
                    struct timestamp written)
{
    struct structure *structure = id ? find_or_add_structure(structures, id) : NULL;
    if (structure)
        structures_replace(structures, structure, built, written);
    return structure;
}

static void forget_flag(struct structures *structures, struct structure *structure)
{
    if (structures->shared->keeping != KEEPS_FLAGS)
        return;
    lock_shared(structures);
    if (structure->more)
        structure->more->since = 0;
    unlock_shared(structures);
}

bool structures_add_writer(struct structures *structures, uint64_t id)
{
    struct structure *structure = id ? find_or_add_structure(structures, id) : NULL;
    if (!structure)
        return false;
    forget_flag(structures, structure);
    lock_shared(structures);
    structure->host_writers++;
    unlock_shared(structures);
    return true;
}

void structures_remove_writer(struct structures *structures, uint64_t id)
{
    struct structure *structure = structures_find(structures, id);
    lock_shared(structures);
    if (structure && structure->host_writers)
        structure->host_writers--;
    unlock_shared(structures);
}

bool structures_note_first_build(struct structures *structures, uint64_t id, uint32_t count)
{
    struct structure *structure = structures_find(structures, id);
    bool is_first = structure && structure->first_build == STRUCTURE_NEVER_BUILT;
    if (is_first) {
        lock_shared(structures);
        structure->first_build = count;
        unlock_shared(structures);
    }
    return is_first || unknown_is_set(&structures->shared->unknown);
}

/* Called with the lock held. */
static void release_input(const struct structures *structures, void *input)
{
    if (input)
        structures->shared->inputs->release(input);
}

void structures_copy_input(struct structures *structures, uint64_t dst_id, uint64_t src_id)
{
    struct structure *dst = structures_find(structures, dst_id);
    if (!structures->shared->inputs || !dst)
        return;
    void *input = structures_find_input(structures, src_id);
    lock_shared(structures);
    struct structure_more *more = more_of(dst);
    release_input(structures, more ? more->input : input);
    if (more) {
        more->input = input;
        more->copy_of = src_id;
    }
    unlock_shared(structures);
}

/* Called with the lock held. */
static void free_structure(struct structures *structures, struct structure *structure)
{
    if (structure->more) {
        release_input(structures, structure->more->input);
        free(structure->more->notes);
    }
    free(structure->more);
    built_release(&structure->built);
    free(structure);
}

void structures_remove(struct structures *structures, uint64_t id)
{
    lock_shared(structures);
    struct structure *structure = handle_table_remove(&structures->by_id, id);
    if (structure)
        free_structure(structures, structure);
    unlock_shared(structures);
}

static void free_record(void *record, void *context)
{
    free_structure(context, record);
}

static void free_other_input(void *record, void *context)
{
    release_input(context, record);
}

/* Called with the lock held. */
static void release_other_inputs(struct structures *structures)
{
    struct handle_table *inputs = &structures->shared->other_inputs;
    handle_table_each(inputs, free_other_input, structures);
    handle_table_release(inputs);
}

void structures_release(struct structures *structures)
{
    if (structures->shared)
        structures_keep(structures);
    lock_shared(structures);
    handle_table_each(&structures->by_id, free_record, structures);
    handle_table_release(&structures->by_id);
    if (structures->shared) {
        release_other_inputs(structures);
        unknown_follow(&structures->shared->unknown, true);
    }
    unlock_shared(structures);
}

/* ---- destroyed structures */

void structures_note_destroyed(struct structures *structures, uint64_t first_id, uint32_t count)
{
    if (!structures || !first_id)
        return;
    struct structures_shared *shared = structures->shared;
    pthread_mutex_lock(&shared->lock);
    if (ARRAY_HAS_ROOM(shared->destroyed, shared->destroyed_count, shared->destroyed_capacity))
        shared->destroyed[shared->destroyed_count++] = (struct destroyed_ids){first_id, count};
    pthread_mutex_unlock(&shared->lock);
}

static void forget_structure(struct structures *structures, uint64_t id)
{
    struct structure *structure = handle_table_remove(&structures->by_id, id);
    if (!structure)
        return;
    struct structure_more *more = structure->more;
    if (more && more->input && handle_table_set(&structures->shared->other_inputs, id, more->input))
        more->input = NULL;
    free_structure(structures, structure);
}

void structures_forget_destroyed(struct structures *structures)
{
    struct structures_shared *shared = structures->shared;
    pthread_mutex_lock(&shared->lock);
    for (uint32_t i = 0; i < shared->destroyed_count; i++)
        for (uint32_t j = 0; j < shared->destroyed[i].count; j++)
            forget_structure(structures, shared->destroyed[i].first_id + j);
    shared->destroyed_count = 0;
    pthread_mutex_unlock(&shared->lock);
}

/* ---- undo */

bool structures_note_undo(struct structures *structures, uint64_t id, struct structure *structure)
{
    struct structures_shared *shared = structures->shared;
    if (!ARRAY_HAS_ROOM(shared->undo, shared->undo_count, shared->undo_capacity))
        return false;
    struct structure_before *before = &shared->undo[shared->undo_count++];
    *before = (struct structure_before){.id = id, .had_record = structure != NULL};
    if (!structure)
        return true;
    before->built = structure->built;
    before->written = structure->written;
    structure->built = (struct built){.state = BUILT_UNKNOWN};
    return true;
}

static void restore(struct structures *structures, const struct structure_before *before)
{
    if (!before->had_record) {
        structures_remove(structures, before->id);
        return;
    }
    structures_set(structures, before->id, &before->built, before->written);
    struct structure *structure = structures_find(structures, before->id);
    if (structure)
        forget_flag(structures, structure);
}

/* Backwards, so that the oldest note of a structure takes effect last. */
void structures_undo(struct structures *structures)
{
    struct structures_shared *shared = structures->shared;
    while (shared->undo_count) {
        struct structure_before *before = &shared->undo[--shared->undo_count];
        restore(structures, before);
        built_release(&before->built);
    }
}

void structures_keep(struct structures *structures)
{
    struct structures_shared *shared = structures->shared;
    while (shared->undo_count)
        built_release(&shared->undo[--shared->undo_count].built);
    if (shared->undo_capacity <= UNDO_RETAINED)
        return;
    free(shared->undo);
    shared->undo = NULL;
    shared->undo_capacity = 0;
}

/* ---- any thread */

bool structures_find_serial(const struct structures *structures, uint64_t *serial)
{
    if (!structures || !structures->shared->keeping)
        return false;
    lock_shared(structures);
    *serial = structures->shared->serial;
    unlock_shared(structures);
    return true;
}

static bool came_before(const struct structure_more *more, const struct execution_point *point)
{
    struct timestamp written = more->written;
    bool is_own = written.queue == point->now.queue && written.count == point->now.count;
    return more->since && more->since <= point->serial &&
           ((is_own && !point->is_unordered) || execution_clock_has(&point->follows, written));
}

enum tristate structures_allow_disabling(const struct structures *structures, uint64_t id,
                                         const struct execution_point *point)
{
    if (!structures || !id || !point)
        return UNKNOWN;
    lock_shared(structures);
    const struct structure *structure = structures_find(structures, id);
    const struct structure_more *more = structure ? structure->more : NULL;
    enum tristate allows = UNKNOWN;
    if (more && came_before(more, point))
        allows = more->allows_disabling ? YES : NO;
    unlock_shared(structures);
    return allows;
}

/* Called with the lock held. A host command that has begun may have written the structure before.
 */
static bool was_written_later(const struct structure *structure,
                              const struct execution_point *point)
{
    return structure->first_serial > point->serial && !structure->host_writers &&
           structure->first_queue == point->now.queue && !point->is_unordered;
}

enum structure_written structures_were_written(const struct structures *structures, uint64_t id,
                                               const struct execution_point *point)
{
    enum structure_written written = WRITTEN_PERHAPS;
    if (!structures || !id || !point)
        return written;
    lock_shared(structures);
    const struct structure *structure = structures_find(structures, id);
    if (!structure && !unknown_is_set(&structures->shared->unknown))
        written = WRITTEN_NEVER;
    else if (structure && was_written_later(structure, point))
        written = WRITTEN_LATER;
    unlock_shared(structures);
    return written;
}

uint32_t structures_first_build(const struct structures *structures, uint64_t id)
{
    lock_shared(structures);
    const struct structure *structure = structures_find(structures, id);
    uint32_t count = structure                                      ? structure->first_build
                     : unknown_is_set(&structures->shared->unknown) ? 0
                                                                    : STRUCTURE_NEVER_BUILT;
    unlock_shared(structures);
    return count;
}

void structures_set_input(struct structures *structures, uint64_t id, void *input)
{
    struct handle_table *others = &structures->shared->other_inputs;
    void *unused = input;
    lock_shared(structures);
    struct structure *structure = structures_find(structures, id);
    struct structure_more *more = structure ? more_of(structure) : NULL;
    if (more) {
        unused = more->input;
        more->input = input;
    } else if (!structure && id) {
        unused = handle_table_remove(others, id);
        if (input && !handle_table_set(others, id, input))
            release_input(structures, input);
    }
    release_input(structures, unused);
    unlock_shared(structures);
}

enum { CHAIN_MAX = 16 /* maximum copies of copies */ };

/* Called with the lock held. */
static void *find_input(const struct structures *structures, uint64_t id)
{
    for (int i = 0; id && i < CHAIN_MAX; i++) {
        const struct structure *structure = structures_find(structures, id);
        const struct structure_more *more = structure ? structure->more : NULL;
        if (!structure)
            return handle_table_find(&structures->shared->other_inputs, id);
        if (!more || more->input)
            return more ? more->input : NULL;
        id = more->copy_of;
    }
    return NULL;
}

void *structures_find_input(const struct structures *structures, uint64_t id)
{
    lock_shared(structures);
    void *input = find_input(structures, id);
    if (input)
        input = structures->shared->inputs->share(input);
    unlock_shared(structures);
    return input;
}

void structures_release_other_inputs(struct structures *structures)
{
    lock_shared(structures);
    release_other_inputs(structures);
    unlock_shared(structures);
}

/* ---- notes */

void *structures_lock_notes(const struct structures *structures, uint64_t id, size_t size,
                            bool *is_known)
{
    lock_shared(structures);
    struct structure *structure = structures_find(structures, id);
    struct structure_more *more = NULL;
    if (structure)
        more = size ? more_of(structure) : structure->more;
    if (more && !more->notes && size)
        more->notes = calloc(1, size);
    void *notes = more ? more->notes : NULL;
    *is_known = !unknown_is_set(&structures->shared->unknown) && (notes || !structure || !size);
    return notes;
}

void structures_unlock_notes(const struct structures *structures)
{
    unlock_shared(structures);
}
