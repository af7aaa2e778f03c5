/* SPDX-License-Identifier: Apache-2.0 */
/* Held trees, by reference. */
#include "src/cpu/trees/pins.h"

#include <stddef.h>
#include <stdlib.h>

#include "src/bvh/structure.h"
#include "src/cpu/trees/bytes.h"

struct pin {
    struct cpu_tree *tree; /* NULL: the reference leads nowhere */
};

void cpu_pins_init(struct cpu_pins *pins, struct cpu_structures *structures)
{
    *pins = (struct cpu_pins){.structures = structures};
    pthread_mutex_init(&pins->lock, NULL);
}

static void release(void *record, void *context)
{
    struct pin *pin = record;
    (void)context;
    cpu_tree_release(pin->tree);
    free(pin);
}

static struct pin *add(struct cpu_pins *pins, uint64_t reference)
{
    struct pin *pin = calloc(1, sizeof(*pin));
    if (!pin || !handle_table_set(&pins->pins, reference, pin)) {
        free(pin);
        pins->out_of_memory = true;
        return NULL;
    }
    pin->tree = cpu_structures_tree(pins->structures, reference);
    /* No instance may have a top level; held by one that waits to be made, it might hold itself. */
    if (pin->tree && cpu_tree_is_top_level(pin->tree)) {
        cpu_tree_release(pin->tree);
        pin->tree = NULL;
    }
    return pin;
}

static struct pin *find_or_add(struct cpu_pins *pins, uint64_t reference)
{
    struct pin *pin = handle_table_find(&pins->pins, reference);
    return pin || reference == 0 ? pin : add(pins, reference);
}

static void before_change(struct cpu_watcher *watcher, uint64_t handle)
{
    struct cpu_pins *pins =
        (struct cpu_pins *)((char *)watcher - offsetof(struct cpu_pins, watcher));
    pthread_mutex_lock(&pins->lock);
    find_or_add(pins, handle);
    pthread_mutex_unlock(&pins->lock);
}

void cpu_pins_hold(struct cpu_pins *pins)
{
    pins->is_watching = true;
    pins->watcher.before_change = before_change;
    cpu_structures_watch(pins->structures, &pins->watcher);
}

void cpu_pins_release(struct cpu_pins *pins)
{
    if (pins->is_watching)
        cpu_structures_unwatch(pins->structures, &pins->watcher);
    handle_table_each(&pins->pins, release, NULL);
    handle_table_release(&pins->pins);
    pthread_mutex_destroy(&pins->lock);
}

/* What an instance may have, made now if it isn't yet; NULL where it is none. Without the lock: to
 * make it may take long. */
static const void *blas_of(const struct pin *pin)
{
    const void *bytes = pin && pin->tree ? cpu_tree_read(pin->tree) : NULL;
    return bytes && bytes_are_of_level(bytes, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR)
               ? bytes
               : NULL;
}

static const struct pin *find_pin(struct cpu_pins *pins, uint64_t reference)
{
    pthread_mutex_lock(&pins->lock);
    const struct pin *pin = find_or_add(pins, reference);
    pthread_mutex_unlock(&pins->lock);
    return pin;
}

static const void *find(void *context, uint64_t reference)
{
    return blas_of(find_pin(context, reference));
}

static const void *find_micromap(void *context, uint64_t reference)
{
    const struct pin *pin = find_pin(context, reference);
    const void *bytes = pin && pin->tree ? cpu_tree_read(pin->tree) : NULL;
    return bytes && micromap_is(bytes) ? bytes : NULL;
}

struct builder_resolver cpu_pins_micromaps(struct cpu_pins *pins)
{
    return (struct builder_resolver){find_micromap, pins};
}

struct builder_resolver cpu_pins_resolver(struct cpu_pins *pins)
{
    return (struct builder_resolver){find, pins};
}

bool cpu_pins_collect(struct cpu_pins *pins, const void *tlas)
{
    uint64_t count = builder_reference_count(tlas);
    for (uint64_t i = 0; i < count && !pins->out_of_memory; i++)
        find_or_add(pins, structure_instance(tlas, i)->instance.accelerationStructureReference);
    return !pins->out_of_memory;
}

static const void *find_collected(void *context, uint64_t reference)
{
    const struct cpu_pins *pins = context;
    const struct pin *pin = handle_table_find(&pins->pins, reference);
    return blas_of(pin);
}

struct builder_resolver cpu_pins_collected(struct cpu_pins *pins)
{
    return (struct builder_resolver){find_collected, pins};
}
