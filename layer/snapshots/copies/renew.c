/* SPDX-License-Identifier: Apache-2.0 */
/* Updates copy orders at a submission. */
#include "layer/snapshots/copies/renew.h"

#include "layer/snapshots/copies/gather.h"
#include "layer/snapshots/copies/orders.h"
#include "layer/snapshots/guard/orders.h"
#include "layer/snapshots/marks.h"

struct renewal {
    const struct layer_device *device;
    const struct ticket *next;
    bool has_limits;
    struct execution_clock seen; /* completions that the host has observed */
};

static void renew_order(const struct renewal *renewal, struct copy_order *order)
{
    struct resources *resources = renewal->device->resources;
    struct address_facts facts;
    order->is_done = 0;
    if (!order->source)
        return;
    if (order->size) {
        order->left =
            resources_find_readable(resources, order->source, order->size, &renewal->seen);
        return;
    }
    resources_look_up_address(resources, order->source, &facts);
    order->left = facts.status == ADDRESS_IN_BUFFER ? facts.bytes_left : 0;
}

static void renew(const struct renewal *renewal, struct recording *recording)
{
    bool is_pending = recording_is_pending(recording, renewal->next);
    bool has_chunks = recording_open_gate(recording);
    bool is_renewed = has_chunks && !is_pending;
    recording_clear_marks(recording, renewal->next, is_pending);
    for (uint32_t i = 0; i < recording->copy_block_count && is_renewed; i++) {
        const struct copy_block *block = &recording->copy_blocks[i];
        for (uint32_t j = 0; block->orders.chunk < recording->chunk_count && j < block->used; j++)
            renew_order(renewal, &copy_orders_at(recording, &block->orders)[j]);
    }
    if (is_renewed)
        gather_renew_ranges(renewal->device, recording);
    if (has_chunks)
        guard_renew(renewal->device, recording, &renewal->seen, !is_renewed, renewal->has_limits);
    struct journal_cursor cursor = journal_start_secondaries(recording->journal);
    for (const struct journal_entry *entry; (entry = journal_next(&cursor));)
        if (entry->secondary->work)
            renew(renewal, entry->secondary->work);
}

void copy_orders_renew(const struct layer_device *device, struct recording *recording,
                       const struct ticket *next, bool has_limits)
{
    struct renewal renewal = {.device = device, .next = next, .has_limits = has_limits};
    execution_order_host_clock(device->order, &renewal.seen);
    renew(&renewal, recording);
}
