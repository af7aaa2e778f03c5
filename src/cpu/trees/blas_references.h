/* SPDX-License-Identifier: Apache-2.0 */
/* The trees that one operation reads through references of instances, held until it is done, so
 * that none goes away meanwhile, and each reference means the same throughout. */
#ifndef ASSAY_CPU_TREES_BLAS_REFERENCES_H
#define ASSAY_CPU_TREES_BLAS_REFERENCES_H

#include <pthread.h>
#include <stdbool.h>

#include "src/base/handle_table.h"
#include "src/bvh/bvh.h"
#include "src/cpu/structures.h"

struct blas_references {
    struct cpu_structures *structures;
    struct cpu_watcher watcher;
    bool is_watching;
    pthread_mutex_t lock; /* of what follows; taken before that of structures */
    struct handle_table references;
    bool out_of_memory; /* references were not found for lack of it */
};

void blas_references_init(struct blas_references *references, struct cpu_structures *structures);
void blas_references_release(struct blas_references *references);

/* From now on references mean the trees that structures have now, however late they are asked for.
 */
void blas_references_hold_all(struct blas_references *references);

/* Finds bottom-level structures that are built, when they are first asked for. */
struct builder_resolver blas_references_resolver(struct blas_references *references);

/* Finds micromaps that are built, likewise. */
struct builder_resolver blas_references_micromaps(struct blas_references *references);

/* Finds all that a TLAS refers to now; the resolver then finds those alone, without a lock. False
 * without memory. */
bool blas_references_collect(struct blas_references *references, const void *tlas);
struct builder_resolver blas_references_collected(struct blas_references *references);

#endif
