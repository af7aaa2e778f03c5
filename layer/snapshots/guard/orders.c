/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the orders of guarded builds. */
#include "layer/snapshots/guard/orders.h"

#include "layer/snapshots/copies/gather.h"
#include "src/snapshots/recorded_build.h"

/* Memory that is not known to be unreadable is read, as the build would read it. */
static uint32_t readable_bytes(struct resources *resources, uint64_t address, uint64_t size,
                               const struct execution_clock *seen)
{
    struct address_facts facts;
    uint64_t readable = resources_find_readable(resources, address, size, seen);
    if (readable)
        return readable < GUARD_UNLIMITED ? (uint32_t)readable : GUARD_UNLIMITED;
    resources_look_up_address(resources, address, &facts);
    bool is_certain = facts.status == ADDRESS_NULL || facts.status == ADDRESS_NOWHERE ||
                      facts.status == ADDRESS_UNBOUND;
    return is_certain ? 0 : GUARD_UNLIMITED;
}

static void write_ranges(struct resources *resources, const struct recording *recording,
                         const struct build_guard *guard, struct guard_order *order)
{
    unsigned char *bytes = recording->chunks[guard->ranges_chunk]->bytes + guard->ranges_offset;
    bool is_whole = gather_write_ranges(resources, bytes, guard->ranges_size) &&
                    !resources_has_unknown_ranges(resources);
    order->range_count =
        is_whole ? (uint32_t)(guard->ranges_size / sizeof(uint64_t[2])) : GUARD_UNLIMITED;
}

/* `source`, `ranges` and `indirect` were written when the build was recorded. */
static void write_order(struct resources *resources, const struct recording *recording,
                        const struct execution_clock *seen, const struct build_guard *guard,
                        uint32_t limit, struct guard_order *order)
{
    order->readable = guard->is_nv
                          ? GUARD_UNLIMITED
                          : readable_bytes(resources, guard->source, guard->source_size, seen);
    order->can_read_range =
        !guard->indirect || readable_bytes(resources, guard->indirect, 16, seen) >= 16;
    order->range_count = 0;
    if (guard->ranges_size)
        write_ranges(resources, recording, guard, order);
    order->limit = limit;
    order->replaced = order->unreadable = order->is_done = 0;
    order->first_replaced = UINT32_MAX;
}

void guard_renew(const struct layer_device *device, const struct recording *recording,
                 const struct execution_clock *seen, bool is_pending, bool has_limits)
{
    if (!recording->has_guards)
        return;
    for (const struct recorded_build *build = recording->builds; build; build = build->next) {
        const struct build_guard *guard = &build->guard;
        if (!guard->has_order)
            continue;
        struct guard_order *order =
            (void *)(recording->chunks[guard->order_chunk]->bytes + guard->order_offset);
        uint32_t limit = has_limits ? atomic_load(&guard->limit) : GUARD_ALL_LIVE;
        if (!is_pending)
            write_order(device->resources, recording, seen, guard, limit, order);
        else if (limit > order->limit)
            __atomic_store_n(&order->limit, limit, __ATOMIC_RELAXED);
    }
}
