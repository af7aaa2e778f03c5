/* SPDX-License-Identifier: Apache-2.0 */
/* Reports what the guard replaced. */
#include "layer/snapshots/guard/results.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/base/text_buffer.h"
#include "src/snapshots/recorded_build.h"
#include "src/state/commands/journal.h"

void guard_results_add(struct guard_results *results, const struct journal *journal,
                       const struct recorded_build *build, unsigned char *const *bases)
{
    struct guard_order order;
    if (!build->guard.has_order)
        return;
    memcpy(&order, bases[build->guard.order_chunk] + build->guard.order_offset, sizeof(order));
    if (!order.is_done || !(order.replaced || order.unreadable))
        return;
    if (!ARRAY_HAS_ROOM(results->items, results->count, results->capacity))
        return;
    results->items[results->count++] = (struct guard_result){
        journal, build->place.position, order.replaced, order.first_replaced, order.unreadable,
        false};
}

static bool is_about_references(enum rule rule)
{
    return rule == RULE_instance_references_are_zero_or_a_blas ||
           rule == RULE_instances_are_backed_by_memory ||
           rule == RULE_nv_instance_references_are_blas_handles ||
           rule == RULE_nv_instance_references_are_of_live_structures;
}

uint32_t guard_results_explain(struct guard_results *results, const struct journal *journal,
                               uint32_t position, enum rule rule)
{
    for (uint32_t i = 0; i < results->count && is_about_references(rule); i++) {
        struct guard_result *result = &results->items[i];
        if (result->journal != journal || result->position != position || !result->replaced)
            continue;
        result->is_reported = true;
        return result->replaced;
    }
    return 0;
}

static void warn(const struct guard_result *result, const struct layer_device *device)
{
    char line[512];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append(&text,
                "assay_validation.guard = references: in build %" PRIu32
                " of VkCommandBuffer 0x%" PRIx64 " the layer replaced ",
                result->position, (uint64_t)(uintptr_t)result->journal->command_buffer);
    if (result->replaced) {
        text_append_count(&text, result->replaced, "reference");
        text_append(&text,
                    " by 0 to what is not a live, built bottom-level acceleration structure. The "
                    "first is that of instance %" PRIu32,
                    result->first_replaced);
    }
    if (result->unreadable) {
        text_append(&text, result->replaced ? "; also " : "");
        text_append_count(&text, result->unreadable, "instance");
        text_append(&text, " in memory that cannot be read by inactive ones");
    }
    text_append(&text, ".");
    reporter_warn(device->instance->reporter, line);
}

void guard_results_end(struct guard_results *results, const struct layer_device *device)
{
    for (uint32_t i = 0; i < results->count; i++)
        if (!results->items[i].is_reported)
            warn(&results->items[i], device);
    free(results->items);
    *results = (struct guard_results){0};
}
