/* SPDX-License-Identifier: Apache-2.0 */
/* Up to where the past of a queue is ordered before the future of a queue (Vulkan specification,
 * Synchronization and Cache Control: Execution and Memory Dependencies).
 *
 * A dependency concerns all earlier commands of a queue. So the accesses that it orders are all
 * those up to a number, and the union of what several dependencies order is described by the
 * greatest of their numbers. Rows of stages and kinds that no access has had yet stay 0: all
 * numbers to come are greater. */
#ifndef ASSAY_HAZARDS_ENGINE_H
#define ASSAY_HAZARDS_ENGINE_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/handle_table.h"
#include "src/base/unknown.h"
#include "src/hazards/hazards.h"
#include "src/hazards/ranges.h"

/* What the commands of one queue from now on know of the accesses of one queue until now. Each
 * element is a number: the statement holds for all accesses up to it. */
struct frontier {
    uint64_t completed; /* the last batch whose completion this has */
    uint64_t settled;   /* accesses are ordered before all stages and kinds */
    /* [x][d]: accesses at stage x happen before stage d. */
    uint64_t executed[SYNC_ACCESS_STAGES][SYNC_STAGES];
    /* [k][d]: writes of kind k are available, and the availability operation happens before stage
     * d. */
    uint64_t available[ACCESS_KINDS][SYNC_STAGES];
    /* [k][d]: a semaphore has made the writes visible to all accesses, and that happens before
     * stage d. */
    uint64_t shared[ACCESS_KINDS][SYNC_STAGES];
    /* [k][b]: a barrier has made the writes visible to accesses of kind b. */
    uint64_t visible[ACCESS_KINDS][ACCESS_KINDS];
};

/* How buffer barriers of a queue continue on the same queue. They stand at a stage and at the
 * number of their command; rows exist for stages at which one stands. Semaphores need no chains:
 * they make everything available that happens before. */
struct chains {
    stage_set rows;
    uint64_t reached[SYNC_STAGES][SYNC_STAGES]; /* [x][d]: stage x happens before stage d */
    /* [x][b]: what is available at stage x is visible to accesses of kind b. */
    uint64_t visible[SYNC_STAGES][ACCESS_KINDS];
};

/* What happens before a signal or the setting of an event, of one queue's accesses. */
struct reached {
    uint64_t executed[SYNC_ACCESS_STAGES];
    uint64_t available[ACCESS_KINDS], shared[ACCESS_KINDS];
};

/* The stages and kinds of all accesses that a queue has had. */
struct past {
    stage_set stages;
    kind_set writes;
};

/* A setting of an event. One that was set already is not set again; but the host may have reset it
 * in between, which is not known. So all settings count since the last known reset. */
struct hazard_event {
    struct hazard_event *next; /* owned; another setting on the same queue */
    uint32_t queue;
    uint64_t before; /* accesses of the queue up to this number come before the setting */
    stage_set src;
    uint64_t chains[SYNC_STAGES];           /* of its queue */
    struct reached *reached[HAZARD_QUEUES]; /* NULL: nothing */
};

/* The first scope of the dependencies of one command. */
struct first_scope {
    uint64_t before; /* accesses of the same queue up to this number come before the command */
    /* NULL, or the event that is waited for: what came before its setting replaces the stages of a
     * barrier. */
    const struct hazard_event *event;
};

/* The dependencies of one command, as they concern the accesses of one queue. They do not continue
 * each other. */
struct crossing {
    struct first_scope scope;
    const struct hazard_barrier *barriers;
    uint32_t count;
    uint32_t past_queue; /* whose accesses */
    bool is_own;         /* the command is on the same queue */
};

/* The kinds of accesses that are performed at the stages. */
kind_set kinds_at(stage_set stages);

static inline uint64_t later_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* Returns the greatest element of a row at these stages, or 0. */
static inline uint64_t row_reach(const uint64_t row[SYNC_STAGES], stage_set stages)
{
    uint64_t reach = 0;
    for (; stages; stages &= stages - 1) {
        const uint64_t element = row[__builtin_ctz(stages)];
        reach = element > reach ? element : reach;
    }
    return reach;
}

/* The greatest number that reaches the first scope of a barrier with the stages `src`: of accesses
 * at stage x, of available writes of kind k, and of buffer barriers at stage x. The rows are those
 * of `struct frontier` and `struct chains`. */
uint64_t scope_executed(const struct first_scope *scope, const uint64_t executed[SYNC_STAGES],
                        uint32_t past_queue, bool is_own, stage_set src, enum sync_stage x);
uint64_t scope_available(const struct first_scope *scope, const uint64_t available[SYNC_STAGES],
                         uint32_t past_queue, stage_set src, enum access_kind k);
uint64_t scope_chain(const struct first_scope *scope, const uint64_t reached[SYNC_STAGES],
                     stage_set src, enum sync_stage x);
/* The greatest number of a write of kind k, of the same queue, in the first access scope; or 0. */
uint64_t scope_direct(const struct first_scope *scope, const struct dependency *dependency,
                      enum access_kind k);

void frontier_cross(struct frontier *frontier, const struct past *past,
                    const struct crossing *crossing);
void chains_cross(struct chains *chains, const struct crossing *crossing);

/* Adds what a semaphore has brought: executed[x] happens before `dst`, with all memory. */
void frontier_receive(struct frontier *frontier, const struct past *past,
                      const uint64_t executed[SYNC_ACCESS_STAGES], stage_set dst);

/* Whether a write of kind k with a number is available and visible to kind b, but for buffer
 * barriers; and whether an access at stage x happens before stage d. */
static inline bool frontier_orders_write(const struct frontier *frontier, uint64_t number,
                                         enum access_kind k, enum access_kind b)
{
    return number <= frontier->settled || number <= frontier->visible[k][b] ||
           number <= frontier->shared[k][access_stage(b)];
}

static inline bool frontier_executes(const struct frontier *frontier, uint64_t number,
                                     enum sync_stage x, enum sync_stage d)
{
    return number <= frontier->settled || number <= frontier->executed[x][d];
}

/* ---- the state of the hazard check. Only the sources of this folder include this header */

/* What happens before a signal: accesses of a queue at stage x up to executed[x]. */
struct signal {
    uint64_t number;
    uint32_t count;
    struct signal_past {
        uint32_t queue;
        uint64_t executed[SYNC_ACCESS_STAGES];
    } pasts[];
};

/* A batch of a queue: its accesses have numbers from `first` on. */
struct batch_record {
    uint64_t number, first;
    /* What happened before the end of the batch on other queues; NULL: nothing. */
    struct signal *completion;
};

struct hazard_queue {
    struct past past;
    /* Up to this number, accesses of this queue are ordered before everything to come. */
    uint64_t settled;
    /* What this queue knows of each queue; NULL: nothing. */
    struct frontier *from[HAZARD_QUEUES];
    struct chains *chains; /* NULL until a buffer barrier has made a write available */
    /* What the signals of the queue's earlier batches have in their first scopes. */
    uint64_t signalled[HAZARD_QUEUES][SYNC_ACCESS_STAGES];
    struct batch_record *batches; /* since the last one that is settled; in ascending order */
    uint32_t batch_count, batch_capacity;
};

struct hazard_memory {
    uint64_t id;
    struct ranges ranges;
};

/* Writes by shaders, in ascending order: a ring of the last ones. */
enum { WRITES_ANYWHERE = 4096 };
struct writes_anywhere {
    struct write_anywhere {
        uint64_t number;
        uint32_t queue;
        enum access_kind kind;
        struct hazard_bytes bytes; /* memory 0: unknown */
    } items[WRITES_ANYWHERE];
    uint64_t first, end; /* positions, modulo WRITES_ANYWHERE */
    /* The number of the last write of each queue that is not kept; 0: none. */
    uint64_t dropped[HAZARD_QUEUES];
    uint64_t unsettled; /* of the last one that was dropped before it was settled; 0: none */
    uint32_t queues;    /* bits of the queues that had such writes */
};

struct hazards {
    void (*found)(void *user, const struct hazard *hazard);
    void *user;
    uint64_t number;        /* the last one given */
    uint64_t command_first; /* of the current command's accesses */
    struct unknown failure; /* memory ran out during the current call */
    uint32_t queue;         /* of the current batch */
    uint64_t batch;         /* its number */
    uint64_t before[HAZARD_QUEUES];
    /* What the current batch's signals have in their first scopes, once there is one. */
    uint64_t signalled[HAZARD_QUEUES][SYNC_ACCESS_STAGES];
    bool has_signalled;
    struct hazard_queue queues[HAZARD_QUEUES];
    /* Records by id + 1, as a table has no key 0. */
    struct handle_table memories, events;
    struct signal *signals[HAZARD_SIGNALS]; /* by number % HAZARD_SIGNALS; NULL: none */
    struct hazard_memory *recent;           /* the memory of the last access, or NULL */
    uint64_t piece_count, swept_count;      /* of all memory; after the last sweep */
    struct writes_anywhere writes;
};

/* Returns the frontier from a queue to the current one. Returns NULL, and notes the failure, if
 * memory runs out. */
struct frontier *hazards_frontier(struct hazards *hazards, uint32_t past_queue);
/* Returns NULL if there is none; `is_new`: creates it then, unless memory runs out. */
struct hazard_memory *hazards_memory(struct hazards *hazards, uint64_t id, bool is_new);
/* If memory has run out during a call: drops all accesses and counts everything before as ordered.
 * Each call that changes something ends with this. */
void hazards_settle_failure(struct hazards *hazards);
/* Everything before counts as ordered for the current queue. */
void hazards_settle_queue(struct hazards *hazards);
/* The batch of an access. */
uint64_t hazards_batch_of(const struct hazards *hazards, uint32_t queue, uint64_t number);

/* Ends the current batch. Returns what happened before its end on other queues. Returns NULL if
 * that is nothing or memory runs out. */
struct signal *hazards_complete_batch(struct hazards *hazards);
/* What happened before the signal happens before the stages `dst` of the current queue, with all
 * memory. */
void hazards_receive(struct hazards *hazards, const struct signal *signal, stage_set dst);
void hazards_free_event(void *record);

#endif
