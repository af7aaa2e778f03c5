/* SPDX-License-Identifier: Apache-2.0 */
/* The bytes of a structure were last written by the structure's last build or copy. If another
 * access wrote some of them later, that has overwritten the structure. */
#include "layer/hazards/executed/overwritten.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"

/* A position that no build has. */
enum { NO_BUILD = UINT32_MAX };

/* A write of something else. */
struct overwriting {
    uint64_t number; /* of the access */
    struct hazard_bytes bytes;
    struct hazard_access_text side;
};

/* The last write of a structure. */
struct written {
    uint64_t structure; /* handle */
    uint64_t number;    /* of the access */
    struct hazard_bytes bytes;
    struct overwriting *overwriting; /* owned; NULL: nothing has overwritten the structure since */
    bool is_forgotten;               /* it only keeps its place, until that is swept */
};

/* The structures that were written in one VkDeviceMemory, in ascending order of their first bytes.
 */
struct written_places {
    struct written **items;
    uint32_t count, capacity;
    uint32_t forgotten; /* as many of them are */
    uint32_t found;     /* by the last search */
    uint64_t longest;   /* no structure has more bytes */
};

static void free_written(void *record)
{
    struct written *written = record;
    free(written->overwriting);
    free(written);
}

/* Frees those that are forgotten, too. */
static void free_places(void *record)
{
    struct written_places *places = record;
    for (uint32_t i = 0; i < places->count; i++)
        if (places->items[i]->is_forgotten)
            free_written(places->items[i]);
    free(places->items);
    free(places);
}

/* ---- places */

/* Returns the first structure that begins at `begin` or behind it. Tries the one that the last
 * search has found and the one behind it first: most commands write structures in the order in
 * which these lie. */
static uint32_t find_begin(struct written_places *places, uint64_t begin)
{
    uint32_t low = 0, high = places->count, middle = places->found;
    for (uint32_t tried = 0; low < high; tried++) {
        if (tried >= 2 || middle >= high)
            middle = low + (high - low) / 2;
        if (places->items[middle]->bytes.begin < begin)
            low = ++middle;
        else
            high = middle;
    }
    places->found = low;
    return low;
}

static struct written_places *find_places(struct hazard_search *search, uint64_t memory)
{
    return handle_table_find(&search->written_places, memory + 1);
}

/* Returns the index of the structure's place; `count` if it has none. */
static uint32_t find_place(struct written_places *places, const struct written *written)
{
    uint32_t i = find_begin(places, written->bytes.begin);
    while (i < places->count && places->items[i] != written)
        i = places->items[i]->bytes.begin == written->bytes.begin ? i + 1 : places->count;
    return i;
}

static void leave_place(struct hazard_search *search, const struct written *written)
{
    struct written_places *places = find_places(search, written->bytes.memory);
    const uint32_t i = places ? find_place(places, written) : 0;
    if (!places || i == places->count)
        return;
    places->count--;
    memmove(&places->items[i], &places->items[i + 1],
            (places->count - i) * sizeof(places->items[0]));
    if (!places->count)
        free_places(handle_table_remove(&search->written_places, written->bytes.memory + 1));
}

/* Without memory the structure is not found by its bytes, and nothing is reported about it. */
static void take_place(struct hazard_search *search, struct written *written)
{
    struct written_places *places = find_places(search, written->bytes.memory);
    if (!places) {
        places = calloc(1, sizeof(*places));
        if (places &&
            !handle_table_set(&search->written_places, written->bytes.memory + 1, places)) {
            free(places);
            places = NULL;
        }
    }
    if (!places || !ARRAY_HAS_ROOM(places->items, places->count, places->capacity))
        return;
    const uint32_t i = find_begin(places, written->bytes.begin);
    memmove(&places->items[i + 1], &places->items[i],
            (places->count - i) * sizeof(places->items[0]));
    places->items[i] = written;
    places->count++;
    if (places->longest < written->bytes.end - written->bytes.begin)
        places->longest = written->bytes.end - written->bytes.begin;
}

/* ---- what was written */

/* Removes all that are forgotten, once they are half of the places: each removal alone would move
 * all that lie behind. */
static void sweep(struct hazard_search *search, struct written_places *places, uint64_t memory)
{
    uint32_t kept = 0;
    if (places->forgotten * 2 < places->count)
        return;
    for (uint32_t i = 0; i < places->count; i++)
        if (places->items[i]->is_forgotten)
            free_written(places->items[i]);
        else
            places->items[kept++] = places->items[i];
    places->count = kept;
    places->forgotten = 0;
    if (!kept)
        free_places(handle_table_remove(&search->written_places, memory + 1));
}

static void forget_written(struct hazard_search *search, uint64_t structure)
{
    struct written *written = handle_table_remove(&search->written, structure);
    struct written_places *places = written ? find_places(search, written->bytes.memory) : NULL;
    if (!written)
        return;
    if (!places || find_place(places, written) == places->count) {
        free_written(written);
        return;
    }
    written->is_forgotten = true;
    places->forgotten++;
    sweep(search, places, written->bytes.memory);
}

/* Returns the record of a structure, and adds one if there is none; NULL if memory runs out. */
static struct written *find_written(struct hazard_search *search, uint64_t structure)
{
    struct written *written = handle_table_find(&search->written, structure);
    if (written)
        return written;
    written = calloc(1, sizeof(*written));
    if (written && handle_table_set(&search->written, structure, written)) {
        written->structure = structure;
        return written;
    }
    free(written);
    return NULL;
}

void hazard_search_note_write(struct hazard_search *search, uint64_t structure, uint64_t number,
                              const struct hazard_bytes *bytes)
{
    struct written *written = number ? find_written(search, structure) : NULL;
    if (!written) {
        forget_written(search, structure);
        return;
    }
    const bool is_moved = memcmp(&written->bytes, bytes, sizeof(*bytes)) != 0;
    if (is_moved && written->bytes.memory)
        leave_place(search, written);
    free(written->overwriting);
    written->overwriting = NULL;
    written->number = number;
    written->bytes = *bytes;
    if (is_moved)
        take_place(search, written);
}

void hazard_search_forget_all_written(struct hazard_search *search)
{
    handle_table_drop(&search->written_places, free_places); /* first: it looks at those below */
    handle_table_drop(&search->written, free_written);
}

struct hazard_bytes hazard_search_written_bytes(const struct hazard_search *search,
                                                uint64_t structure,
                                                const struct hazard_bytes *first)
{
    const struct written *written = handle_table_find(&search->written, structure);
    const bool is_there =
        written && written->bytes.memory == first->memory && written->bytes.begin == first->begin;
    return is_there ? written->bytes : *first;
}

/* ---- writes of something else */

/* Keeps how the first such write is described: its batch is forgotten when it is complete. Labels
 * belong to the command buffer, and are left out. */
static void note_overwriting(struct hazard_search *search, struct written *written, uint64_t number,
                             const struct hazard_bytes *bytes)
{
    struct overwriting *overwriting =
        written->overwriting ? NULL : malloc(sizeof(*written->overwriting));
    if (!overwriting)
        return;
    *overwriting = (struct overwriting){.number = number, .bytes = *bytes};
    if (hazard_search_find_side(search, number, &overwriting->side)) {
        overwriting->side.origin.labels = NULL;
        overwriting->side.origin.submission.labels = NULL;
        written->overwriting = overwriting;
    } else {
        free(overwriting);
    }
}

/* A structure that begins where another one does has its address, too: which of them is meant by it
 * is unknown. */
void hazard_search_note_overwritten(struct hazard_search *search, const struct hazard_access *write,
                                    uint64_t number, uint64_t own)
{
    struct written_places *places = find_places(search, write->bytes.memory);
    if (!places)
        return;
    const uint64_t begin = write->bytes.begin, end = write->bytes.end;
    uint32_t i = find_begin(places, begin < places->longest ? 0 : begin - places->longest);
    for (; i < places->count && places->items[i]->bytes.begin < end; i++) {
        struct written *written = places->items[i];
        struct hazard_access both = *write;
        if (written->is_forgotten || written->structure == own || written->bytes.end <= begin ||
            (own && written->bytes.begin == begin))
            continue;
        both.bytes.begin = begin > written->bytes.begin ? begin : written->bytes.begin;
        both.bytes.end = end < written->bytes.end ? end : written->bytes.end;
        note_overwriting(search, written, number, &both.bytes);
        trace_search_overwrite(&search->shaders, &both, written->structure, number);
    }
}

/* ---- reads */

/* Returns the number of a write that came after the structure's own last one, and of which bytes;
 * 0: none is known. If its batch may be forgotten, describes it (`is_kept`). */
static uint64_t find_overwriting(const struct hazard_search *search, uint64_t structure,
                                 struct hazard_bytes *bytes, struct hazard_access_text *side,
                                 bool *is_kept)
{
    const struct written *own = handle_table_find(&search->written, structure);
    if (!own)
        return 0;
    *bytes = own->bytes;
    const uint64_t last = hazards_write_since(search->hazards, own->number, bytes);
    *is_kept = !last && own->overwriting;
    if (!*is_kept)
        return last;
    *bytes = own->overwriting->bytes;
    *side = own->overwriting->side;
    return own->overwriting->number;
}

/* Whether a write by the current command is of the build at that position. */
static bool is_of_build(const struct hazard_search *search, uint64_t number, uint32_t position)
{
    struct hazard_access_text write;
    return hazard_search_find_side(search, number, &write) && write.is_build &&
           write.origin.build_index + write.info == position;
}

/* A read that is too early is reported as such. */
static uint64_t read_checked(struct hazard_search *search, const struct hazard_access *read,
                             uint64_t structure, uint32_t position)
{
    struct hazard early;
    struct hazard_bytes bytes;
    struct hazard_access_text earlier;
    bool is_kept = false; /* `earlier` */
    const uint64_t last = find_overwriting(search, structure, &bytes, &earlier, &is_kept);
    const bool is_late = last &&
                         (last < search->command.first || is_of_build(search, last, position)) &&
                         !hazards_read_is_early(search->hazards, read, &early);
    const uint64_t number = hazards_access(search->hazards, read);
    if (is_late)
        hazard_search_found_after(search,
                                  &(struct hazard){.type = READ_OF_OVERWRITTEN,
                                                   .earlier = {.number = last},
                                                   .later = {.number = number, .kind = read->kind},
                                                   .bytes = bytes},
                                  is_kept ? &earlier : NULL);
    return number;
}

uint64_t hazard_search_read_structure(struct hazard_search *search,
                                      const struct hazard_access *read, uint64_t structure)
{
    return read_checked(search, read, structure, NO_BUILD);
}

uint64_t hazard_search_read_reference(struct hazard_search *search,
                                      const struct hazard_access *read, uint64_t structure,
                                      uint32_t position)
{
    return read_checked(search, read, structure, position);
}
