/* SPDX-License-Identifier: Apache-2.0 */
/* The work of trees that are made late, and what it holds until then. */
#include "src/cpu/trees/late_trees.h"

#include <stdlib.h>
#include <string.h>

#include "src/bvh/micromap.h"
#include "src/cpu/trees/make.h"
#include "src/cpu/trees/pins.h"

/* A micromap that displaces triangles, as it was when the build executed. */
struct held_micromap {
    uint64_t reference;
    struct cpu_tree *tree; /* NULL: the reference leads nowhere */
};

struct held_micromaps {
    uint32_t count;
    struct held_micromap micromaps[];
};

struct late {
    struct cpu_device *device;
    uint64_t size_max;
    struct execution *execution;        /* whose snapshots are read; NULL: none */
    const struct recorded_build *build; /* of the execution's recording */
    struct snapshot serialized;
    struct cpu_tree *source; /* of an update or a compaction */
    struct cpu_pins pins;    /* what instances refer to, as it was when the build executed */
    bool has_pins;
    struct held_micromaps *micromaps; /* NULL: nothing is displaced */
};

static void release_micromaps(struct held_micromaps *held)
{
    for (uint32_t i = 0; held && i < held->count; i++)
        cpu_tree_release(held->micromaps[i].tree);
    free(held);
}

/* False without memory. Those alone, and not all that changes from now on, as pins have it: among
 * that may be the structure that is built. */
static bool hold_micromaps(struct cpu_device *device, const struct build_parameters *build,
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

static void release(void *context)
{
    struct late *late = context;
    release_micromaps(late->micromaps);
    if (late->has_pins)
        cpu_pins_release(&late->pins);
    cpu_tree_release(late->source);
    execution_release(late->execution);
    free(late);
}

static VkResult make_build(void *context, struct cpu_tree *tree);
static VkResult make_compaction(void *context, struct cpu_tree *tree);

/* Returns one reference to a tree that `make` makes; what `late` holds is taken over. */
static struct cpu_tree *create(VkResult (*make)(void *context, struct cpu_tree *tree),
                               const struct late *late)
{
    struct late *own = malloc(sizeof(*own));
    struct cpu_tree_work recording = {
        .make = make,
        .release = release,
        .context = own,
        .start = make == make_build ? late->source : NULL,
        .is_top_level =
            late->has_pins || (make == make_compaction && cpu_tree_is_top_level(late->source)),
    };
    struct cpu_tree *tree = own ? cpu_tree_create_late(&recording) : NULL;
    if (tree) {
        *own = *late;
        if (own->execution)
            execution_share(own->execution);
        if (own->has_pins) {
            cpu_pins_init(&own->pins, own->device->structures);
            cpu_pins_hold(&own->pins);
        }
        return tree;
    }
    free(own);
    release_micromaps(late->micromaps);
    cpu_tree_release(late->source);
    return NULL;
}

/* Waits for the end of an execution, and begins to read its snapshots, unless that fails. */
static VkResult begin_reading(const struct late *late)
{
    struct execution *execution = late->execution;
    unsigned never = OVERWRITTEN_NEVER;
    VkResult result = execution->ticket->wait(execution->ticket, UINT64_MAX);
    if (result != VK_SUCCESS)
        return result;
    if (atomic_load(&execution->is_overwritten))
        atomic_compare_exchange_strong(&late->device->overwritten, &never, OVERWRITTEN_ONCE);
    pthread_rwlock_rdlock(&execution->lock);
    return VK_SUCCESS;
}

/* Without the copies it is not known what was built. The caller closes the memory, also after a
 * failure. */
static VkResult open_memory(const struct late *late, struct snapshot_memory *snapshots)
{
    if (late->execution->is_lost || !snapshot_memory_open(snapshots))
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    if (snapshots->lacks_copies)
        atomic_store(&late->device->lacks_copies, true);
    return snapshots->lacks_copies ? VK_ERROR_UNKNOWN : VK_SUCCESS;
}

/* ---- builds */

static VkResult make_by_build(const struct late *late, const struct cpu_making *making,
                              struct cpu_tree *tree)
{
    VkResult result = cpu_make_by_build(making, tree);
    bool is_whole = !late->has_pins || !late->pins.out_of_memory;
    return result == VK_SUCCESS && !is_whole ? VK_ERROR_OUT_OF_HOST_MEMORY : result;
}

static VkResult make_from_memory(struct late *late, const struct input_memory *memory,
                                 struct cpu_tree *tree)
{
    struct build_parameters parameters = late->build->parameters;
    const struct cpu_making making = {
        .device = late->device,
        .build = &parameters,
        .memory = *memory,
        .resolver = late->has_pins ? cpu_pins_resolver(&late->pins) : (struct builder_resolver){0},
        .micromaps = {find_held, late->micromaps},
        .source = late->source ? cpu_tree_read(late->source) : NULL,
        .size_max = late->size_max,
    };
    if (late->source && !making.source)
        return VK_ERROR_VALIDATION_FAILED;
    if (!late->build->is_indirect)
        return make_by_build(late, &making, tree);

    parameters.ranges = calloc(parameters.info.geometryCount + 1u, sizeof(*parameters.ranges));
    if (!parameters.ranges)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    recorded_build_read_ranges(late->build, memory, parameters.ranges);
    VkResult result = make_by_build(late, &making, tree);
    free(parameters.ranges);
    return result;
}

static VkResult make_build(void *context, struct cpu_tree *tree)
{
    struct late *late = context;
    struct execution *execution = late->execution;
    VkResult result = begin_reading(late);
    if (result != VK_SUCCESS)
        return result;
    struct snapshot_memory snapshots = {
        .snapshots = late->build->snapshots,
        .count = late->build->snapshot_count,
        .bases = execution->bases,
        .gathering = &late->build->gathering,
    };
    result = open_memory(late, &snapshots);
    if (result == VK_SUCCESS) {
        struct input_memory memory = snapshot_memory_of(&snapshots);
        result = make_from_memory(late, &memory, tree);
    }
    snapshot_memory_close(&snapshots);
    pthread_rwlock_unlock(&execution->lock);
    return result;
}

struct cpu_tree *cpu_late_build(struct cpu_device *device, struct execution *execution,
                                const struct recorded_build *build, struct cpu_tree *source,
                                uint64_t size_max)
{
    struct late late = {
        .device = device,
        .execution = execution,
        .build = build,
        .source = source ? cpu_tree_start(source) : NULL,
        .size_max = size_max,
        .has_pins = build->parameters.info.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
    };
    if (hold_micromaps(device, &build->parameters, &late.micromaps))
        return create(make_build, &late);
    cpu_tree_release(late.source);
    return NULL;
}

/* ---- copies */

static VkResult make_compaction(void *context, struct cpu_tree *tree)
{
    struct late *late = context;
    const void *source = cpu_tree_read(late->source);
    return source ? cpu_make_by_copy(late->device, VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR,
                                     source, late->size_max, tree)
                  : VK_ERROR_VALIDATION_FAILED;
}

struct cpu_tree *cpu_late_compaction(struct cpu_device *device, struct cpu_tree *source,
                                     uint64_t size_max)
{
    struct late late = {.device = device, .source = source, .size_max = size_max};
    return create(make_compaction, &late);
}

static VkResult make_deserialization(void *context, struct cpu_tree *tree)
{
    struct late *late = context;
    struct execution *execution = late->execution;
    VkResult result = begin_reading(late);
    if (result != VK_SUCCESS)
        return result;
    struct snapshot_memory snapshots = {
        .snapshots = &late->serialized, .count = 1, .bases = execution->bases};
    struct input_memory memory = snapshot_memory_of(&snapshots);
    result = open_memory(late, &snapshots);
    if (result == VK_SUCCESS)
        result = cpu_make_by_deserializing(late->device, &memory, late->serialized.address,
                                           late->size_max, tree);
    snapshot_memory_close(&snapshots);
    pthread_rwlock_unlock(&execution->lock);
    return result;
}

struct cpu_tree *cpu_late_deserialization(struct cpu_device *device, struct execution *execution,
                                          const struct snapshot *serialized, uint64_t size_max)
{
    struct late late = {
        .device = device, .execution = execution, .serialized = *serialized, .size_max = size_max};
    return create(make_deserialization, &late);
}
