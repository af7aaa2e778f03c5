/* SPDX-License-Identifier: Apache-2.0 */
/* Helpers for every change of the tables: publishing and releasing records, counting destroyed
 * ones. */
#include <stdlib.h>

#include "src/state/resources/records.h"

void memory_record_release(struct memory_record *memory)
{
    if (memory && --memory->references == 0)
        free(memory);
}

bool resources_publish(struct resources *resources, struct handle_table *table, uint64_t handle,
                       void *record)
{
    bool published = record && handle_table_set(table, handle, record);
    if (!published)
        resources_become_incomplete(resources);
    return published;
}

void resources_count_destroyed(struct resources *resources)
{
    atomic_fetch_add_explicit(&resources->destroy_count, 1, memory_order_relaxed);
}

void resources_become_incomplete(struct resources *resources)
{
    resources->incomplete = true;
}
