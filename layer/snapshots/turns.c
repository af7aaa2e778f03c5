/* SPDX-License-Identifier: Apache-2.0 */
/* Executions that were submitted, and whose turn it is. */
#include <stdlib.h>

#include "layer/cpu/submits.h"
#include "layer/execution/contents.h"
#include "layer/snapshots/snapshots.h"
#include "layer/snapshots/tell.h"
#include "layer/snapshots/tickets.h"

void snapshots_expect(struct snapshots *snapshots, struct execution *execution)
{
    pthread_mutex_lock(&snapshots->expected_lock);
    *snapshots->expected_last = execution;
    snapshots->expected_last = &execution->next;
    pthread_mutex_unlock(&snapshots->expected_lock);
}

/* The first execution of a recording, or of any, taken off the list; or NULL. */
static struct execution *take(struct snapshots *snapshots, const struct recording *recording)
{
    pthread_mutex_lock(&snapshots->expected_lock);
    struct execution **at = &snapshots->expected;
    while (*at && recording && (*at)->recording != recording)
        at = &(*at)->next;
    struct execution *execution = *at;
    if (execution) {
        *at = execution->next;
        execution->next = NULL;
        if (!*at)
            snapshots->expected_last = at;
    }
    pthread_mutex_unlock(&snapshots->expected_lock);
    return execution;
}

static void run_command(struct layer_device *device, const struct batch_run *run, uint32_t command)
{
    const struct journal *journal = run->commands[command].captured;
    struct execution *execution =
        journal && journal->work ? take(device->snapshots, journal->work) : NULL;
    if (!execution)
        return;
    execution_take_turn(execution);
    if (atomic_load(&execution->recording->is_spoiled))
        execution_lose(execution);
    if (device->cpu)
        cpu_overlay_run(device, execution, run->moment);
    contents_run(device->contents, run, command, execution);
    execution_release(execution);
}

void snapshots_run(struct layer_device *device, const struct batch_run *run)
{
    for (uint32_t i = 0; i < run->command_count; i++)
        run_command(device, run, i);
}

void snapshots_run_all(struct layer_device *device)
{
    for (struct execution *execution; (execution = take(device->snapshots, NULL));) {
        if (device->cpu)
            cpu_overlay_run(device, execution, moment_never());
        execution_release(execution);
        atomic_fetch_add(&device->snapshots->unordered, 1);
    }
}

void snapshots_lose_order(struct layer_device *device, enum order_loss why)
{
    device->snapshots->loss = why;
    atomic_store(&device->snapshots->order_lost, true);
    snapshots_run_all(device);
    tell_unordered(device);
}

void snapshots_deliver_complete(struct layer_device *device)
{
    contents_deliver(device->contents);
    if (device->cpu)
        cpu_overlay_deliver(device);
}
