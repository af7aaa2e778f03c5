/* SPDX-License-Identifier: Apache-2.0 */
/* Consumers of snapshots: the validation of input data, and the backend that executes builds. The
 * snapshots reach consumers through these functions only. */
#ifndef ASSAY_LAYER_SNAPSHOTS_CONSUMERS_H
#define ASSAY_LAYER_SNAPSHOTS_CONSUMERS_H

#include "layer/layer.h"
#include "src/snapshots/recording.h"

/* An execution of a command buffer's recording, at its point in execution order. */
struct submitted_execution {
    struct execution *execution;
    struct timestamp timestamp;    /* timestamp_never() if the order is unknown */
    const struct batch_run *batch; /* NULL if the order is unknown */
    uint32_t command;              /* index of the command buffer in the batch */
};

/* A consumer lives as long as the device. Each function may be NULL. */
struct snapshots_consumer {
    struct snapshots_consumer *next; /* for snapshots_add_consumer() */
    void *user;                      /* passed to each function */

    /* Takes an execution, whose copies the device may not have written yet. Shares the execution if
     * it is needed later. Called in execution order, by one thread at a time, without a lock. If
     * the order is unknown, called by any thread with the queues locked, right after the
     * submission: then it sends no message. */
    void (*run)(void *user, const struct submitted_execution *submitted);
    /* Uses the copies of the executions that the application has observed to be complete. Called by
     * any thread, without a lock, when the application waits, queries or submits. */
    void (*deliver)(void *user);
    /* Waits for one execution to complete, then does what `deliver` does. Returns false if there is
     * none, or if it does not complete in a while. Called by any thread, without a lock. */
    bool (*wait)(void *user);
};

/* Call before the device is published. Consumers are called in the order in which they were added.
 */
void snapshots_add_consumer(struct snapshots *snapshots, struct snapshots_consumer *consumer);

/* Calls `wait` of each consumer until one returns true. */
bool snapshots_wait(const struct snapshots *snapshots);

#endif
