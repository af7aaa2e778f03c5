/* SPDX-License-Identifier: Apache-2.0 */
/* The work of lazy trees, and the objects that it holds until a tree is made. */
#include "src/cpu/trees/trees.h"

#include <stdlib.h>
#include <string.h>

#include "src/bvh/micromap.h"
#include "src/platform/threads.h"

/* A displacement micromap, as it was when the build executed. */
struct held_micromap {
    uint64_t reference;
    struct cpu_tree *tree; /* NULL: the reference is invalid */
};

struct held_micromaps {
    uint32_t count;
    struct held_micromap micromaps[];
};

struct lazy {
    struct cpu_device *device;
    uint64_t size_max;
    struct execution *execution;        /* its snapshots are the input, if there is any */
    const struct recorded_build *build; /* belongs to the execution's recording */
    struct snapshot serialized;
    struct cpu_tree *source;           /* of an update or a compaction */
    struct blas_references references; /* the instances' trees when the build executed */
    bool has_references;
    struct held_micromaps *micromaps; /* NULL: no displacement micromaps */
};

static void release_micromaps(struct held_micromaps *held)
{
    for (uint32_t i = 0; held && i < held->count; i++)
        cpu_tree_release(held->micromaps[i].tree);
    free(held);
}

/* Holds the micromaps that the build refers to. Does not hold all structures that change later, as
 * blas_references_hold_all does, because one of them may be the structure that is built. Returns
 * false if memory runs out. */
static bool reference_micromaps(struct cpu_device *device, const struct build_parameters *build,
                                struct held_micromaps **held)
{
    uint32_t count = 0;
    for (uint32_t i = 0; build->chained && i < build->info.geometryCount; i++)
        count += build->chained[i].has_displacement;
    *held = NULL;
    if (count == 0)
        return true;
    *held = calloc(1, sizeof(**held) + count * sizeof((*held)->micromaps[0]));
    for (uint32_t i = 0; *held && i < build->info.geometryCount; i++) {
        uint64_t reference = (uint64_t)build->chained[i].displacement.micromap;
        if (build->chained[i].has_displacement && reference)
            (*held)->micromaps[(*held)->count++] = (struct held_micromap){
                reference, cpu_structures_tree(device->structures, reference)};
    }
    return *held;
}

static const void *find_held(void *context, uint64_t reference)
{
    const struct held_micromaps *held = context;
    for (uint32_t i = 0; held && i < held->count; i++) {
        const struct held_micromap *micromap = &held->micromaps[i];
        const void *bytes = micromap->reference == reference && micromap->tree
                                ? cpu_tree_read(micromap->tree)
                                : NULL;
        if (bytes)
            return micromap_is(bytes) ? bytes : NULL;
    }
    return NULL;
}

static void release_lazy(void *context)
{
    struct lazy *lazy = context;
    release_micromaps(lazy->micromaps);
    if (lazy->has_references)
        blas_references_release(&lazy->references);
    cpu_tree_release(lazy->source);
    execution_release(lazy->execution);
    free(lazy);
}

static VkResult make_build(void *context, struct cpu_tree *tree);
static VkResult make_compaction(void *context, struct cpu_tree *tree);

/* Returns one reference to a tree that `make` makes. Takes over the references of `lazy`. */
static struct cpu_tree *create_lazy(VkResult (*make)(void *context, struct cpu_tree *tree),
                                    const struct lazy *lazy)
{
    struct lazy *own = malloc(sizeof(*own));
    struct cpu_tree_work work = {
        .make = make,
        .release = release_lazy,
        .context = own,
        .start = make == make_build ? lazy->source : NULL,
        .is_top_level = lazy->has_references ||
                        (make == make_compaction && cpu_tree_is_top_level(lazy->source)),
    };
    struct cpu_tree *tree = own ? cpu_tree_create_lazy(&work) : NULL;
    if (tree) {
        *own = *lazy;
        if (own->execution)
            execution_share(own->execution);
        if (own->has_references) {
            blas_references_init(&own->references, own->device->structures);
            blas_references_hold_all(&own->references);
        }
        return tree;
    }
    free(own);
    release_micromaps(lazy->micromaps);
    cpu_tree_release(lazy->source);
    return NULL;
}

/* Who uses a structure knows that its build is complete, so its ticket ends soon. If it does not,
 * the batch may wait for the application's next call. */
#define WAIT_NANOSECONDS ((uint64_t)10 * 1000 * 1000 * 1000)

/* Waits for the end of the execution, and takes its lock for reading unless that fails. */
static VkResult begin_reading(const struct lazy *lazy)
{
    struct execution *execution = lazy->execution;
    VkResult result = execution->ticket->wait(execution->ticket, WAIT_NANOSECONDS);
    if (result == VK_TIMEOUT)
        cpu_occurs(&lazy->device->used_early);
    if (result != VK_SUCCESS)
        return result;
    if (atomic_load(&execution->is_overwritten))
        cpu_occurs(&lazy->device->overwritten);
    shared_lock_read(&execution->lock);
    return VK_SUCCESS;
}

/* Fails if the driver has not executed the copies, because the inputs are unknown then. The caller
 * closes the memory, also after a failure. */
static VkResult open_memory(const struct lazy *lazy, struct snapshot_memory *snapshots)
{
    if (lazy->execution->has_no_snapshots || !snapshot_memory_open(snapshots))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    if (snapshots->lacks_copies)
        atomic_store(&lazy->device->lacks_copies, true);
    return snapshots->lacks_copies ? VK_ERROR_UNKNOWN : VK_SUCCESS;
}

/* `result`: of the builder. If no finding says why it refuses the input, a warning will. */
static VkResult note_refusal(const struct lazy *lazy, VkResult result)
{
    if (result == VK_ERROR_VALIDATION_FAILED &&
        !atomic_load(&lazy->execution->recording->has_findings))
        atomic_fetch_add(&lazy->device->refused, 1);
    return result;
}

/* ---- builds */

static VkResult make_by_build(const struct lazy *lazy, const struct cpu_making *making,
                              struct cpu_tree *tree)
{
    VkResult result = cpu_make_by_build(making, tree);
    bool is_complete = !lazy->has_references || !lazy->references.out_of_memory;
    return result == VK_SUCCESS && !is_complete ? VK_ERROR_OUT_OF_HOST_MEMORY
                                                : note_refusal(lazy, result);
}

static VkResult make_from_memory(struct lazy *lazy, const struct input_memory *memory,
                                 struct cpu_tree *tree)
{
    struct build_parameters parameters = lazy->build->parameters;
    const struct cpu_making making = {
        .device = lazy->device,
        .build = &parameters,
        .memory = *memory,
        .resolver = lazy->has_references ? blas_references_resolver(&lazy->references)
                                         : (struct builder_resolver){0},
        .micromaps = {find_held, lazy->micromaps},
        .source = lazy->source ? cpu_tree_read(lazy->source) : NULL,
        .size_max = lazy->size_max,
    };
    if (lazy->source && !making.source)
        return VK_ERROR_VALIDATION_FAILED;
    if (!lazy->build->is_indirect)
        return make_by_build(lazy, &making, tree);

    parameters.ranges = calloc(parameters.info.geometryCount + 1u, sizeof(*parameters.ranges));
    if (!parameters.ranges)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    recorded_build_read_ranges(lazy->build, memory, parameters.ranges);
    VkResult result = make_by_build(lazy, &making, tree);
    free(parameters.ranges);
    return result;
}

static VkResult make_build(void *context, struct cpu_tree *tree)
{
    struct lazy *lazy = context;
    struct execution *execution = lazy->execution;
    VkResult result = begin_reading(lazy);
    if (result != VK_SUCCESS)
        return result;
    struct snapshot_memory snapshots = {
        .snapshots = lazy->build->snapshots,
        .count = lazy->build->snapshot_count,
        .bases = execution->bases,
        .gathering = &lazy->build->gathering,
    };
    result = open_memory(lazy, &snapshots);
    if (result == VK_SUCCESS) {
        struct input_memory memory = snapshot_memory_of(&snapshots);
        result = make_from_memory(lazy, &memory, tree);
    }
    snapshot_memory_close(&snapshots);
    shared_lock_release(&execution->lock);
    return result;
}

struct cpu_tree *cpu_lazy_build(struct cpu_device *device, struct execution *execution,
                                const struct recorded_build *build, struct cpu_tree *source,
                                uint64_t size_max)
{
    struct lazy lazy = {
        .device = device,
        .execution = execution,
        .build = build,
        .source = source ? cpu_tree_start(source) : NULL,
        .size_max = size_max,
        .has_references =
            build->parameters.info.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
    };
    if (reference_micromaps(device, &build->parameters, &lazy.micromaps))
        return create_lazy(make_build, &lazy);
    cpu_tree_release(lazy.source);
    return NULL;
}

/* ---- copies */

static VkResult make_compaction(void *context, struct cpu_tree *tree)
{
    struct lazy *lazy = context;
    const void *source = cpu_tree_read(lazy->source);
    if (!source)
        return VK_ERROR_VALIDATION_FAILED;
    return note_refusal(lazy, cpu_make_by_copy(lazy->device,
                                               VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR,
                                               source, lazy->size_max, tree));
}

struct cpu_tree *cpu_lazy_compaction(struct cpu_device *device, struct execution *execution,
                                     struct cpu_tree *source, uint64_t size_max)
{
    struct lazy lazy = {
        .device = device, .execution = execution, .source = source, .size_max = size_max};
    return create_lazy(make_compaction, &lazy);
}

static VkResult make_deserialization(void *context, struct cpu_tree *tree)
{
    struct lazy *lazy = context;
    struct execution *execution = lazy->execution;
    VkResult result = begin_reading(lazy);
    if (result != VK_SUCCESS)
        return result;
    struct snapshot_memory snapshots = {
        .snapshots = &lazy->serialized, .count = 1, .bases = execution->bases};
    struct input_memory memory = snapshot_memory_of(&snapshots);
    result = open_memory(lazy, &snapshots);
    if (result == VK_SUCCESS)
        result = note_refusal(lazy, cpu_make_by_deserializing(lazy->device, &memory,
                                                              lazy->serialized.address,
                                                              lazy->size_max, tree));
    snapshot_memory_close(&snapshots);
    shared_lock_release(&execution->lock);
    return result;
}

struct cpu_tree *cpu_lazy_deserialization(struct cpu_device *device, struct execution *execution,
                                          const struct snapshot *serialized, uint64_t size_max)
{
    struct lazy lazy = {
        .device = device, .execution = execution, .serialized = *serialized, .size_max = size_max};
    return create_lazy(make_deserialization, &lazy);
}
