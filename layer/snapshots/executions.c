/* SPDX-License-Identifier: Apache-2.0 */
/* Executions that were submitted. Each goes to the consumers at its execution point. */
#include "layer/snapshots/consumers.h"
#include "layer/snapshots/coverage_warnings.h"
#include "layer/snapshots/snapshots.h"

/* ---- consumers */

void snapshots_add_consumer(struct snapshots *snapshots, struct snapshots_consumer *consumer)
{
    struct snapshots_consumer **last = &snapshots->consumers;
    while (*last)
        last = &(*last)->next;
    consumer->next = NULL;
    *last = consumer;
}

/* Passes the execution to each consumer, then releases it. */
static void run_consumers(const struct snapshots *snapshots,
                          const struct submitted_execution *submitted)
{
    for (const struct snapshots_consumer *consumer = snapshots->consumers; consumer;
         consumer = consumer->next)
        if (consumer->run)
            consumer->run(consumer->user, submitted);
    execution_release(submitted->execution);
}

void snapshots_deliver_complete(struct layer_device *device)
{
    for (const struct snapshots_consumer *consumer = device->snapshots->consumers; consumer;
         consumer = consumer->next)
        if (consumer->deliver)
            consumer->deliver(consumer->user);
}

bool snapshots_wait(const struct snapshots *snapshots)
{
    for (const struct snapshots_consumer *consumer = snapshots->consumers; consumer;
         consumer = consumer->next)
        if (consumer->wait && consumer->wait(consumer->user))
            return true;
    return false;
}

/* ---- executions */

void snapshots_add_submitted(struct snapshots *snapshots, struct execution *execution)
{
    pthread_mutex_lock(&snapshots->submitted_lock);
    *snapshots->submitted_last = execution;
    snapshots->submitted_last = &execution->next;
    pthread_mutex_unlock(&snapshots->submitted_lock);
}

/* Removes the first execution of a recording from the list, or the first of all if `recording` is
 * NULL. Returns NULL if there is none. */
static struct execution *take(struct snapshots *snapshots, const struct recording *recording)
{
    pthread_mutex_lock(&snapshots->submitted_lock);
    struct execution **at = &snapshots->submitted;
    while (*at && recording && (*at)->recording != recording)
        at = &(*at)->next;
    struct execution *execution = *at;
    if (execution) {
        *at = execution->next;
        execution->next = NULL;
        if (!*at)
            snapshots->submitted_last = at;
    }
    pthread_mutex_unlock(&snapshots->submitted_lock);
    return execution;
}

static void run_command(struct snapshots *snapshots, const struct batch_run *batch,
                        uint32_t command)
{
    const struct journal *journal = batch->commands[command].captured;
    struct execution *execution = journal && journal->work ? take(snapshots, journal->work) : NULL;
    if (!execution)
        return;
    execution_mark_reached(execution);
    execution_drop_invalidated(execution);
    run_consumers(snapshots,
                  &(struct submitted_execution){execution, batch->timestamp, batch, command});
}

void snapshots_run(struct snapshots *snapshots, const struct batch_run *batch)
{
    for (uint32_t i = 0; i < batch->command_count; i++)
        run_command(snapshots, batch, i);
}

void snapshots_run_all(struct snapshots *snapshots)
{
    for (struct execution *execution; (execution = take(snapshots, NULL));) {
        run_consumers(snapshots, &(struct submitted_execution){.execution = execution,
                                                               .timestamp = timestamp_never()});
        atomic_fetch_add(&snapshots->unordered, 1);
    }
}

void snapshots_set_order_unknown(struct snapshots *snapshots, enum order_unknown_reason why)
{
    snapshots->unknown_reason = why;
    atomic_store(&snapshots->order_unknown, true);
    snapshots_run_all(snapshots);
    warn_unordered(snapshots->device);
}
