/* SPDX-License-Identifier: Apache-2.0 */
/* The bytes of a structure were last written by the structure's last build or copy. If another
 * access wrote some of them later, that has overwritten the structure. */
#include "layer/execution/hazards/overwritten.h"

#include <stdlib.h>

/* A position that no build has. */
enum { NO_BUILD = UINT32_MAX };

/* The last write of a structure. */
struct written {
    uint64_t number; /* of the access */
    struct hazard_bytes bytes;
};

static void forget_written(struct hazard_judge *judge, uint64_t structure)
{
    free(handle_table_remove(&judge->written, structure));
}

/* Returns the record of a structure, and adds one if there is none; NULL if memory runs out. */
static struct written *find_written(struct hazard_judge *judge, uint64_t structure)
{
    struct written *written = handle_table_find(&judge->written, structure);
    if (written)
        return written;
    written = calloc(1, sizeof(*written));
    if (written && handle_table_set(&judge->written, structure, written))
        return written;
    free(written);
    return NULL;
}

void judge_written(struct hazard_judge *judge, uint64_t structure, uint64_t number,
                   const struct hazard_bytes *bytes)
{
    struct written *written = number ? find_written(judge, structure) : NULL;
    if (written)
        *written = (struct written){number, *bytes};
    else
        forget_written(judge, structure);
}

void judge_forget_all_written(struct hazard_judge *judge)
{
    handle_table_drop(&judge->written, free);
}

/* Returns the number of a write that came after the structure's own last one, and of which bytes;
 * 0: none is known. */
static uint64_t find_overwriting(const struct hazard_judge *judge, uint64_t structure,
                                 struct hazard_bytes *bytes)
{
    const struct written *own = handle_table_find(&judge->written, structure);
    if (!own)
        return 0;
    *bytes = own->bytes;
    return hazards_write_since(judge->hazards, own->number, bytes);
}

/* Whether a write by the current command is of the build at that position. */
static bool is_of_build(const struct hazard_judge *judge, uint64_t number, uint32_t position)
{
    struct hazard_access_text write;
    return hazard_judge_find_side(judge, number, &write) && write.is_build &&
           write.origin.build_index + write.info == position;
}

/* A read that is too early is reported as such. */
static uint64_t judge_read(struct hazard_judge *judge, const struct hazard_access *read,
                           uint64_t structure, uint32_t position)
{
    struct hazard early;
    struct hazard_bytes bytes;
    const uint64_t last = find_overwriting(judge, structure, &bytes);
    const bool is_late = last &&
                         (last < judge->command_first || is_of_build(judge, last, position)) &&
                         !hazards_read_is_early(judge->hazards, read, &early);
    const uint64_t number = hazards_access(judge->hazards, read);
    if (is_late)
        hazard_judge_found(judge, &(struct hazard){.type = READ_OF_OVERWRITTEN,
                                                   .earlier = {.number = last},
                                                   .later = {.number = number, .kind = read->kind},
                                                   .bytes = bytes});
    return number;
}

uint64_t judge_structure_read(struct hazard_judge *judge, const struct hazard_access *read,
                              uint64_t structure)
{
    return judge_read(judge, read, structure, NO_BUILD);
}

uint64_t judge_reference_read(struct hazard_judge *judge, const struct hazard_access *read,
                              uint64_t structure, uint32_t position)
{
    return judge_read(judge, read, structure, position);
}
