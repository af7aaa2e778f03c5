/* SPDX-License-Identifier: Apache-2.0 */
/* Executions that were submitted, and whose turn it is. */
#include <stdlib.h>

#include "layer/cpu/submits.h"
#include "layer/execution/input_checks.h"
#include "layer/snapshots/coverage_warnings.h"
#include "layer/snapshots/snapshots.h"
#include "layer/snapshots/tickets.h"

void snapshots_add_submitted(struct snapshots *snapshots, struct execution *execution)
{
    pthread_mutex_lock(&snapshots->submitted_lock);
    *snapshots->submitted_last = execution;
    snapshots->submitted_last = &execution->next;
    pthread_mutex_unlock(&snapshots->submitted_lock);
}

/* The first execution of a recording, or of any, taken off the list; or NULL. */
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

static void run_command(struct layer_device *device, const struct batch_run *run, uint32_t command)
{
    const struct journal *journal = run->commands[command].captured;
    struct execution *execution =
        journal && journal->work ? take(device->snapshots, journal->work) : NULL;
    if (!execution)
        return;
    execution_mark_reached(execution);
    if (atomic_load(&execution->recording->is_invalidated))
        execution_drop_snapshots(execution);
    if (device->cpu)
        cpu_overlay_run(device, execution, run->timestamp);
    input_checks_run(device->input_checks, run, command, execution);
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
            cpu_overlay_run(device, execution, timestamp_never());
        execution_release(execution);
        atomic_fetch_add(&device->snapshots->unordered, 1);
    }
}

void snapshots_set_order_unknown(struct layer_device *device, enum order_unknown_reason why)
{
    device->snapshots->unknown_reason = why;
    atomic_store(&device->snapshots->order_unknown, true);
    snapshots_run_all(device);
    warn_unordered(device);
}

void snapshots_deliver_complete(struct layer_device *device)
{
    input_checks_deliver(device->input_checks);
    if (device->cpu)
        cpu_overlay_deliver(device);
}
