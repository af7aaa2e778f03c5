/* SPDX-License-Identifier: Apache-2.0 */
/* The first byte of a structure was last written by the structure's last build or copy. If another
 * access wrote it later, that has overwritten the structure. */
#include "layer/execution/hazards/overwritten.h"

void judge_written(struct hazard_judge *judge, uint64_t structure, uint64_t number)
{
    if (!number || !handle_table_set(&judge->written, structure, (void *)(uintptr_t)number))
        handle_table_remove(&judge->written, structure);
}

/* Returns the write that came after the structure's own last one; 0: none is known. */
static uint64_t find_overwriting(const struct hazard_judge *judge, const struct hazard_access *read,
                                 uint64_t structure)
{
    const uint64_t own =
        judge->lacks_accesses ? 0 : (uintptr_t)handle_table_find(&judge->written, structure);
    const uint64_t last = own ? hazards_last_write(judge->hazards, &read->bytes) : 0;
    return last > own ? last : 0;
}

/* A read that is too early is reported as such. */
uint64_t judge_structure_read(struct hazard_judge *judge, const struct hazard_access *read,
                              uint64_t structure)
{
    struct hazard early;
    const uint64_t last = find_overwriting(judge, read, structure);
    const bool is_late = last && !hazards_read_is_early(judge->hazards, read, &early);
    const uint64_t number = hazards_access(judge->hazards, read);
    if (is_late)
        hazard_judge_found(judge, &(struct hazard){.type = READ_OF_OVERWRITTEN,
                                                   .earlier = {.number = last},
                                                   .later = {.number = number, .kind = read->kind},
                                                   .bytes = read->bytes});
    return number;
}
