/* SPDX-License-Identifier: Apache-2.0 */
/* Keeping inputs, and giving them up. */
#include "compare/kept.h"

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

void kept_set_structure(struct comparer *comparer, uint64_t handle, struct kept_input *input)
{
    struct kept_structure *structure = handle_table_remove(&comparer->structures, handle);
    if (structure) {
        kept_release(comparer, structure->input);
        free(structure);
    }
    structure = input && handle ? calloc(1, sizeof(*structure)) : NULL;
    if (!structure)
        return;
    *structure = (struct kept_structure){handle, input};
    if (handle_table_set(&comparer->structures, handle, structure))
        kept_share(input);
    else
        free(structure);
}

struct kept_input *kept_find_structure(const struct comparer *comparer, uint64_t handle)
{
    const struct kept_structure *structure = handle_table_find(&comparer->structures, handle);
    return structure ? structure->input : NULL;
}

enum { DEAD_MAX = 256 };

struct dead {
    struct resources *resources;
    uint64_t handles[DEAD_MAX];
    uint32_t count;
};

static void note_dead(void *record, void *context)
{
    const struct kept_structure *structure = record;
    struct dead *dead = context;
    if (dead->count < DEAD_MAX &&
        !resources_find_id(dead->resources, RESOURCE_ACCEL, structure->handle))
        dead->handles[dead->count++] = structure->handle;
}

static void give_up_dead(struct comparer *comparer)
{
    struct dead dead = {.resources = comparer->device->resources};
    do {
        dead.count = 0;
        handle_table_each(&comparer->structures, note_dead, &dead);
        for (uint32_t i = 0; i < dead.count; i++)
            kept_set_structure(comparer, dead.handles[i], NULL);
    } while (dead.count == DEAD_MAX);
}

static void free_structure(void *record, void *context)
{
    struct kept_structure *structure = record;
    kept_release(context, structure->input);
    free(structure);
}

void kept_free_structures(struct comparer *comparer)
{
    handle_table_each(&comparer->structures, free_structure, comparer);
    handle_table_release(&comparer->structures);
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
