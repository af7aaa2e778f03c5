/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of the build commands: observe, check, forward; the NV one is in nv.c. */
#include <stdatomic.h>

#include "build_call.h"
#include "formats.h"
#include "host_work.h"
#include "intercepts.h"
#include "state/built_flags.h"
#include "state/readable.h"
#include "submissions.h"

void build_call_find_sizes(struct layer_device *device,
                           const VkAccelerationStructureBuildGeometryInfoKHR *info,
                           const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                           struct size_facts *sizes)
{
    struct build_shape shape;
    bool has_shape = build_shape_of(info, counts, build_type, &shape);
    if (has_shape && size_cache_find(device->sizes, &shape, sizes))
        return;
    if (!device->vk.GetAccelerationStructureBuildSizesKHR)
        return;
    VkAccelerationStructureBuildSizesInfoKHR answer = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    bool is_micromap = info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    device->vk.GetAccelerationStructureBuildSizesKHR(device->handle, build_type, info,
                                                     is_micromap ? NULL : counts, &answer);
    *sizes = (struct size_facts){.known = true,
                                 .acceleration_structure = answer.accelerationStructureSize,
                                 .build_scratch = answer.buildScratchSize,
                                 .update_scratch = answer.updateScratchSize};
    if (has_shape)
        size_cache_add(device->sizes, &shape, sizes);
}

static void find_sizes(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, struct size_facts *sizes)
{
    struct build_call *call = user;
    VkAccelerationStructureBuildTypeKHR build_type =
        call->view.command == COMMAND_HOST ? VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                                           : VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR;
    struct recent_sizes *recent = call->recent_sizes;
    if (recent && recent_sizes_find(recent, info, counts, build_type, sizes))
        return;
    build_call_find_sizes(call->device, info, counts, build_type, sizes);
    if (recent)
        recent_sizes_set(recent, info, counts, build_type, sizes);
}

static enum tristate vertex_format_supported(void *user, VkFormat format)
{
    return layer_takes_vertices(((struct build_call *)user)->device, format);
}

static enum tristate radius_format_supported(void *user, VkFormat format)
{
    return layer_takes_radii(((struct build_call *)user)->device, format);
}

/* ---- the journal */

static bool is_update(const struct build_view *build)
{
    return build->info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
}

static struct built describe(const struct build_call *call, const struct build_view *build)
{
    struct build_description description = {
        .info = build->info,
        .ranges = build->ranges,
        .command_buffer = call->origin.command_buffer,
        .position = call->origin.build_index + build->index,
        .dst_size = build->dst.size,
        .needed_size = build->sizes.known ? build->sizes.acceleration_structure : 0,
        .dense_readable = build->dense_readable,
        .micromaps = build->micromaps,
        .contents = build->contents,
    };
    if (build->geometry_count != build->info->geometryCount)
        return (struct built){.state = BUILT_UNKNOWN, .position = description.position};
    return built_describe(&description);
}

__attribute__((noinline)) static void note_input(const struct build_call *call,
                                                 const struct build_view *build, uint32_t geometry,
                                                 enum input_role role,
                                                 const struct address_facts *facts)
{
    struct journal_input *input = journal_add_input(call->journal, facts->buffer_id);
    if (!input)
        return;
    *input = (struct journal_input){
        .buffer_id = facts->buffer_id,
        .address = facts->address,
        .position = call->origin.build_index + build->index,
        .info = build->index,
        .geometry = geometry,
        .role = (unsigned char)role,
        .command = (unsigned char)call->view.command,
        .is_update = is_update(build),
        .geometry_by_pointer = build->geometry_pointers != NULL,
    };
}

static void see_input(void *user, const struct build_view *build, uint32_t geometry,
                      enum input_role role, const struct address_facts *facts)
{
    const struct build_call *call = user;
    if (facts->status == ADDRESS_IN_BUFFER &&
        !journal_noted_lately(call->journal, facts->buffer_id))
        note_input(call, build, geometry, role, facts);
}

/* The micromaps that a build with that entry reads. */
__attribute__((noinline)) static void note_micromaps(const struct build_call *call,
                                                     const struct build_view *build,
                                                     const struct journal_entry *built)
{
    const struct micromap_uses *uses = build->micromaps;
    bool may_change =
        build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR;
    for (uint32_t i = 0; i < uses->count; i++) {
        const struct micromap_use *use = &uses->items[i];
        struct journal_entry entry = {
            .kind = JOURNAL_USE_MICROMAP,
            .command = built->command,
            .info = built->info,
            .geometry_by_pointer = built->geometry_by_pointer,
            .src = use->handle,
            .src_id = use->id,
            .micromap = {.updated = is_update(build) ? built->src : 0,
                         .updated_id = is_update(build) ? built->src_id : 0,
                         .position = call->origin.build_index + build->index,
                         .geometry = use->geometry,
                         .first = use->first,
                         .triangle_count = use->triangle_count,
                         .is_ext = use->is_ext,
                         .is_unindexed = use->is_unindexed,
                         .must_stay = is_update(build) && !may_change},
        };
        if (use->id)
            journal_add(call->journal, &entry);
    }
}

/* Where the ranges can't be kept nothing is said of them. */
static void see_ranges(void *user, struct noted_ranges *ranges)
{
    struct build_call *call = user;
    if (!ranges)
        return;
    ranges->position = call->origin.build_index;
    journal_add(call->journal, &(struct journal_entry){
                                   .kind = JOURNAL_RANGES,
                                   .command = (unsigned char)call->view.command,
                                   .ranges = ranges,
                               });
}

static void see_build(void *user, const struct build_view *build)
{
    struct build_call *call = user;
    if (!build->dst.id)
        return;
    struct journal_entry entry = {
        .kind = is_update(build) ? JOURNAL_UPDATE : JOURNAL_BUILD,
        .command = (unsigned char)call->view.command,
        .info = build->index,
        .dst = (uint64_t)(uintptr_t)build->dst.handle,
        .dst_id = build->dst.id,
        .dst_backed = build->dst.backed == YES || build->dst.in_pieces,
        .dst_in_pieces = build->dst.in_pieces,
        .src = (uint64_t)(uintptr_t)build->src.handle,
        .src_id = build->src.id,
        .src_backed = build->src.backed == YES || build->src.in_pieces,
        .src_in_pieces = build->src.in_pieces,
        .geometry_by_pointer = build->geometry_pointers != NULL,
        .built = describe(call, build),
    };
    if (call->command_buffer)
        entry.labels = journal_note_labels(call->journal, &call->command_buffer->labels);
    if (call->command_buffer && build->micromaps)
        note_micromaps(call, build, &entry);
    journal_add(call->journal, &entry);
    if (call->command_buffer && build->sizes.known)
        see_input(user, build, 0, INPUT_SCRATCH, &build->scratch);
}

/* ---- the calls */

/* Large calls want memory, and are often followed by others: the device keeps that of some. */
enum { LARGE_CALL = 16 };

static struct sweep *_Atomic *spare_of_thread(const struct build_call *call)
{
    return &call->device->spares[reader_lock_stripe()].sweep;
}

static struct sweep *take_sweep(const struct build_call *call)
{
    if (call->view.info_count <= LARGE_CALL)
        return NULL;
    struct sweep *spare = atomic_exchange(spare_of_thread(call), NULL);
    return spare ? spare : check_make_sweep();
}

static void give_back_sweep(const struct build_call *call, struct sweep *sweep)
{
    struct sweep *other = sweep ? atomic_exchange(spare_of_thread(call), sweep) : NULL;
    if (other)
        check_free_sweep(other);
}

static void run_checks(struct build_call *call, struct readable_cache *readable)
{
    struct check_context context = {
        .level = call->device->level,
        .active = call->device->active_rules[call->view.command],
        .readable = readable,
        .resources = call->device->resources,
        .sweep = take_sweep(call),
        .flags = call->turn ? submissions_flags(call->device->submissions) : NULL,
        .turn = call->turn,
        .found = build_call_found,
        .find_sizes = find_sizes,
        .vertex_format_supported = vertex_format_supported,
        .radius_format_supported = radius_format_supported,
        .of_another_device = build_call_of_another_device,
        .user = call,
    };
    bool is_recorded = build_call_begin_journal(call);
    /* Below that level backend cpu has an order, too, but views have no state. */
    if (call->journal && call->device->level >= LEVEL_EXECUTION) {
        context.see_build = see_build;
        context.see_ranges = see_ranges;
    }
    if (is_recorded)
        context.see_input = see_input;
    check_builds(&context, &call->view);
    give_back_sweep(call, context.sweep);
    if (is_recorded)
        build_call_settle_journal(call);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdBuildAccelerationStructuresKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct layer_device *device = layer_find_device(commandBuffer);
    struct build_call call = build_call_start(device, COMMAND_DEVICE);
    build_call_set_command_buffer(&call, commandBuffer);
    call.view.info_count = infoCount;
    call.view.infos = pInfos;
    call.view.build_ranges = ppBuildRangeInfos;
    run_checks(&call, readable_cache_of_thread());
    if (call.skip)
        return;
    build_call_count_builds(&call, infoCount);
    device->vk.CmdBuildAccelerationStructuresKHR(commandBuffer, infoCount, pInfos,
                                                 ppBuildRangeInfos);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdBuildAccelerationStructuresIndirectKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkDeviceAddress *pIndirectDeviceAddresses, const uint32_t *pIndirectStrides,
    const uint32_t *const *ppMaxPrimitiveCounts)
{
    struct layer_device *device = layer_find_device(commandBuffer);
    struct build_call call = build_call_start(device, COMMAND_INDIRECT);
    build_call_set_command_buffer(&call, commandBuffer);
    call.view.info_count = infoCount;
    call.view.infos = pInfos;
    call.view.max_primitive_counts = ppMaxPrimitiveCounts;
    call.view.indirect_addresses = pIndirectDeviceAddresses;
    call.view.indirect_strides = pIndirectStrides;
    run_checks(&call, readable_cache_of_thread());
    if (call.skip)
        return;
    build_call_count_builds(&call, infoCount);
    device->vk.CmdBuildAccelerationStructuresIndirectKHR(commandBuffer, infoCount, pInfos,
                                                         pIndirectDeviceAddresses, pIndirectStrides,
                                                         ppMaxPrimitiveCounts);
}

/* Reports a handle that leads to no device, in the name of some device. */
static void tell_of_device(VkDevice handle)
{
    struct layer_device *some = layer_any_device();
    if (!some)
        return;
    struct build_call call = build_call_start(some, COMMAND_HOST);
    const bool active[RULE_COUNT] = {[RULE_device_is_valid] =
                                         some->active_rules[COMMAND_HOST][RULE_device_is_valid]};
    struct readable_cache cache = {0};
    struct check_context context = {
        .active = active, .readable = &cache, .found = build_call_found, .user = &call};
    call.view.device_argument = handle;
    check_builds(&context, &call.view);
}

/* What the host's instances refer to is as it is when the call is made; a structure that is being
 * written then is nobody's to refer to. False where it isn't known. */
static bool find_turn(const struct layer_device *device, struct built_flags_turn *turn)
{
    struct built_flags *flags = submissions_flags(device->submissions);
    if (!flags)
        return false;
    *turn = (struct built_flags_turn){.turn = built_flags_now(flags), .is_unordered = true};
    return execution_order_host_turn(device->order, &turn->follows);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_BuildAccelerationStructuresKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct layer_device *state = layer_find_device_safely(device);
    if (!state) {
        tell_of_device(device);
        return VK_ERROR_VALIDATION_FAILED_EXT;
    }
    struct build_call call = build_call_start(state, COMMAND_HOST);
    struct recent_sizes recent_sizes = {0};
    struct built_flags_turn turn;
    call.recent_sizes = &recent_sizes;
    call.turn = find_turn(state, &turn) ? &turn : NULL;
    call.view.device_argument = device;
    call.view.deferred = host_work_operation_facts(state, deferredOperation);
    call.view.info_count = infoCount;
    call.view.infos = pInfos;
    call.view.build_ranges = ppBuildRangeInfos;
    struct host_work work = host_work_begin(state);
    call.journal = work.journal;
    struct readable_cache readable = {0};
    run_checks(&call, &readable);
    if (host_work_prepare(&work, call.skip))
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.BuildAccelerationStructuresKHR(device, deferredOperation, infoCount,
                                                               pInfos, ppBuildRangeInfos);
    return host_work_finish(&work, deferredOperation, result);
}
