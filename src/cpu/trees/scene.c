/* SPDX-License-Identifier: Apache-2.0 */
/* A table of held trees, by reference; and scenes for tracing. */
#include "src/cpu/trees/trees.h"

#include <stddef.h>
#include <stdlib.h>

#include "src/bvh/structure.h"
#include "src/cpu/trees/tree.h"

struct entry {
    struct cpu_tree *tree; /* NULL: the reference is invalid */
};

void blas_references_init(struct blas_references *references, struct cpu_structures *structures)
{
    *references = (struct blas_references){.structures = structures};
    pthread_mutex_init(&references->lock, NULL);
}

static void release_blas_entry(void *record)
{
    struct entry *entry = record;
    cpu_tree_release(entry->tree);
    free(entry);
}

static struct entry *add_blas_reference(struct blas_references *references, uint64_t reference)
{
    struct entry *entry = calloc(1, sizeof(*entry));
    if (!entry || !handle_table_set(&references->references, reference, entry)) {
        free(entry);
        references->out_of_memory = true;
        return NULL;
    }
    entry->tree = cpu_structures_tree(references->structures, reference);
    /* An instance must not refer to a TLAS. A lazy TLAS that held a TLAS might hold itself. */
    if (entry->tree && cpu_tree_is_top_level(entry->tree)) {
        cpu_tree_release(entry->tree);
        entry->tree = NULL;
    }
    return entry;
}

/* A lazy TLAS adds the trees that are about to change, and so holds none that is newer than itself:
 * such a tree might be an update of it, and hold it in turn. Where an older one could not be added,
 * no newer one takes its place. */
static struct entry *find_or_add_blas(struct blas_references *references, uint64_t reference)
{
    struct entry *entry = handle_table_find(&references->references, reference);
    return entry || reference == 0 || references->out_of_memory
               ? entry
               : add_blas_reference(references, reference);
}

static void before_change(struct cpu_watcher *watcher, uint64_t handle)
{
    struct blas_references *references =
        (struct blas_references *)((char *)watcher - offsetof(struct blas_references, watcher));
    pthread_mutex_lock(&references->lock);
    find_or_add_blas(references, handle);
    pthread_mutex_unlock(&references->lock);
}

void blas_references_hold_all(struct blas_references *references)
{
    references->is_watching = true;
    references->watcher.before_change = before_change;
    cpu_structures_watch(references->structures, &references->watcher);
}

void blas_references_release(struct blas_references *references)
{
    if (references->is_watching)
        cpu_structures_unwatch(references->structures, &references->watcher);
    handle_table_drop(&references->references, release_blas_entry);
    pthread_mutex_destroy(&references->lock);
}

/* Returns the bytes of a BLAS; makes a lazy tree first. Returns NULL if the tree is not a BLAS.
 * Call without the lock, because making a tree may take long. */
static const void *blas_of(const struct entry *entry)
{
    const void *bytes = entry && entry->tree ? cpu_tree_read(entry->tree) : NULL;
    return bytes && bytes_are_of_level(bytes, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR)
               ? bytes
               : NULL;
}

static const struct entry *find_entry(struct blas_references *references, uint64_t reference)
{
    pthread_mutex_lock(&references->lock);
    const struct entry *entry = find_or_add_blas(references, reference);
    pthread_mutex_unlock(&references->lock);
    return entry;
}

static const void *find_blas(void *context, uint64_t reference)
{
    return blas_of(find_entry(context, reference));
}

static const void *find_micromap(void *context, uint64_t reference)
{
    const struct entry *entry = find_entry(context, reference);
    const void *bytes = entry && entry->tree ? cpu_tree_read(entry->tree) : NULL;
    return bytes && micromap_is(bytes) ? bytes : NULL;
}

struct builder_resolver blas_references_micromaps(struct blas_references *references)
{
    return (struct builder_resolver){find_micromap, references};
}

struct builder_resolver blas_references_resolver(struct blas_references *references)
{
    return (struct builder_resolver){find_blas, references};
}

/* Resolves all references of a TLAS now. The resolver then finds only these, and takes no lock.
 * Returns false if memory runs out. */
static bool blas_references_collect(struct blas_references *references, const void *tlas)
{
    uint64_t count = builder_reference_count(tlas);
    for (uint64_t i = 0; i < count && !references->out_of_memory; i++)
        find_or_add_blas(references,
                         structure_instance(tlas, i)->instance.accelerationStructureReference);
    return !references->out_of_memory;
}

static const void *find_collected(void *context, uint64_t reference)
{
    const struct blas_references *references = context;
    const struct entry *entry = handle_table_find(&references->references, reference);
    return blas_of(entry);
}

static struct builder_resolver blas_references_collected(struct blas_references *references)
{
    return (struct builder_resolver){find_collected, references};
}

/* ---- opens and closes scenes for tracing */

/* Micromaps are resolved when a ray first meets one, but to the trees that they have now. */
static void open_micromaps(struct cpu_scene *scene)
{
    blas_references_init(&scene->micromaps, scene->device->structures);
    blas_references_hold_all(&scene->micromaps);
    scene->traced.micromaps = blas_references_micromaps(&scene->micromaps);
}

VkResult cpu_scene_open(struct cpu_device *device, uint64_t handle, enum trace_accuracy accuracy,
                        struct cpu_scene *scene)
{
    *scene = (struct cpu_scene){.device = device};
    scene->tree = cpu_structures_tree(device->structures, handle);
    const void *bytes = scene->tree ? cpu_tree_read(scene->tree) : NULL;
    if (!bytes || micromap_is(bytes)) {
        cpu_tree_release(scene->tree);
        return VK_ERROR_VALIDATION_FAILED;
    }
    blas_references_init(&scene->references, device->structures);
    scene->traced = (struct trace_scene){
        .structure = bytes,
        .accuracy = accuracy,
        .resolver = blas_references_collected(&scene->references),
        .counters = &scene->counters,
    };
    if (device->has_micromaps)
        open_micromaps(scene);
    if (blas_references_collect(&scene->references, bytes))
        return VK_SUCCESS;
    cpu_scene_close(scene);
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

void cpu_scene_close(struct cpu_scene *scene)
{
    struct cpu_counters *counters = &scene->device->counters;
    cpu_count(&counters->rays, scene->rays);
    cpu_count(&counters->nodes_visited, scene->counters.nodes);
    cpu_count(&counters->instances_entered, scene->counters.instances);
    cpu_count(&counters->primitives_tested, scene->counters.primitives);
    cpu_count(&counters->exact_calls, scene->counters.exact_calls);
    cpu_count(&counters->micromaps_read, scene->counters.micromaps);
    if (scene->device->has_micromaps)
        blas_references_release(&scene->micromaps);
    blas_references_release(&scene->references);
    cpu_tree_release(scene->tree);
}
