/* SPDX-License-Identifier: Apache-2.0 */
/* Retains inputs and releases them. */
#include "layer/compare/retained_inputs.h"

#include <stdlib.h>

#include "src/platform/threads.h"

struct retained_input *retained_share(struct retained_input *input)
{
    input->references++;
    return input;
}

void retained_release(struct comparer *comparer, struct retained_input *input)
{
    if (!input || --input->references > 0)
        return;
    comparer->retained_size -= input->copy->size;
    input_copy_free(input->copy);
    free(input);
}

/* ---- structures */

static void free_structure(void *record, void *context)
{
    struct retained_structure *structure = record;
    retained_release(context, structure->input);
    free(structure);
}

void retained_set_structure(struct comparer *comparer, uint64_t id, uint64_t handle,
                            struct retained_input *input)
{
    struct retained_structure *old = handle_table_remove(&comparer->structures, id);
    struct retained_structure *structure = input && id ? calloc(1, sizeof(*structure)) : NULL;
    if (structure) {
        *structure = (struct retained_structure){id, handle, retained_share(input)};
        if (!handle_table_set(&comparer->structures, id, structure))
            free_structure(structure, comparer);
    }
    if (old)
        free_structure(old, comparer); /* last, because `old` may own the input */
}

enum { CHAIN_MAX = 16 /* maximum copies of copies */ };

/* Returns the source of a copied structure, or 0 if the structure is not a copy. */
static uint64_t source_of(struct comparer *comparer, uint64_t id)
{
    pthread_mutex_lock(&comparer->copies_lock);
    const struct retained_copy *copy = handle_table_find(&comparer->copies, id);
    uint64_t source = copy ? copy->source_id : 0;
    pthread_mutex_unlock(&comparer->copies_lock);
    return source;
}

struct retained_input *retained_find_structure(struct comparer *comparer, uint64_t id)
{
    for (int i = 0; id && i < CHAIN_MAX; i++) {
        const struct retained_structure *structure = handle_table_find(&comparer->structures, id);
        if (structure)
            return structure->input;
        id = source_of(comparer, id);
    }
    return NULL;
}

/* ---- destroyed structures */

enum { FOUND_MAX = 256 };

struct found {
    struct comparer *comparer;
    struct retained_copy items[FOUND_MAX];
    uint32_t count;
};

static bool is_alive(const struct comparer *comparer, uint64_t id, uint64_t handle)
{
    return resources_find_id(comparer->device->resources, RESOURCE_ACCEL, handle) == id;
}

static void find_destroyed_structure(void *record, void *context)
{
    const struct retained_structure *structure = record;
    struct found *found = context;
    if (found->count < FOUND_MAX && !is_alive(found->comparer, structure->id, structure->handle))
        found->items[found->count++] = (struct retained_copy){.id = structure->id};
}

static void find_copy(void *record, void *context)
{
    struct found *found = context;
    if (found->count < FOUND_MAX)
        found->items[found->count++] = *(const struct retained_copy *)record;
}

/* Turns each copy into a structure with its source's input, if the copy is alive and that input is
 * known. */
static void settle_copies(struct comparer *comparer)
{
    struct found found = {.comparer = comparer};
    do {
        found.count = 0;
        pthread_mutex_lock(&comparer->copies_lock);
        handle_table_each(&comparer->copies, find_copy, &found);
        pthread_mutex_unlock(&comparer->copies_lock);
        for (uint32_t i = 0; i < found.count; i++) {
            const struct retained_copy *copy = &found.items[i];
            struct retained_input *input = retained_find_structure(comparer, copy->id);
            if (input && is_alive(comparer, copy->id, copy->handle))
                retained_set_structure(comparer, copy->id, copy->handle, input);
        }
        pthread_mutex_lock(&comparer->copies_lock);
        for (uint32_t i = 0; i < found.count; i++)
            free(handle_table_remove(&comparer->copies, found.items[i].id));
        pthread_mutex_unlock(&comparer->copies_lock);
    } while (found.count == FOUND_MAX);
}

static void release_destroyed(struct comparer *comparer)
{
    struct found found = {.comparer = comparer};
    settle_copies(comparer);
    do {
        found.count = 0;
        handle_table_each(&comparer->structures, find_destroyed_structure, &found);
        for (uint32_t i = 0; i < found.count; i++)
            retained_set_structure(comparer, found.items[i].id, 0, NULL);
    } while (found.count == FOUND_MAX);
}

static void free_copy(void *record, void *context)
{
    (void)context;
    free(record);
}

void retained_free_structures(struct comparer *comparer)
{
    handle_table_each(&comparer->structures, free_structure, comparer);
    handle_table_release(&comparer->structures);
    handle_table_each(&comparer->copies, free_copy, NULL);
    handle_table_release(&comparer->copies);
}

/* ---- inputs and builds */

struct retained_input *retained_input_create(struct comparer *comparer,
                                             const struct compare_input *input)
{
    uint64_t size = compare_input_size(input);
    if (size > RETAINED_MAX)
        return NULL;
    if (comparer->retained_size > RETAINED_MAX - size)
        release_destroyed(comparer);
    if (comparer->retained_size > RETAINED_MAX - size)
        return NULL;
    struct retained_input *retained = calloc(1, sizeof(*retained));
    if (!retained)
        return NULL;
    retained->references = 1;
    retained->copy = input_copy_create(input);
    if (!retained->copy) {
        free(retained);
        return NULL;
    }
    comparer->retained_size += retained->copy->size;
    return retained;
}

static void release_build(struct comparer *comparer, const struct retained_build *build)
{
    retained_release(comparer, build->input);
    retained_release(comparer, build->source);
    retained_free_top(comparer, build->top);
}

void retained_free_build(struct comparer *comparer, struct retained_build *build)
{
    release_build(comparer, build);
    free(build);
}

void retained_add_build(struct comparer *comparer, const struct retained_build *build)
{
    struct retained_build *own = malloc(sizeof(*own));
    if (!own) {
        comparer->failed++;
        release_build(comparer, build);
        return;
    }
    *own = *build;
    own->next = NULL;
    *comparer->last = own;
    comparer->last = &own->next;
}
