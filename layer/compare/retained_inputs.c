/* SPDX-License-Identifier: Apache-2.0 */
/* Retains inputs and releases them. */
#include "layer/compare/retained_inputs.h"

#include <stdlib.h>

struct retained_input *retained_share(struct retained_input *input)
{
    atomic_fetch_add_explicit(&input->references, 1, memory_order_relaxed);
    return input;
}

void retained_release(struct retained_input *input)
{
    if (!input || atomic_fetch_sub_explicit(&input->references, 1, memory_order_acq_rel) > 1)
        return;
    atomic_fetch_sub(&input->comparer->retained_size, input->copy->size);
    input_copy_free(input->copy);
    free(input);
}

struct retained_input *retained_input_create(struct comparer *comparer,
                                             const struct compare_input *input)
{
    uint64_t size = compare_input_size(input);
    if (size > RETAINED_MAX)
        return NULL;
    if (comparer->retained_size > RETAINED_MAX - size)
        structures_release_other_inputs(comparer->device->structures);
    if (comparer->retained_size > RETAINED_MAX - size)
        return NULL;
    struct retained_input *retained = calloc(1, sizeof(*retained));
    if (!retained)
        return NULL;
    atomic_init(&retained->references, 1);
    retained->comparer = comparer;
    retained->copy = input_copy_create(input);
    if (!retained->copy) {
        free(retained);
        return NULL;
    }
    atomic_fetch_add(&comparer->retained_size, retained->copy->size);
    return retained;
}

static void release_build(const struct retained_build *build)
{
    retained_release(build->input);
    retained_release(build->source);
    retained_free_top(build->top);
}

void retained_free_build(struct retained_build *build)
{
    release_build(build);
    free(build);
}

void retained_add_build(struct comparer *comparer, const struct retained_build *build)
{
    struct retained_build *own = malloc(sizeof(*own));
    if (!own) {
        comparer->failed++;
        release_build(build);
        return;
    }
    *own = *build;
    own->next = NULL;
    *comparer->last = own;
    comparer->last = &own->next;
}
