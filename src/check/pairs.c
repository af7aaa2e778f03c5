/* SPDX-License-Identifier: Apache-2.0 */
/* Collecting the ranges of a call, and putting pairs of them to the rules. */
#include "check/pairs.h"

static VkDeviceSize smaller_of(VkDeviceSize a, VkDeviceSize b)
{
    return a < b ? a : b;
}

/* The ranges of a call, and what takes them apart. */
struct collection {
    struct sweep *sweep;
    struct used_range range; /* the one being added */
};

/* Adds `size` bytes at the beginning of `span`. */
static inline void add_range(struct collection *collection, const struct memory_span *span,
                             VkDeviceSize size)
{
    collection->range.span = *span;
    collection->range.span.end = smaller_of(span->end, span->begin + size);
    sweep_add(collection->sweep, &collection->range);
}

static void add_piece(void *user, const struct memory_span *piece)
{
    add_range(user, piece, piece->end - piece->begin);
}

/* Adds bytes of a sparse buffer, to be found when the build executes. */
static void add_sparse(struct collection *collection, VkBuffer buffer, uint64_t buffer_id,
                       VkDeviceSize offset, VkDeviceSize size)
{
    struct noted_range noted = {.range = collection->range,
                                .bytes = {buffer, buffer_id, offset, offset + size}};
    noted.range.in_pieces = true;
    sweep_note(collection->sweep, &noted);
}

/* A structure is added in any case, for its handle. */
static void add_accel(struct collection *collection, const struct accel_facts *accel,
                      VkDeviceSize size)
{
    add_range(collection, &accel->span, size);
    if (accel->in_pieces)
        add_sparse(collection, accel->buffer, accel->buffer_id, accel->offset, size);
}

/* A build accesses no more of a structure than its size needs, whatever the structure was created
 * with; where that isn't known nothing is said of its bytes. */
static void add_structure(struct collection *collection, const struct build_view *build,
                          const struct accel_facts *accel)
{
    VkDeviceSize size = 0;
    if (build->sizes.known)
        size = smaller_of(accel->size, build->sizes.acceleration_structure);
    collection->range.handle = accel->handle;
    add_accel(collection, accel, size);
}

/* A structure of which no more than its handle is known, or matters. */
static void add_handle(struct collection *collection, VkAccelerationStructureKHR handle)
{
    const struct memory_span nowhere = {0};
    collection->range.handle = handle;
    add_range(collection, &nowhere, 0);
}

/* A build accesses no more of a micromap than that needs, and all of that begins where the micromap
 * does; how much it is isn't known. */
static void collect_micromaps(struct collection *collection, const struct micromap_uses *micromaps)
{
    collection->range.role = ROLE_SRC;
    collection->range.is_micromap = true;
    for (uint32_t i = 0; i < micromaps->count; i++) {
        const struct micromap_use *use = &micromaps->items[i];
        if (use->is_ext || !use->handle || (i && use->handle == use[-1].handle))
            continue;
        collection->range.handle = (VkAccelerationStructureKHR)(uintptr_t)use->handle;
        add_accel(collection, &use->accel, 1);
    }
}

void pairs_collect(const struct check_context *context, struct sweep *sweep,
                   const struct build_view *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    bool has_state = context->level >= LEVEL_STATE;
    bool is_update = info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    struct collection collection = {.sweep = sweep,
                                    .range = {.build = build->index, .is_update = is_update}};
    collection.range.role = ROLE_DST;
    if (has_state)
        add_structure(&collection, build, &build->dst);
    else
        add_handle(&collection, info->dstAccelerationStructure);

    /* A build that is no update reads nothing of its source. */
    collection.range.role = ROLE_SRC;
    if (info->srcAccelerationStructure && is_update && has_state)
        add_structure(&collection, build, &build->src);
    else if (info->srcAccelerationStructure)
        add_handle(&collection, info->srcAccelerationStructure);

    if (build->micromaps)
        collect_micromaps(&collection, build->micromaps);

    const struct address_facts *scratch = &build->scratch;
    collection.range.role = ROLE_SCRATCH;
    collection.range.is_micromap = false;
    collection.range.handle = VK_NULL_HANDLE;
    if (!build->sizes.known)
        return;
    VkDeviceSize size = is_update ? build->sizes.update_scratch : build->sizes.build_scratch;
    if (build->call->command == COMMAND_HOST)
        resources_find_host_pieces(context->resources, info->scratchData.hostAddress, size,
                                   add_piece, &collection);
    if (scratch->status != ADDRESS_IN_BUFFER)
        return;
    if (scratch->in_pieces)
        add_sparse(&collection, scratch->buffer, scratch->buffer_id, scratch->buffer_offset, size);
    else
        add_range(&collection, &scratch->span, size);
}

void pairs_collect_dst(struct sweep *sweep, const struct build_view *build)
{
    struct collection collection = {.sweep = sweep,
                                    .range = {.build = build->index, .role = ROLE_DST}};
    add_structure(&collection, build, &build->dst);
}

/* How much is accessed of these isn't known, either. */
void pairs_collect_instances(struct sweep *sweep, const struct build_view *build,
                             const struct instance_uses *instances)
{
    struct collection collection = {
        .sweep = sweep, .range = {.build = build->index, .role = ROLE_SRC, .is_instance = true}};
    for (uint32_t i = 0; i < instances->count; i++) {
        collection.range.handle = instances->items[i].handle;
        add_accel(&collection, &instances->items[i], 1);
    }
}

/* Whether any rule about two ranges of these roles still wants findings. */
static bool wants_pairs_of(const struct walk *walk, enum range_role a, enum range_role b)
{
    const bool *wants = walk->wants;
    if (a == ROLE_DST && b == ROLE_DST)
        return wants[RULE_no_dst_is_built_twice] || wants[RULE_dst_and_dst_are_apart];
    if (a == ROLE_DST && b == ROLE_SRC)
        return wants[RULE_no_src_is_the_dst_of_another_build] ||
               wants[RULE_update_src_and_dst_do_not_alias] ||
               wants[RULE_dst_and_update_src_are_apart] ||
               wants[RULE_no_dst_is_a_micromap_of_another_build] ||
               wants[RULE_dst_and_micromaps_of_other_builds_are_apart] ||
               wants[RULE_no_dst_is_an_instance_of_another_build] ||
               wants[RULE_dst_and_instances_of_other_builds_are_apart];
    if (a == ROLE_DST)
        return wants[RULE_dst_and_scratch_are_apart];
    if (a == ROLE_SRC)
        return b == ROLE_SCRATCH && wants[RULE_scratch_and_update_src_are_apart];
    return wants[RULE_scratch_and_scratch_are_apart];
}

struct pair_walk {
    struct walk *walk;
    const struct call_view *call;
    bool in_pieces; /* only pairs of which one is in a sparse buffer */
};

static bool visit_pair(void *user, const struct used_range *a, const struct used_range *b,
                       const struct memory_span *shared)
{
    struct pair_walk *pairs = user;
    if (pairs->in_pieces && !a->in_pieces && !b->in_pieces)
        return true;
    struct pair_view pair = {
        .call = pairs->call, .a = *a, .b = *b, .shares_memory = shared != NULL};
    if (shared)
        pair.shared = *shared;
    walk_pair(pairs->walk, &pair);
    return wants_pairs_of(pairs->walk, a->role, b->role);
}

void pairs_walk(struct walk *walk, const struct call_view *call, struct sweep *sweep)
{
    struct pair_walk pairs = {.walk = walk, .call = call};
    sweep_equal_handles(sweep, visit_pair, &pairs);
    if (walk->context->level >= LEVEL_STATE)
        sweep_shared_memory(sweep, visit_pair, &pairs);
}

void pairs_walk_pieces(struct walk *walk, const struct call_view *call, struct sweep *sweep)
{
    struct pair_walk pairs = {.walk = walk, .call = call, .in_pieces = true};
    sweep_shared_memory(sweep, visit_pair, &pairs);
}
