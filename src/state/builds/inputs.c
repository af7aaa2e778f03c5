/* SPDX-License-Identifier: Apache-2.0 */
/* Reference counting of build inputs. */
#include "src/state/builds/inputs.h"

#include <stdlib.h>
#include <string.h>

struct build_inputs *build_inputs_create(uint32_t count)
{
    struct build_inputs *inputs =
        calloc(1, sizeof(*inputs) + (size_t)count * sizeof(inputs->items[0]));
    if (!inputs)
        return NULL;
    atomic_init(&inputs->references, 1);
    atomic_init(&inputs->is_known, false);
    inputs->count = count;
    return inputs;
}

struct build_inputs *build_inputs_share(struct build_inputs *inputs)
{
    if (inputs)
        atomic_fetch_add_explicit(&inputs->references, 1, memory_order_relaxed);
    return inputs;
}

struct kept_indices *kept_indices_create(const void *bytes, uint64_t size, uint32_t max)
{
    struct kept_indices *indices = malloc(sizeof(*indices) + size);
    if (!indices)
        return NULL;
    atomic_init(&indices->references, 1);
    indices->max = max;
    indices->size = size;
    memcpy(indices->bytes, bytes, size);
    return indices;
}

struct kept_indices *kept_indices_share(struct kept_indices *indices)
{
    atomic_fetch_add_explicit(&indices->references, 1, memory_order_relaxed);
    return indices;
}

static void release_indices(struct kept_indices *indices)
{
    if (indices && atomic_fetch_sub_explicit(&indices->references, 1, memory_order_acq_rel) == 1)
        free(indices);
}

void build_inputs_release(struct build_inputs *inputs)
{
    if (!inputs || atomic_fetch_sub_explicit(&inputs->references, 1, memory_order_acq_rel) != 1)
        return;
    for (uint32_t i = 0; i < inputs->count; i++) {
        free(inputs->items[i].inactive);
        release_indices(inputs->items[i].indices);
    }
    free(inputs);
}

void build_inputs_mark_known(struct build_inputs *inputs)
{
    if (inputs)
        atomic_store_explicit(&inputs->is_known, true, memory_order_release);
}

const struct geometry_inputs *build_inputs_of(const struct build_inputs *inputs, uint32_t geometry)
{
    return inputs && geometry < inputs->count &&
                   atomic_load_explicit(&inputs->is_known, memory_order_acquire)
               ? &inputs->items[geometry]
               : NULL;
}
