/* SPDX-License-Identifier: Apache-2.0 */
/* The trees that one operation reads through references of instances, held until it is done, so
 * that none goes away meanwhile, and each reference means the same throughout. */
#ifndef ASSAY_CPU_TREES_PINS_H
#define ASSAY_CPU_TREES_PINS_H

#include <pthread.h>
#include <stdbool.h>

#include "src/base/handle_table.h"
#include "src/bvh/bvh.h"
#include "src/cpu/structures.h"

struct cpu_pins {
    struct cpu_structures *structures;
    struct cpu_watcher watcher;
    bool is_watching;
    pthread_mutex_t lock; /* of what follows; taken before that of structures */
    struct handle_table pins;
    bool out_of_memory; /* references were not found for lack of it */
};

void cpu_pins_init(struct cpu_pins *pins, struct cpu_structures *structures);
void cpu_pins_release(struct cpu_pins *pins);

/* From now on references mean the trees that structures have now, however late they are asked for.
 */
void cpu_pins_hold(struct cpu_pins *pins);

/* Finds bottom-level structures that are built, when they are first asked for. */
struct builder_resolver cpu_pins_resolver(struct cpu_pins *pins);

/* Finds micromaps that are built, likewise. */
struct builder_resolver cpu_pins_micromaps(struct cpu_pins *pins);

/* Finds all that a TLAS refers to now; the resolver then finds those alone, without a lock. False
 * without memory. */
bool cpu_pins_collect(struct cpu_pins *pins, const void *tlas);
struct builder_resolver cpu_pins_collected(struct cpu_pins *pins);

#endif
