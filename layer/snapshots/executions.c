/* SPDX-License-Identifier: Apache-2.0 */
/* Executions that were submitted: their batches keep them until they have run. */
#include "layer/snapshots/executions.h"
#include "layer/snapshots/snapshots.h"

static void snapshots_run(void *user, struct order_batch *batch)
{
    (void)user;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        struct execution *execution = atomic_load(&batch->commands[i].execution);
        execution_mark_reached(execution);
        execution_drop_invalidated(execution);
    }
}

static void snapshots_ran(void *user, struct order_batch *batch)
{
    (void)user;
    for (uint32_t i = 0; i < batch->command_count; i++)
        execution_release(atomic_exchange(&batch->commands[i].execution, NULL));
    order_batch_let_go(batch, USES_EXECUTIONS);
}

/* ---- executions that never run in order */

/* Takes the executions of all batches, in the order of submission. */
static void take_all(struct snapshots *snapshots,
                     void (*use)(struct snapshots *snapshots, struct execution *execution))
{
    struct batch_list *batches = execution_order_batches(snapshots->device->order);
    for (struct order_batch *batch;
         (batch = batch_list_take(batches, IN_SUBMISSION_ORDER, USES_EXECUTIONS, NULL, NULL));) {
        for (uint32_t i = 0; i < batch->command_count; i++) {
            struct execution *execution = atomic_exchange(&batch->commands[i].execution, NULL);
            if (execution)
                use(snapshots, execution);
        }
        order_batch_release(batch);
    }
}

void snapshots_run_unordered(struct snapshots *snapshots, struct execution *execution)
{
    execution_order_run_unordered(snapshots->device->order, execution);
    execution_release(execution);
    atomic_fetch_add(&snapshots->unordered, 1);
}

void snapshots_run_all(struct snapshots *snapshots)
{
    take_all(snapshots, snapshots_run_unordered);
}

static void order_unknown(void *user, enum order_unknown_reason why)
{
    struct snapshots *snapshots = user;
    snapshots->unknown_reason = why;
    unknown_follow(&snapshots->order_unknown, true);
    snapshots_run_all(snapshots);
    warn_unordered(snapshots->device);
}

static void release_held(struct snapshots *snapshots, struct execution *execution)
{
    snapshots->held++;
    execution_release(execution);
}

void snapshots_release_held(struct snapshots *snapshots)
{
    if (snapshots && snapshots->device->order)
        take_all(snapshots, release_held);
}

struct batch_consumer snapshots_consumer(struct snapshots *snapshots)
{
    return (struct batch_consumer){.user = snapshots,
                                   .run = snapshots_run,
                                   .ran = snapshots_ran,
                                   .order_unknown = order_unknown};
}
