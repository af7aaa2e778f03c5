/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of copies of structures and micromaps. */
#include "arguments.h"
#include "src/check/assemble/views.h"
#include "src/check/life/life.h"
#include "src/view/names.h"

/* Two versions of VK_UUID_SIZE bytes and three 64-bit sizes or counts. */
enum { SERIALIZED_HEADER_SIZE = 2 * VK_UUID_SIZE + 3 * sizeof(uint64_t) };

static void set_mode(struct copy_view *copy, VkCopyAccelerationStructureModeKHR mode)
{
    copy->mode = mode;
    copy->given_mode = copy_mode(mode);
}

static void set_micromap_mode(struct copy_view *copy, VkCopyMicromapModeEXT mode)
{
    copy->mode = copy_mode_of_micromap(mode);
    copy->given_mode = micromap_copy_mode(mode);
}

static struct life_object find_named_object(struct walk *walk, VkObjectType type,
                                            const void *handle)
{
    return check_find_object(walk->context, type, handle_number(handle));
}

static void view_copy(struct walk *walk, struct copy_view *copy,
                      const VkCopyAccelerationStructureInfoKHR *info)
{
    set_mode(copy, info->mode);
    copy->src = find_named_object(walk, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, info->src);
    copy->dst = find_named_object(walk, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, info->dst);
}

static void view_micromap_copy(struct walk *walk, struct copy_view *copy,
                               const VkCopyMicromapInfoEXT *info)
{
    set_micromap_mode(copy, info->mode);
    copy->src = find_named_object(walk, VK_OBJECT_TYPE_MICROMAP_EXT, info->src);
    copy->dst = find_named_object(walk, VK_OBJECT_TYPE_MICROMAP_EXT, info->dst);
}

static void view_nv_copy(struct walk *walk, struct copy_view *copy,
                         const struct arguments_of_CmdCopyAccelerationStructureNV *arguments)
{
    set_mode(copy, arguments->mode);
    copy->src = find_named_object(walk, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, arguments->src);
    copy->dst = find_named_object(walk, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV, arguments->dst);
}

/* Both unions of addresses have the same members. */
static void view_memory(struct walk *walk, struct copy_view *copy, enum copy_direction direction,
                        uint64_t address)
{
    copy->direction = direction;
    copy->address = address;
    copy->is_on_host = !command_is_recorded(copy->call->command);
    if (copy->is_on_host)
        copy->memory_unreadable = !host_memory_is_there(
            walk->context, (const void *)(uintptr_t)address, SERIALIZED_HEADER_SIZE);
    else if (walk->context->level >= LEVEL_STATE)
        resources_look_up_address(walk->context->resources, address, &copy->memory);
}

static void view_serialization(struct walk *walk, struct copy_view *copy,
                               const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    set_mode(copy, info->mode);
    copy->src = find_named_object(walk, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, info->src);
    view_memory(walk, copy, COPY_TO_MEMORY, info->dst.deviceAddress);
}

static void view_deserialization(struct walk *walk, struct copy_view *copy,
                                 const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    set_mode(copy, info->mode);
    copy->dst = find_named_object(walk, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, info->dst);
    view_memory(walk, copy, COPY_FROM_MEMORY, info->src.deviceAddress);
    check_view_serialized(walk->context, copy);
}

static void view_micromap_serialization(struct walk *walk, struct copy_view *copy,
                                        const VkCopyMicromapToMemoryInfoEXT *info)
{
    set_micromap_mode(copy, info->mode);
    copy->src = find_named_object(walk, VK_OBJECT_TYPE_MICROMAP_EXT, info->src);
    view_memory(walk, copy, COPY_TO_MEMORY, info->dst.deviceAddress);
}

static void view_micromap_deserialization(struct walk *walk, struct copy_view *copy,
                                          const VkCopyMemoryToMicromapInfoEXT *info)
{
    set_micromap_mode(copy, info->mode);
    copy->dst = find_named_object(walk, VK_OBJECT_TYPE_MICROMAP_EXT, info->dst);
    view_memory(walk, copy, COPY_FROM_MEMORY, info->src.deviceAddress);
    check_view_serialized(walk->context, copy);
}

/* Makes the view if the parameters are readable. Returns false if they are not. */
#define VIEW_INFO(view, info_type)                                                                 \
    {                                                                                              \
        const void *info = check_info_argument(walk->context, call, sizeof(info_type));            \
        if (info)                                                                                  \
            view(walk, copy, info);                                                                \
        return info != NULL;                                                                       \
    }

static bool view_arguments(struct walk *walk, const struct call_view *call, struct copy_view *copy)
{
    switch ((int)call->command) {
    case COMMAND_CmdCopyAccelerationStructureNV:
        view_nv_copy(walk, copy, call->arguments);
        return true;
    case COMMAND_CmdCopyMicromapEXT:
    case COMMAND_CopyMicromapEXT:
        VIEW_INFO(view_micromap_copy, VkCopyMicromapInfoEXT)
    case COMMAND_CmdCopyAccelerationStructureToMemoryKHR:
    case COMMAND_CopyAccelerationStructureToMemoryKHR:
        VIEW_INFO(view_serialization, VkCopyAccelerationStructureToMemoryInfoKHR)
    case COMMAND_CmdCopyMemoryToAccelerationStructureKHR:
    case COMMAND_CopyMemoryToAccelerationStructureKHR:
        VIEW_INFO(view_deserialization, VkCopyMemoryToAccelerationStructureInfoKHR)
    case COMMAND_CmdCopyMicromapToMemoryEXT:
    case COMMAND_CopyMicromapToMemoryEXT:
        VIEW_INFO(view_micromap_serialization, VkCopyMicromapToMemoryInfoEXT)
    case COMMAND_CmdCopyMemoryToMicromapEXT:
    case COMMAND_CopyMemoryToMicromapEXT:
        VIEW_INFO(view_micromap_deserialization, VkCopyMemoryToMicromapInfoEXT)
    case COMMAND_CmdCopyAccelerationStructureKHR:
    case COMMAND_CopyAccelerationStructureKHR:
        VIEW_INFO(view_copy, VkCopyAccelerationStructureInfoKHR)
    default:
        return false;
    }
}

void check_copy(struct walk *walk, const struct call_view *call)
{
    struct copy_view copy = {.call = call};
    const bool is_nv = call->command == COMMAND_CmdCopyAccelerationStructureNV;
    const struct location location = check_argument(call, is_nv ? NULL : "pInfo");
    if (view_arguments(walk, call, &copy))
        walk_copy(walk, &copy, &location);
}
