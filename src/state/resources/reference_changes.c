/* SPDX-License-Identifier: Apache-2.0 */
/* Changes of the values that instances refer to structures by. */
#include "src/state/resources/reference_changes.h"

#include "src/base/array.h"
#include "src/state/resources/records.h"

void resources_watch_references(struct resources *resources)
{
    resources->watched.is_on = true;
}

/* Without memory a change is lost, so all values count as valid from then on. */
void resources_note_reference(struct resources *resources, uint64_t reference, bool is_nv)
{
    struct watched_references *watched = &resources->watched;
    if (!watched->is_on || !reference)
        return;
    if (ARRAY_HAS_ROOM(watched->changes, watched->count, watched->capacity))
        watched->changes[watched->count++] =
            (struct reference_change){.reference = reference, .is_nv = is_nv};
    else
        watched->lacks_memory = true;
}

static bool is_live(const struct accel_facts *facts)
{
    return facts->backed != NO && (!facts->details_known ||
                                   facts->type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR ||
                                   facts->type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
}

static void describe(const struct resources *resources, struct reference_change *change)
{
    uint32_t count = 0;
    if (change->is_nv) {
        const struct nv_reference_record *record =
            handle_table_find(&resources->nv_references, change->reference);
        change->is_live = record && record->alive > record->without_memory &&
                          record->level != NV_REFERENCE_TOP_LEVEL;
        return;
    }
    const struct accel_record *accel = accel_records_at(resources, change->reference);
    for (; accel; accel = accel->same_address) {
        change->is_live |= is_live(&accel->facts);
        change->id = count++ ? 0 : accel->facts.id;
    }
}

uint32_t resources_take_reference_changes(struct resources *resources,
                                          struct reference_change **changes,
                                          struct unknown_references *unknown)
{
    struct watched_references *watched = &resources->watched;
    reader_lock_write(&resources->lock);
    uint32_t count = watched->count;
    *changes = watched->changes;
    for (uint32_t i = 0; i < count; i++)
        describe(resources, &watched->changes[i]);
    watched->changes = NULL;
    watched->count = watched->capacity = 0;
    bool is_unknown = resources->incomplete || watched->lacks_memory;
    *unknown = (struct unknown_references){.khr = is_unknown || resources->unknown_references,
                                           .nv = is_unknown || resources->nv_references_unknown};
    reader_lock_write_done(&resources->lock);
    return count;
}
