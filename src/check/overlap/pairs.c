/* SPDX-License-Identifier: Apache-2.0 */
/* Collects the ranges of a call and evaluates the rules for pairs of them. */
#include "src/check/overlap/pairs.h"
#include "src/base/recording_path.h"
#include "src/model/geometry.h"

/* Returns room for a range of a build with every member but the span filled in. Returns NULL if
 * there is no memory. */
static inline struct used_range *begin_range(struct sweep *sweep, const struct build_view *build,
                                             enum range_role role,
                                             VkAccelerationStructureKHR handle)
{
    struct used_range *range = sweep_room(sweep, role);
    if (range)
        *range = (struct used_range){
            .role = role,
            .build = build->index,
            .is_in_place = build_is_in_place(build->info),
            .handle = handle,
        };
    return range;
}

/* Keeps bytes of a sparse buffer, whose memory is looked up when the build executes. */
static void note_sparse(struct sweep *sweep, const struct used_range *range,
                        const struct sparse_bytes *bytes)
{
    struct noted_range noted = {.range = *range, .bytes = *bytes};
    noted.range.is_sparse = true;
    sweep_note(sweep, &noted);
}

__attribute__((noinline)) static void note_sparse_accel(struct sweep *sweep,
                                                        const struct used_range *range,
                                                        const struct accel_facts *accel,
                                                        VkDeviceSize size)
{
    const struct sparse_bytes bytes = {accel->buffer, accel->buffer_id, accel->begin,
                                       accel->begin + size};
    note_sparse(sweep, range, &bytes);
}

/* A build accesses only accelerationStructureSize bytes of a structure, however large it was
 * created. Returns 0 if that size is unknown. */
static inline VkDeviceSize size_in_structure(const struct build_view *build,
                                             const struct accel_facts *accel)
{
    return build->sizes.known ? smaller_of(accel->size, build->sizes.acceleration_structure) : 0;
}

static inline struct memory_span span_of_scratch(const struct address_facts *scratch,
                                                 VkDeviceSize size)
{
    return memory_span_of(scratch->memory, scratch->begin, smaller_of(scratch->bytes_left, size));
}

/* Adds the first `size` bytes of a structure. The range is added even if they are unknown, because
 * of its handle. */
static inline void add_in_accel(struct sweep *sweep, struct used_range *range,
                                const struct accel_facts *accel, VkDeviceSize size)
{
    range->span = memory_span_of(accel->memory, accel->begin, size);
    sweep_keep(sweep, range);
    if (accel->is_sparse)
        note_sparse_accel(sweep, range, accel, size);
}

__attribute__((always_inline)) static inline void add_structure(struct sweep *sweep,
                                                                const struct build_view *build,
                                                                enum range_role role,
                                                                const struct accel_facts *accel)
{
    struct used_range *range = begin_range(sweep, build, role, accel->handle);
    if (range)
        add_in_accel(sweep, range, accel, size_in_structure(build, accel));
}

/* Adds a structure by its handle only. */
static void add_handle(struct sweep *sweep, const struct build_view *build, enum range_role role,
                       VkAccelerationStructureKHR handle)
{
    struct used_range *range = begin_range(sweep, build, role, handle);
    if (range)
        sweep_keep(sweep, range);
}

/* A build accesses an unknown part of a micromap, which begins where the micromap does: adds the
 * first byte. */
static void collect_micromaps(struct sweep *sweep, const struct build_view *build)
{
    const struct micromap_uses *micromaps = build->micromaps;
    for (uint32_t i = 0; i < micromaps->count; i++) {
        const struct micromap_use *use = &micromaps->items[i];
        if (use->is_ext || !use->handle || (i && use->handle == use[-1].handle))
            continue;
        struct used_range *range =
            begin_range(sweep, build, ROLE_SRC, (VkAccelerationStructureKHR)(uintptr_t)use->handle);
        if (!range)
            return;
        range->is_micromap = true;
        add_in_accel(sweep, range, &use->accel, smaller_of(use->accel.size, 1));
    }
}

/* The context of add_host_piece(). */
struct host_scratch {
    struct sweep *sweep;
    const struct build_view *build;
};

static void add_host_piece(void *user, const struct memory_span *piece)
{
    const struct host_scratch *scratch = user;
    struct used_range *range =
        begin_range(scratch->sweep, scratch->build, ROLE_SCRATCH, VK_NULL_HANDLE);
    if (!range)
        return;
    range->span = *piece;
    sweep_keep(scratch->sweep, range);
}

static inline void collect_scratch(struct sweep *sweep, const struct build_view *build,
                                   VkDeviceSize size)
{
    const struct address_facts *scratch = &build->scratch;
    struct used_range *range = begin_range(sweep, build, ROLE_SCRATCH, VK_NULL_HANDLE);
    if (!range)
        return;
    range->span = span_of_scratch(scratch, size);
    if (scratch->is_sparse)
        note_sparse(sweep, range,
                    &(struct sparse_bytes){scratch->buffer, scratch->buffer_id, scratch->begin,
                                           scratch->begin + size});
    else
        sweep_keep(sweep, range);
}

void pairs_collect(const struct check_context *context, struct sweep *sweep,
                   const struct build_view *build)
{
    VkAccelerationStructureKHR src = build->info->srcAccelerationStructure;
    bool has_state = context->level >= LEVEL_STATE;
    bool is_update = build_is_update(build->info);
    if (has_state)
        add_structure(sweep, build, ROLE_DST, &build->dst);
    else
        add_handle(sweep, build, ROLE_DST, build->info->dstAccelerationStructure);

    /* A build that is not an update reads nothing of its source. */
    if (src && is_update && has_state)
        add_structure(sweep, build, ROLE_SRC, &build->src);
    else if (src)
        add_handle(sweep, build, ROLE_SRC, src);
    if (build->micromaps)
        collect_micromaps(sweep, build);
    if (!build->sizes.known)
        return;
    VkDeviceSize scratch_size = build_scratch_size(build);
    if (build->scratch.status == ADDRESS_IN_BUFFER)
        collect_scratch(sweep, build, scratch_size);
    else if (build->call->command == COMMAND_HOST)
        resources_find_host_pieces(context->resources, build->info->scratchData.hostAddress,
                                   scratch_size, add_host_piece,
                                   &(struct host_scratch){sweep, build});
}

bool pairs_has_none_within(const struct check_context *context, const struct build_view *build)
{
    const struct accel_facts *dst = &build->dst;
    const struct address_facts *scratch = &build->scratch;
    if (context->level < LEVEL_STATE || !build->sizes.known ||
        build->info->srcAccelerationStructure || build->micromaps ||
        scratch->status != ADDRESS_IN_BUFFER || dst->is_sparse || scratch->is_sparse)
        return false;
    struct memory_span a = memory_span_of(dst->memory, dst->begin, size_in_structure(build, dst));
    struct memory_span b = span_of_scratch(scratch, build_scratch_size(build));
    return a.memory != b.memory || a.end <= b.begin || b.end <= a.begin;
}

void pairs_collect_dst(struct sweep *sweep, const struct build_view *build)
{
    add_structure(sweep, build, ROLE_DST, &build->dst);
}

/* A build accesses an unknown part of a referenced structure: adds the first byte. */
void pairs_collect_instances(struct sweep *sweep, const struct build_view *build,
                             const struct instance_uses *instances)
{
    for (uint32_t i = 0; i < instances->count; i++) {
        const struct accel_facts *accel = &instances->items[i].referenced;
        struct used_range *range = begin_range(sweep, build, ROLE_SRC, accel->handle);
        if (!range)
            return;
        range->is_instance = true;
        add_in_accel(sweep, range, accel, smaller_of(accel->size, 1));
    }
}

/* Returns whether a rule is active about a dst that is the same structure as a range of a kind. */
static bool is_active_for_equal(const bool *active, enum range_kind kind)
{
    switch (kind) {
    case KIND_DST:
        return active[RULE_no_dst_is_built_twice];
    case KIND_SRC:
        return active[RULE_no_src_is_the_dst_of_another_build];
    case KIND_MICROMAP:
        return active[RULE_no_dst_is_a_micromap_of_another_build];
    case KIND_INSTANCE:
        return active[RULE_no_dst_is_an_instance_of_another_build];
    default:
        return false;
    }
}

/* Returns whether a rule is active about a dst that shares memory with a range of a kind. */
static bool is_active_for_shared(const bool *active, enum range_kind kind)
{
    switch (kind) {
    case KIND_DST:
        return active[RULE_dst_and_dst_are_apart];
    case KIND_SRC:
        return active[RULE_update_src_and_dst_do_not_alias] ||
               active[RULE_dst_and_update_src_are_apart];
    case KIND_MICROMAP:
        return active[RULE_dst_and_micromaps_of_other_builds_are_apart];
    case KIND_INSTANCE:
        return active[RULE_dst_and_instances_of_other_builds_are_apart];
    default:
        return active[RULE_dst_and_scratch_are_apart];
    }
}

/* Returns whether a rule is active about two ranges of kinds `a` <= `b`. */
static bool is_active_for_pair(const bool *active, enum range_kind a, enum range_kind b,
                               bool shares_memory)
{
    if (!shares_memory)
        return is_active_for_equal(active, b);
    if (a == KIND_DST)
        return is_active_for_shared(active, b);
    return active[a == KIND_SCRATCH ? RULE_scratch_and_scratch_are_apart
                                    : RULE_scratch_and_update_src_are_apart];
}

struct pair_walk {
    struct walk *walk;
    const struct call_view *call;
    bool is_sparse; /* evaluate only pairs with a range in a sparse buffer */
};

/* Builds of micromaps are no builds of the command buffer's count. */
static struct location location_of(const struct call_view *call, uint32_t build)
{
    return (struct location){.command = call->command,
                             .subject = call->command < BUILD_COMMAND_COUNT ? SUBJECT_BUILD
                                                                            : SUBJECT_ARGUMENT,
                             .argument = "pInfos",
                             .is_element = true,
                             .build = build};
}

static bool visit_pair(void *user, const struct used_range *a, const struct used_range *b,
                       const struct memory_span *shared)
{
    struct pair_walk *pairs = user;
    if (pairs->is_sparse && !a->is_sparse && !b->is_sparse)
        return true;
    struct pair_view pair = {
        .call = pairs->call, .a = *a, .b = *b, .shares_memory = shared != NULL};
    if (shared)
        pair.shared = *shared;
    const struct location location = location_of(pairs->call, a->build);
    walk_pair(pairs->walk, &pair, &location);
    return is_active_for_pair(pairs->walk->active, range_kind(a), range_kind(b), shared != NULL);
}

ON_RECORDING_PATH void pairs_walk(struct walk *walk, const struct call_view *call,
                                  struct sweep *sweep)
{
    struct pair_walk pairs = {.walk = walk, .call = call};
    if (sweep_finds_nothing(sweep))
        return;
    sweep_equal_handles(sweep, visit_pair, &pairs);
    if (walk->context->level >= LEVEL_STATE)
        sweep_shared_memory(sweep, visit_pair, &pairs);
}

void pairs_walk_pieces(struct walk *walk, const struct call_view *call, struct sweep *sweep)
{
    struct pair_walk pairs = {.walk = walk, .call = call, .is_sparse = true};
    sweep_shared_memory(sweep, visit_pair, &pairs);
}
