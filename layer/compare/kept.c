/* SPDX-License-Identifier: Apache-2.0 */
/* Keeping inputs, and giving them up. */
#include "layer/compare/kept.h"

#include <pthread.h>
#include <stdlib.h>

struct kept_input *kept_share(struct kept_input *input)
{
    input->references++;
    return input;
}

void kept_release(struct comparer *comparer, struct kept_input *input)
{
    if (!input || --input->references > 0)
        return;
    comparer->kept_size -= input->copy->size;
    input_copy_free(input->copy);
    free(input);
}

/* ---- structures */

void kept_set_structure(struct comparer *comparer, uint64_t id, uint64_t handle,
                        struct kept_input *input)
{
    struct kept_structure *structure = handle_table_remove(&comparer->structures, id);
    if (structure) {
        kept_release(comparer, structure->input);
        free(structure);
    }
    structure = input && id ? calloc(1, sizeof(*structure)) : NULL;
    if (!structure)
        return;
    *structure = (struct kept_structure){id, handle, input};
    if (handle_table_set(&comparer->structures, id, structure))
        kept_share(input);
    else
        free(structure);
}

enum { CHAIN_MAX = 16 /* copies of copies */ };

/* 0: it isn't one. */
static uint64_t source_of(struct comparer *comparer, uint64_t id)
{
    pthread_mutex_lock(&comparer->copies_lock);
    const struct kept_copy *copy = handle_table_find(&comparer->copies, id);
    uint64_t source = copy ? copy->source_id : 0;
    pthread_mutex_unlock(&comparer->copies_lock);
    return source;
}

struct kept_input *kept_find_structure(struct comparer *comparer, uint64_t id)
{
    for (int i = 0; id && i < CHAIN_MAX; i++) {
        const struct kept_structure *structure = handle_table_find(&comparer->structures, id);
        if (structure)
            return structure->input;
        id = source_of(comparer, id);
    }
    return NULL;
}

/* ---- what is gone */

enum { FOUND_MAX = 256 };

struct found {
    struct comparer *comparer;
    struct kept_copy items[FOUND_MAX];
    uint32_t count;
};

static bool is_alive(const struct comparer *comparer, uint64_t id, uint64_t handle)
{
    return resources_find_id(comparer->device->resources, RESOURCE_ACCEL, handle) == id;
}

static void find_dead_structure(void *record, void *context)
{
    const struct kept_structure *structure = record;
    struct found *found = context;
    if (found->count < FOUND_MAX && !is_alive(found->comparer, structure->id, structure->handle))
        found->items[found->count++] = (struct kept_copy){.id = structure->id};
}

static void find_copy(void *record, void *context)
{
    struct found *found = context;
    if (found->count < FOUND_MAX)
        found->items[found->count++] = *(const struct kept_copy *)record;
}

/* Each becomes a structure of its own, if it lives and what it was copied from is known. */
static void settle_copies(struct comparer *comparer)
{
    struct found found = {.comparer = comparer};
    do {
        found.count = 0;
        pthread_mutex_lock(&comparer->copies_lock);
        handle_table_each(&comparer->copies, find_copy, &found);
        pthread_mutex_unlock(&comparer->copies_lock);
        for (uint32_t i = 0; i < found.count; i++) {
            const struct kept_copy *copy = &found.items[i];
            struct kept_input *input = kept_find_structure(comparer, copy->id);
            if (input && is_alive(comparer, copy->id, copy->handle)) {
                kept_share(input); /* it may be this structure's own already */
                kept_set_structure(comparer, copy->id, copy->handle, input);
                kept_release(comparer, input);
            }
        }
        pthread_mutex_lock(&comparer->copies_lock);
        for (uint32_t i = 0; i < found.count; i++)
            free(handle_table_remove(&comparer->copies, found.items[i].id));
        pthread_mutex_unlock(&comparer->copies_lock);
    } while (found.count == FOUND_MAX);
}

static void give_up_dead(struct comparer *comparer)
{
    struct found found = {.comparer = comparer};
    settle_copies(comparer);
    do {
        found.count = 0;
        handle_table_each(&comparer->structures, find_dead_structure, &found);
        for (uint32_t i = 0; i < found.count; i++)
            kept_set_structure(comparer, found.items[i].id, 0, NULL);
    } while (found.count == FOUND_MAX);
}

static void free_structure(void *record, void *context)
{
    struct kept_structure *structure = record;
    kept_release(context, structure->input);
    free(structure);
}

static void free_copy(void *record, void *context)
{
    (void)context;
    free(record);
}

void kept_free_structures(struct comparer *comparer)
{
    handle_table_each(&comparer->structures, free_structure, comparer);
    handle_table_release(&comparer->structures);
    handle_table_each(&comparer->copies, free_copy, NULL);
    handle_table_release(&comparer->copies);
}

/* ---- inputs and builds */

struct kept_input *kept_input_create(struct comparer *comparer, const struct compare_input *input)
{
    uint64_t size = compare_input_size(input);
    if (size > KEPT_MAX)
        return NULL;
    if (comparer->kept_size > KEPT_MAX - size)
        give_up_dead(comparer);
    if (comparer->kept_size > KEPT_MAX - size)
        return NULL;
    struct kept_input *kept = calloc(1, sizeof(*kept));
    if (!kept)
        return NULL;
    kept->references = 1;
    kept->copy = input_copy_create(input);
    if (!kept->copy) {
        free(kept);
        return NULL;
    }
    comparer->kept_size += kept->copy->size;
    return kept;
}

static void release_build(struct comparer *comparer, const struct kept_build *build)
{
    kept_release(comparer, build->input);
    kept_release(comparer, build->source);
    kept_free_top(comparer, build->top);
}

void kept_free_build(struct comparer *comparer, struct kept_build *build)
{
    release_build(comparer, build);
    free(build);
}

void kept_add_build(struct comparer *comparer, const struct kept_build *build)
{
    struct kept_build *own = malloc(sizeof(*own));
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
