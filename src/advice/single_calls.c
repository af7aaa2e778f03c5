/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/single_calls.h"

#include <string.h>

#include "src/state/commands/hazard_entries.h"

/* More accesses end a row, so that the search costs little. */
enum { ACCESSES_MAX = 1024 };

struct row {
    uint32_t calls, most;
    /* What the calls in the row access. The call that is being read begins at `first`. */
    const struct hazard_entry *accesses[ACCESSES_MAX];
    uint32_t first, count;
    bool is_open;              /* the last command may belong to the row */
    bool has_dst, has_scratch; /* that command's are known */
    bool has_overflown;
};

static bool overlap(const struct hazard_entry *one, const struct hazard_entry *other)
{
    return one->bytes.memory == other->bytes.memory && one->bytes.begin < other->bytes.end &&
           other->bytes.begin < one->bytes.end;
}

static bool conflict(const struct hazard_entry *one, const struct hazard_entry *other)
{
    return (access_is_write((enum access_kind)one->access) ||
            access_is_write((enum access_kind)other->access)) &&
           overlap(one, other);
}

/* Whether the command that was read needs a dependency on one before it. */
static bool needs_order(const struct row *row)
{
    for (uint32_t i = row->first; i < row->count; i++)
        for (uint32_t j = 0; j < row->first; j++)
            if (conflict(row->accesses[i], row->accesses[j]))
                return true;
    return false;
}

static void clear(struct row *row)
{
    row->calls = row->first = row->count = 0;
    row->is_open = row->has_overflown = false;
}

/* Begins a row with the command that was read. */
static void restart(struct row *row)
{
    row->count -= row->first;
    memmove(row->accesses, row->accesses + row->first, row->count * sizeof(row->accesses[0]));
    row->calls = 0;
}

/* Without its structure or its scratch memory it is unknown what the command needs. */
static void end_command(struct row *row)
{
    if (!row->is_open)
        return;
    if (!row->has_dst || !row->has_scratch || row->has_overflown) {
        clear(row);
        return;
    }
    if (needs_order(row))
        restart(row);
    row->calls++;
    row->first = row->count;
    row->is_open = false;
    row->most = row->calls > row->most ? row->calls : row->most;
}

static void add_access(struct journal_walk *walk, const struct hazard_entry *access)
{
    struct row *row = walk->user;
    if (!row->is_open)
        return;
    row->has_dst |= access->role == HAZARD_DST;
    row->has_scratch |= access->role == HAZARD_SCRATCH;
    row->has_overflown |= row->count == ACCESSES_MAX || !access->bytes.memory;
    if (!row->has_overflown)
        row->accesses[row->count++] = access;
}

static bool is_single_build(const struct hazard_entry *entry)
{
    return entry->build_count == 1 && !entry->reads_references &&
           strcmp(entry->command, build_command_name(COMMAND_DEVICE)) == 0;
}

/* No other command waits for these stages, nor do they wait for another one. The source has the
 * stages before those that the barrier names: a copy reads its parameters before it copies. */
static bool is_between_builds(const struct hazard_entry *entry)
{
    const stage_set builds = 1U << SYNC_BUILD | 1U << SYNC_ACCEL_COPY | 1U << SYNC_COPY_INDIRECT;
    return !entry->is_acquisition && !((entry->dependency.src | entry->dependency.dst) & ~builds);
}

static void add_command(struct journal_walk *walk, const struct hazard_entry *entry)
{
    struct row *row = walk->user;
    end_command(row);
    if (is_single_build(entry)) {
        row->is_open = true;
        row->has_dst = row->has_scratch = false;
    } else {
        clear(row);
    }
}

static void add_synchronization(struct journal_walk *walk, const struct hazard_entry *entry)
{
    end_command(walk->user);
    if (!journal_is_hazard_barrier(entry) || !is_between_builds(entry))
        clear(walk->user);
}

static void end_row(struct journal_walk *walk, const struct journal_entry *entry)
{
    if (journal_is_use_event(entry) && entry->info != EVENT_RESET)
        return;
    end_command(walk->user);
    clear(walk->user);
}

uint32_t journal_find_single_calls(const struct journal *journal)
{
    static const struct journal_events events = {.hazard_access = add_access,
                                                 .hazard_indexed = add_access,
                                                 .hazard_command = add_command,
                                                 .hazard_barrier = add_synchronization,
                                                 .hazard_set_event = add_synchronization,
                                                 .hazard_wait_event = add_synchronization,
                                                 .use_event = end_row,
                                                 .execute = end_row};
    struct row row = {0};
    journal_walk(journal, &events, &row);
    end_command(&row);
    return unknown_is_set(&journal->accesses_unknown) ? 0 : row.most;
}
