/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing: observes its structures, and intercepts the command that builds them. */
#include <string.h>

#include "layer/execution/build_records.h"
#include "layer/intercepts/intercepts.h"
#include "layer/snapshots/guard/references.h"
#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"
#include "src/state/resources/nv_shape.h"

/* ---- structures */

static VkMemoryRequirements requirements_of(const struct layer_device *device,
                                            VkAccelerationStructureNV accel,
                                            VkAccelerationStructureMemoryRequirementsTypeNV type)
{
    const VkAccelerationStructureMemoryRequirementsInfoNV info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_INFO_NV,
        .type = type,
        .accelerationStructure = accel,
    };
    VkMemoryRequirements2 answer = {.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
    device->vk.GetAccelerationStructureMemoryRequirementsNV(device->handle, &info, &answer);
    return answer.memoryRequirements;
}

/* The sizes depend only on the creation parameters, so builds need no query. */
static struct nv_size_facts find_sizes(const struct layer_device *device,
                                       VkAccelerationStructureNV accel)
{
    if (device->level < LEVEL_STATE || !device->vk.GetAccelerationStructureMemoryRequirementsNV)
        return (struct nv_size_facts){.known = false};
    const VkMemoryRequirements object = requirements_of(
        device, accel, VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV);
    return (struct nv_size_facts){
        .known = true,
        .object = object.size,
        .alignment = object.alignment,
        .memory_types = object.memoryTypeBits,
        .build_scratch =
            requirements_of(device, accel,
                            VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV)
                .size,
        .update_scratch =
            requirements_of(device, accel,
                            VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV)
                .size,
    };
}

void note_nv_accel(struct layer_device *device, VkAccelerationStructureNV accel,
                   const VkAccelerationStructureCreateInfoNV *info)
{
    struct nv_size_facts sizes = find_sizes(device, accel);
    resources_add_nv_accel(device->resources, accel, nv_shape_create(&info->info), &sizes);
}

void forget_nv_accel(struct layer_device *device, VkAccelerationStructureNV accel)
{
    build_records_add_destroyed(device, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                                handle_number(accel));
    const uint64_t id = resources_remove_nv_accel(device->resources, accel);
    structures_note_destroyed(device->structures, id, 1);
    object_names_end(device->names, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, handle_number(accel),
                     id);
}

/* Whether instance i of the structure is bound to another instance of the memory than i. */
static bool instances_differ(const VkBindAccelerationStructureMemoryInfoNV *bind)
{
    for (uint32_t i = 0; i < bind->deviceIndexCount; i++)
        if (bind->pDeviceIndices[i] != i)
            return true;
    return false;
}

/* A failed call may have bound some structures. */
void note_nv_bindings(struct layer_device *device, uint32_t count,
                      const VkBindAccelerationStructureMemoryInfoNV *infos, VkResult result)
{
    for (uint32_t i = 0; i < count; i++)
        if (result == VK_SUCCESS)
            resources_bind_nv_accel(device->resources, infos[i].accelerationStructure,
                                    infos[i].memory, infos[i].memoryOffset,
                                    instances_differ(&infos[i]));
        else
            resources_forget_nv_binding(device->resources, infos[i].accelerationStructure);
}

void note_nv_reference(struct layer_device *device, VkAccelerationStructureNV accel, size_t size,
                       void *data)
{
    uint64_t reference;
    if (device->level < LEVEL_CONTENT)
        return;
    if (size >= sizeof(reference) &&
        readable(readable_cache_of_thread(), data, sizeof(reference))) {
        memcpy(&reference, data, sizeof(reference));
        resources_add_nv_reference(device->resources, accel, reference);
    } else {
        resources_forget_nv_references(device->resources);
    }
    guard_follow(device);
}

/* ---- builds */

static struct built describe_nv_build(const struct build_call *call,
                                      const struct nv_call_view *view)
{
    uint32_t position = call->view.command_buffer.build_index;
    if (!view->info)
        return (struct built){.state = BUILT_UNKNOWN, .position = position};
    /* Later updates are compared with the shapes alone. */
    bool can_query =
        view->update || (view->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_NV);
    struct geometry_shapes *shapes = NULL;
    if (call->device->level >= LEVEL_CONTENT && can_query && view->build.info)
        shapes = geometry_shapes_create(
            &(struct build_description){.info = view->build.info, .ranges = view->build.ranges});
    return (struct built){.state = BUILT_BEFORE,
                          .command_buffer = call->view.command_buffer.handle,
                          .command_buffer_id = call->view.command_buffer.id,
                          .position = position,
                          .flags = view->info->flags,
                          .type = view->info->type,
                          .geometry_count = view->info->geometryCount,
                          .shapes = shapes};
}

/* For setting record_builds. */
static void note_primitives(struct journal *journal, const struct nv_call_view *view)
{
    struct journal_entry entry = {.info = 1};
    for (uint32_t i = 0; i < view->build.geometry_count; i++)
        entry.number += view->build.ranges[i].primitiveCount;
    if (view->build.info)
        journal_add_primitives(journal, entry);
}

void nv_record_build(void *user, const struct nv_call_view *view)
{
    struct build_call *call = user;
    struct journal *journal = call->journal;
    if (!view->dst_facts.id)
        return;
    if (call->device->records_builds)
        note_primitives(journal, view);
    struct journal_entry *entry =
        journal_begin_build(journal, view->update, call->device->snapshots);
    if (!entry)
        return;
    *entry = (struct journal_entry){
        .kind = entry->kind,
        .size = entry->size,
        .command = COMMAND_NV,
        .origin = build_call_origin(call),
        .dst = handle_number(view->dst),
        .dst_id = view->dst_facts.id,
        .dst_backing = view->dst_facts.binding == NV_BOUND ? BACKED_BY_MEMORY : 0,
        .src = handle_number(view->src),
        .src_id = view->src_facts.id,
        .built = describe_nv_build(call, view),
    };
    journal_end_entry(journal, entry);
}

void nv_record_input(void *user, uint32_t geometry, enum input_role role,
                     const struct buffer_facts *facts)
{
    struct build_call *call = user;
    struct journal_input *input = journal_begin_inputs(call->journal);
    if (!input || !journal_notes_buffer(call->journal, facts->id))
        return;
    *input = journal_input_of(role, COMMAND_NV, call->view.command_buffer.build_index, facts->id);
    input->buffer = facts->handle;
    input->geometry = geometry;
    journal_end_inputs(call->journal, input + 1);
}

static void run_checks(struct build_call *call, struct nv_call_view *view)
{
    static const struct check_hooks hooks = {.found = build_call_found,
                                             .of_another_device = build_call_of_another_device};
    struct check_context context = {
        .hooks = &hooks,
        .recorder = call->journal ? call->device->build_recorder : NULL,
        .user = call,
        .level = call->device->level,
        .active = call->device->active_rules[COMMAND_NV],
        .readable = readable_cache_of_thread(),
        .resources = call->device->resources,
    };
    check_nv_build(&context, view);
    build_call_settle_journal(call);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdBuildAccelerationStructureNV(
    VkCommandBuffer commandBuffer, const VkAccelerationStructureInfoNV *pInfo,
    VkBuffer instanceData, VkDeviceSize instanceOffset, VkBool32 update,
    VkAccelerationStructureNV dst, VkAccelerationStructureNV src, VkBuffer scratch,
    VkDeviceSize scratchOffset)
{
    struct layer_device *device = layer_find_build_device(commandBuffer);
    struct build_call call;
    if (!device) {
        build_call_report_command_buffer(COMMAND_NV, commandBuffer);
        return;
    }
    build_call_start_recorded(&call, device, COMMAND_NV, commandBuffer);
    struct nv_call_view view = {
        .call = &call.view,
        .info_argument = pInfo,
        .instance_data = instanceData,
        .instance_offset = instanceOffset,
        .update = update != VK_FALSE,
        .dst = dst,
        .src = src,
        .scratch = scratch,
        .scratch_offset = scratchOffset,
    };
    run_checks(&call, &view);
    if (call.skip)
        return;
    build_call_count_builds(&call, 1);
    device->vk.CmdBuildAccelerationStructureNV(commandBuffer, pInfo, instanceData, instanceOffset,
                                               update, dst, src, scratch, scratchOffset);
}
