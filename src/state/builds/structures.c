/* SPDX-License-Identifier: Apache-2.0 */
/* The records of structures. */
#include "src/state/builds/structures.h"

#include <stdlib.h>

#include "src/base/array.h"
#include "src/platform/threads.h"

/* The largest undo capacity, in records, that is kept for reuse. */
enum { UNDO_RETAINED = 1024 };

/* Guarded by the table's lock. */
struct structure_more {
    /* Instances may disable micromaps, or not, since the write with serial `since` at `written`:
     * every later write had the same flag. `since` 0: unknown. */
    bool allows_disabling;
    uint64_t since;
    struct timestamp written;
    void *input; /* of the latest build that was read; NULL: unknown */
    /* While `input` is unknown: the id of the structure that this one was copied from, or 0. */
    uint64_t copy_of;
    struct structure_uses uses; /* for setting advice */
};

/* A record before commands that may fail. */
struct structure_before {
    uint64_t id;
    struct built built; /* state BUILT_NEVER if there was no record */
    struct timestamp written;
};

struct structures_shared {
    struct structure_before *undo; /* only the writer uses these three */
    uint32_t undo_count, undo_capacity;
    enum structures_keeping keeping;       /* keeping and inputs never change */
    const struct structure_inputs *inputs; /* or NULL */
    pthread_mutex_t lock;                  /* guards the members below */
    bool is_unknown;                       /* all records were removed */
    uint64_t serial;                       /* number of writes; if serials are kept */
    struct handle_table other_inputs; /* by id, of structures without a record: executions that were
                                       * not read yet may have used them */
    struct destroyed_ids {
        uint64_t first_id;
        uint32_t count;
    } * destroyed;
    uint32_t destroyed_count, destroyed_capacity;
};

static void lock_shared(const struct structures *structures)
{
    if (structures->shared)
        pthread_mutex_lock(&structures->shared->lock);
}

static void unlock_shared(const struct structures *structures)
{
    if (structures->shared)
        pthread_mutex_unlock(&structures->shared->lock);
}

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

static struct structure_more *more_of(struct structure *structure)
{
    if (!structure->more)
        structure->more = calloc(1, sizeof(*structure->more));
    return structure->more;
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

static struct structure *find_or_add(struct structures *structures, uint64_t id)
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
    struct structure *structure = id ? find_or_add(structures, id) : NULL;
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
    struct structure *structure = id ? find_or_add(structures, id) : NULL;
    if (!structure)
        return false;
    forget_flag(structures, structure);
    structure->host_writers++;
    return true;
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
    return is_first || structures->shared->is_unknown;
}

/* ---- uses, for setting advice */

/* Returns what became of a structure, with the lock held; NULL if there is no memory or no record.
 */
static struct structure_uses *lock_uses(struct structures *structures, uint64_t id,
                                        bool *has_memory)
{
    struct structure *structure = structures_find(structures, id);
    lock_shared(structures);
    struct structure_more *more = structure ? more_of(structure) : NULL;
    *has_memory = more || !structure;
    return more ? &more->uses : NULL;
}

bool structures_note_use(struct structures *structures, uint64_t id, enum structure_use use)
{
    bool has_memory;
    struct structure_uses *uses = lock_uses(structures, id, &has_memory);
    if (uses)
        uses->counts[use]++;
    unlock_shared(structures);
    return has_memory;
}

bool structures_note_build(struct structures *structures, uint64_t id, uint32_t submission,
                           VkBuildAccelerationStructureFlagsKHR flags, VkDeviceSize needed)
{
    bool has_memory;
    struct structure_uses *uses = lock_uses(structures, id, &has_memory);
    if (uses && !uses->counts[USE_BUILT]++) {
        uses->first_build = submission;
        uses->flags = flags;
    }
    if (uses) {
        uses->flags &= flags;
        uses->needed_size = needed;
    }
    unlock_shared(structures);
    return has_memory;
}

bool structures_note_compacted_size(struct structures *structures, uint64_t id, VkDeviceSize size)
{
    bool has_memory;
    struct structure_uses *uses = lock_uses(structures, id, &has_memory);
    if (uses)
        uses->compacted_size = size;
    unlock_shared(structures);
    return has_memory;
}

/* Returns what became of a structure, with the lock held. NULL if it was destroyed, or if nothing
 * is known. */
static struct structure_uses *lock_known_uses(const struct structures *structures, uint64_t id)
{
    lock_shared(structures);
    const struct structure *structure = structures_find(structures, id);
    return structure && structure->more ? &structure->more->uses : NULL;
}

bool structures_note_tiny(const struct structures *structures, uint64_t id, bool is_tiny)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    const bool was_tiny = uses && uses->is_tiny;
    if (uses)
        uses->is_tiny = is_tiny;
    unlock_shared(structures);
    return was_tiny;
}

static bool is_power_of_two(uint32_t number)
{
    return !(number & (number - 1));
}

/* Which builds are compared with the next one, and with those compared before. Input that takes
 * turns with others would hide at powers of two alone. */
enum { COMPARED_FIRST = 16, COMPARED_EACH = 31 };

static bool begins_comparison(uint32_t number)
{
    return number < COMPARED_FIRST || is_power_of_two(number) || number % COMPARED_EACH == 0;
}

struct reading_wanted structures_begin_read(const struct structures *structures, uint64_t id)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    struct reading_wanted wanted = {0};
    if (uses) {
        const uint32_t before = uses->read_builds++, number = uses->read_builds;
        wanted.is_judged = is_power_of_two(number) || uses->hollow_builds == before;
        wanted.is_compared = begins_comparison(number) || begins_comparison(before);
    }
    unlock_shared(structures);
    return wanted;
}

static bool is_equal(const struct input_digest *one, const struct input_digest *other)
{
    return one->words[0] == other->words[0] && one->words[1] == other->words[1] &&
           one->is_top == other->is_top;
}

/* The boxes of a top-level structure are those of other structures. They are as they were if it
 * alone was written in between. */
static bool is_repeated(const struct input_repeats *known, uint32_t number,
                        const struct input_digest *digest)
{
    return known->is_known && is_equal(&known->last, digest) &&
           (!digest->is_top ||
            digest->serial - known->last.serial == (uint64_t)number - known->number);
}

/* Returns whether the input is that of the build just before. */
static bool note_digest(struct input_repeats *known, uint32_t number,
                        const struct input_digest *digest)
{
    const bool is_same = digest && is_repeated(known, number, digest),
               is_next = is_same && number == known->number + 1;
    known->since = is_same ? known->since : number;
    known->equal_ones = is_same ? known->equal_ones + is_next : 0;
    known->number = number;
    known->is_known = digest;
    if (digest)
        known->last = *digest;
    return is_next;
}

bool structures_note_input(const struct structures *structures, uint64_t id,
                           const struct input_digest *digest)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    const bool asks = uses && note_digest(&uses->repeats, uses->read_builds, digest) &&
                      is_power_of_two(uses->repeats.equal_ones);
    unlock_shared(structures);
    return asks;
}

void structures_note_shared(const struct structures *structures, uint64_t id)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    if (uses)
        uses->repeats.is_shared = true;
    unlock_shared(structures);
}

void structures_note_contents(const struct structures *structures, uint64_t id,
                              const struct structure_contents *contents)
{
    struct structure_uses *uses = lock_known_uses(structures, id);
    if (uses && structure_is_hollow(contents)) {
        uses->hollow_builds++;
        uses->contents = *contents;
    }
    unlock_shared(structures);
}

bool structures_note_advised(const struct structures *structures, uint64_t id, unsigned advice)
{
    const uint64_t bit = UINT64_C(1) << advice;
    struct structure_uses *uses = lock_known_uses(structures, id);
    const bool is_first = uses && !(uses->advised & bit);
    if (is_first)
        uses->advised |= bit;
    unlock_shared(structures);
    return is_first;
}

bool structures_find_uses(const struct structures *structures, uint64_t id,
                          struct structure_uses *uses)
{
    lock_shared(structures);
    const struct structure *structure = structures_find(structures, id);
    const bool is_known = id && !structures->shared->is_unknown;
    *uses = structure && structure->more ? structure->more->uses : (struct structure_uses){0};
    unlock_shared(structures);
    return is_known;
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
    if (structure->more)
        release_input(structures, structure->more->input);
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
        structures->shared->is_unknown = true;
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

static void forget(struct structures *structures, uint64_t id)
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
            forget(structures, shared->destroyed[i].first_id + j);
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
    *before = (struct structure_before){.id = id, .built.state = BUILT_NEVER};
    if (!structure)
        return true;
    before->built = structure->built;
    before->written = structure->written;
    structure->built = (struct built){.state = BUILT_UNKNOWN};
    return true;
}

static void restore(struct structures *structures, const struct structure_before *before)
{
    if (before->built.state == BUILT_NEVER) {
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
    if (!structure && !structures->shared->is_unknown)
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
    uint32_t count = structure                        ? structure->first_build
                     : structures->shared->is_unknown ? 0
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
