/* SPDX-License-Identifier: Apache-2.0 */
/* The trees that one operation reads through the references of instances. They are held until the
 * operation is done, so each reference resolves to the same tree during the whole operation. */
#ifndef ASSAY_CPU_TREES_BLAS_REFERENCES_H
#define ASSAY_CPU_TREES_BLAS_REFERENCES_H

#include <stdbool.h>

#include "src/base/handle_table.h"
#include "src/bvh/bvh.h"
#include "src/cpu/structures.h"
#include "src/platform/threads.h"

struct blas_references {
    struct cpu_structures *structures;
    struct cpu_watcher watcher;
    bool is_watching;
    pthread_mutex_t lock; /* guards the members below; taken before the lock of structures */
    struct handle_table references;
    bool out_of_memory; /* memory ran out for a reference, so it was not found */
};

void blas_references_init(struct blas_references *references, struct cpu_structures *structures);
void blas_references_release(struct blas_references *references);

/* From now on each reference resolves to the tree that its structure has at the time of this call,
 * even if it is first resolved later. */
void blas_references_hold_all(struct blas_references *references);

/* The resolver finds built bottom-level structures on first use. */
struct builder_resolver blas_references_resolver(struct blas_references *references);

/* The resolver finds built micromaps on first use. */
struct builder_resolver blas_references_micromaps(struct blas_references *references);

/* Resolves all references of a TLAS now. The resolver then finds only these, and takes no lock.
 * Returns false if memory runs out. */
bool blas_references_collect(struct blas_references *references, const void *tlas);
struct builder_resolver blas_references_collected(struct blas_references *references);

#endif
