/* SPDX-License-Identifier: Apache-2.0 */
/* Reference counting of build inputs. */
#include "src/state/builds/inputs.h"

#include <stdlib.h>

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

void build_inputs_release(struct build_inputs *inputs)
{
    if (!inputs || atomic_fetch_sub_explicit(&inputs->references, 1, memory_order_acq_rel) != 1)
        return;
    for (uint32_t i = 0; i < inputs->count; i++) {
        free(inputs->items[i].inactive);
        free(inputs->items[i].indices);
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
