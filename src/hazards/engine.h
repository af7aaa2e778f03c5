/* SPDX-License-Identifier: Apache-2.0 */
/* The state of the hazard check. Only the sources of this folder include this header. */
#ifndef ASSAY_HAZARDS_ENGINE_H
#define ASSAY_HAZARDS_ENGINE_H

#include "src/base/handle_table.h"
#include "src/hazards/frontier.h"
#include "src/hazards/hazards.h"
#include "src/hazards/ranges.h"

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

struct hazards {
    void (*found)(void *user, const struct hazard *hazard);
    void *user;
    uint64_t number;        /* the last one given */
    uint64_t command_first; /* of the current command's accesses */
    bool has_failed;        /* memory ran out during the current call */
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

/* Compares an access of the current command with the earlier ones (judge.c). */
void hazards_judge(struct hazards *hazards, struct piece *piece, uint64_t number,
                   const struct hazard_access *access);

/* Ends the current batch. Returns what happened before its end on other queues. Returns NULL if
 * that is nothing or memory runs out. */
struct signal *hazards_complete_batch(struct hazards *hazards);
/* What happened before the signal happens before the stages `dst` of the current queue, with all
 * memory. */
void hazards_receive(struct hazards *hazards, const struct signal *signal, stage_set dst);
void hazards_free_event(void *record);

#endif
