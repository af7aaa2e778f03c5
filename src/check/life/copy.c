/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of copies of structures and micromaps. */
#include "arguments.h"
#include "src/check/life/life.h"
#include "src/view/names.h"

static VkCopyAccelerationStructureModeKHR mode_of_micromap(VkCopyMicromapModeEXT mode)
{
    switch (mode) {
    case VK_COPY_MICROMAP_MODE_CLONE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR;
    case VK_COPY_MICROMAP_MODE_SERIALIZE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR;
    case VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR;
    case VK_COPY_MICROMAP_MODE_COMPACT_EXT:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    default:
        return VK_COPY_ACCELERATION_STRUCTURE_MODE_MAX_ENUM_KHR;
    }
}

static void set_mode(struct copy_view *copy, VkCopyAccelerationStructureModeKHR mode)
{
    copy->mode = mode;
    copy->given_mode = copy_mode(mode);
}

static void set_objects(struct walk *walk, struct copy_view *copy, VkObjectType type, uint64_t src,
                        uint64_t dst)
{
    copy->src = check_find_object(walk->context, type, src);
    copy->dst = check_find_object(walk->context, type, dst);
}

static void view_copy(struct walk *walk, struct copy_view *copy,
                      const VkCopyAccelerationStructureInfoKHR *info)
{
    set_mode(copy, info->mode);
    set_objects(walk, copy, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                (uint64_t)(uintptr_t)info->src, (uint64_t)(uintptr_t)info->dst);
}

static void view_micromap_copy(struct walk *walk, struct copy_view *copy,
                               const VkCopyMicromapInfoEXT *info)
{
    copy->mode = mode_of_micromap(info->mode);
    copy->given_mode = micromap_copy_mode(info->mode);
    set_objects(walk, copy, VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)(uintptr_t)info->src,
                (uint64_t)(uintptr_t)info->dst);
}

static void view_nv_copy(struct walk *walk, struct copy_view *copy,
                         const struct arguments_of_CmdCopyAccelerationStructureNV *arguments)
{
    set_mode(copy, arguments->mode);
    set_objects(walk, copy, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                (uint64_t)(uintptr_t)arguments->src, (uint64_t)(uintptr_t)arguments->dst);
}

/* Makes the view if the parameters are readable. Returns false if they are not. */
static bool view_arguments(struct walk *walk, const struct call_view *call, struct copy_view *copy)
{
    const void *pointer = NULL;
    switch ((int)call->command) {
    case COMMAND_CmdCopyAccelerationStructureNV:
        view_nv_copy(walk, copy, call->arguments);
        return true;
    case COMMAND_CmdCopyMicromapEXT:
    case COMMAND_CopyMicromapEXT:
        pointer = check_info_argument(walk->context, call, sizeof(VkCopyMicromapInfoEXT));
        if (pointer)
            view_micromap_copy(walk, copy, pointer);
        return pointer != NULL;
    default:
        pointer =
            check_info_argument(walk->context, call, sizeof(VkCopyAccelerationStructureInfoKHR));
        if (pointer)
            view_copy(walk, copy, pointer);
        return pointer != NULL;
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
