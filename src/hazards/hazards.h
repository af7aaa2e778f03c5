/* SPDX-License-Identifier: Apache-2.0 */
/* Finds accesses to memory that no dependency orders (Vulkan specification, Synchronization and
 * Cache Control: Execution and Memory Dependencies).
 *
 * The caller describes batches in an order in which they may execute: a batch comes after all
 * batches whose signals it waits for. Within a batch it describes waits, then the commands with
 * their accesses and dependencies in submission order, then signals. Every access and every
 * synchronization command gets the next number; numbers never repeat and only grow.
 *
 * An access is compared with the last write of its bytes, and a write also with the reads since
 * then. A read after a write, and a write after a write, need a memory dependency: the write
 * happens before, is made available and is made visible to the access. A write after a read needs
 * an execution dependency. Accesses of one command are not compared, nor are two buffer markers.
 *
 * Why this scales: a dependency orders all earlier commands of a queue at given stages. So, for
 * each pair of queues, stage and kind of access, one number says up to where earlier accesses are
 * ordered (engine.h); no access is touched when a barrier executes. Only the memory part of a
 * buffer barrier concerns some bytes and not others: it is kept with these bytes (ranges.h).
 *
 * If memory runs out, everything before counts as ordered. No lock; one thread at a time. Ids of
 * memory and events are less than UINT64_MAX. */
#ifndef ASSAY_HAZARDS_HAZARDS_H
#define ASSAY_HAZARDS_HAZARDS_H

#include <stdbool.h>
#include <stdint.h>

#include "src/hazards/scopes.h"

struct hazards;

enum { HAZARD_HOST_QUEUE = 0, HAZARD_QUEUES = 32 }; /* as enum in src/state/order/clock.h */

/* Bytes [begin, end) of a VkDeviceMemory. `memory` is an id that is never reused. */
struct hazard_bytes {
    uint64_t memory;
    uint64_t begin, end;
};

struct hazard_access {
    enum access_kind kind;
    struct hazard_bytes bytes;
};

/* A barrier, or one of the dependencies of a synchronization command. The execution dependency and
 * the memory dependency of a global barrier hold for all bytes (`is_global`). That of a buffer
 * barrier (`!is_global`) makes only writes to its bytes available and visible; its execution
 * dependency still holds for all commands. An image barrier is a buffer barrier of no bytes. */
struct hazard_barrier {
    struct dependency dependency;
    bool is_global;
    struct hazard_bytes bytes;
    /* Transfer of ownership between queue families: a release makes writes available and nothing
     * visible; an acquisition makes what is available visible. The caller clears dst_kinds of a
     * release. An acquisition makes all writes to the bytes visible that happened before it, since
     * its first access scope is ignored. */
    bool is_acquisition;
};

/* One of the two accesses of a hazard. */
struct hazard_side {
    uint32_t queue;
    uint64_t number; /* of the access */
    enum access_kind kind;
};

enum hazard_type {
    READ_AFTER_WRITE,
    WRITE_AFTER_READ,
    WRITE_AFTER_WRITE,
    /* Only the caller finds these: */
    EARLY_TRACE,       /* a command that traces rays, and no top-level structure is visible to it */
    READ_AFTER_SHADER, /* a build reads what a shader must have written */
    READ_RACING_HOST,  /* the host has written what a build reads that need not be complete */
    TRACE_OF_DESTROYED,  /* a command traces rays in what the host has destroyed */
    READ_OF_OVERWRITTEN, /* a structure is read whose bytes something else has written */
    TRACE_OF_UNBUILT,    /* a command traces rays in what no command has built */
};

struct hazard {
    enum hazard_type type;
    /* Nothing orders the two batches, of different queues or both of the host: they may execute in
     * either order. */
    bool is_racing;
    struct hazard_side earlier, later;
    struct hazard_bytes bytes; /* the first bytes that both access, up to the end of a piece */
    bool is_ordered;           /* an execution dependency exists */
    bool is_available; /* the earlier access is a write that was made available on the way */
};

/* `found` is called for each hazard, by the call that describes the later access: one for the last
 * write, and for the last read of each queue and kind, of each piece of the bytes. It must not call
 * functions of this header. Returns NULL if memory runs out. */
struct hazards *hazards_create(void (*found)(void *user, const struct hazard *hazard), void *user);
/* Accepts NULL. */
void hazards_destroy(struct hazards *hazards);

/* Begins a batch of a queue. completed[i] is the number of batches of queue i, HAZARD_HOST_QUEUE
 * included, that the host had observed to be complete before it submitted this batch: everything in
 * them is ordered before it, for all stages and accesses. `count`: queues; others have 0. A batch
 * of host work is a batch of HAZARD_HOST_QUEUE. `is_certain` is false if batches may precede it
 * that are not known: everything before counts as ordered then. before[i] is the number of batches
 * of queue i that execute before this one by any order (semaphores included); it only decides
 * is_racing. What a completed batch has waited for is ordered as well. */
struct hazard_batch {
    uint32_t queue;  /* less than HAZARD_QUEUES */
    uint64_t number; /* among the batches of the queue; grows, need not be consecutive */
    const uint64_t *completed, *before;
    uint32_t count;
    bool is_certain;
};
void hazards_begin_batch(struct hazards *hazards, const struct hazard_batch *batch);
void hazards_end_batch(struct hazards *hazards);

/* Signals of semaphores, by a number that the caller gives them and never reuses. 0: no wait will
 * name the signal. `previous`: the number of the semaphore's last signal before; 0: none. A wait
 * follows the signal, the previous one, and so on. A wait for a signal that is unknown (0, or never
 * signalled here) counts as a wait for everything before.
 *
 * The access scopes of semaphores include all memory access of the device: what happens before a
 * signal is visible to everything that the wait happens before, whatever its kind. Only the stages
 * count. A signal also has in its first scope the signals of the queue's earlier batches (Signal
 * Operation Order). A fence is such a signal: describe it as signal 0 with all stages.
 *
 * The signals of the HAZARD_SIGNALS largest numbers are kept; the others count as unknown. */
enum { HAZARD_SIGNALS = 1024 };
void hazards_wait(struct hazards *hazards, uint64_t number, const struct dependency *dst);
void hazards_signal(struct hazards *hazards, uint64_t number, uint64_t previous,
                    const struct dependency *src);

/* The next command begins: the accesses that follow are its own. Returns the number that its first
 * access will have. */
uint64_t hazards_begin_command(struct hazards *hazards);
/* Returns the number of the access. Empty bytes are ignored (the number is still taken). */
uint64_t hazards_access(struct hazards *hazards, const struct hazard_access *access);

/* Whether the last write of the first byte is not visible to a read by the current command. Then
 * fills `hazard`, whose later access has the last number that was given. The read is not kept. */
bool hazards_read_is_early(struct hazards *hazards, const struct hazard_access *read,
                           struct hazard *hazard);

/* Compares a write by the current command, which has that number, with a read that was described by
 * an access without bytes, and is of its first byte. */
void hazards_write_after(struct hazards *hazards, const struct hazard_side *read, uint64_t number,
                         const struct hazard_access *write);
/* Returns the number of the first piece's last write among pieces of these bytes that were written
 * after the access of the number `since`, and sets `bytes` to what that piece has of them. Returns
 * 0 if there is none. */
uint64_t hazards_write_since(struct hazards *hazards, uint64_t since, struct hazard_bytes *bytes);

/* ---- Writes that shaders may make. The last ones are kept.
 *
 * If the data that a build reads has changed since an earlier build read it, and no access that was
 * described can have written it, one of these writes has. It is a hazard if none of those that were
 * submitted since the earlier build is visible to the later one: a write before the earlier build
 * that was not visible to that one is a hazard, too. */

/* Describes a write by the current command. `kind`: see access_is_anywhere(); ACCESS_KINDS: it
 * happens at an unknown stage, and counts as visible. `bytes`: all that it may write; NULL: any.
 * Returns its number. */
uint64_t hazards_write_anywhere(struct hazards *hazards, enum access_kind kind,
                                const struct hazard_bytes *bytes);
/* Returns the number of the last such write that was forgotten for lack of room before it was
 * visible to all; 0: none. */
uint64_t hazards_last_forgotten_write(const struct hazards *hazards);
/* Returns the number of the first write that is not certainly visible to a read of that kind now:
 * from it on, writes may happen after the read. */
uint64_t hazards_first_open_write(struct hazards *hazards, enum access_kind read);
/* Returns the last access that was described. */
struct hazard_side hazards_last_access(const struct hazards *hazards);
/* Whether there are writes from the number `first` on that may have written bytes of the read, and
 * none of them is both visible to the read and behind the access `since`, or on another queue than
 * that. Then fills `hazard` with the last of them that is not visible; the later access has the
 * last number given. */
bool hazards_read_misses_writes(struct hazards *hazards, uint64_t first,
                                const struct hazard_side *since, const struct hazard_access *read,
                                struct hazard *hazard);

/* All dependencies of one vkCmdPipelineBarrier. They do not continue each other. */
void hazards_barriers(struct hazards *hazards, const struct hazard_barrier *barriers,
                      uint32_t count);
/* `src`: the stages of the first scope. The event of an id that was destroyed is to be reset. An
 * event that was set twice has both first scopes, because the host may have reset it in between. */
void hazards_set_event(struct hazards *hazards, uint64_t event, stage_set src);
void hazards_reset_event(struct hazards *hazards, uint64_t event);
/* A wait for one event: its first scope are the commands before the event was set. An event that
 * was not set on this queue orders nothing. */
void hazards_wait_event(struct hazards *hazards, uint64_t event,
                        const struct hazard_barrier *barriers, uint32_t count);

/* Everything that is ordered before all work to come is dropped: completed[i] batches of each queue
 * have completed, as the host has observed, and every batch to come is submitted after that. Call
 * now and then. */
void hazards_prune(struct hazards *hazards, const uint64_t *completed, uint32_t count);
/* Drops accesses to memory that was freed. */
void hazards_forget_memory(struct hazards *hazards, uint64_t memory);
/* The number of pieces of memory that are remembered; for tests. */
uint64_t hazards_piece_count(const struct hazards *hazards);

#endif
