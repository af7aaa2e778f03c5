/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the view of a structure or micromap that is about to be destroyed. */
#include "arguments.h"
#include "src/check/life/life.h"

static enum resource_kind kind_of(VkObjectType type)
{
    switch ((int)type) {
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        return RESOURCE_MICROMAP;
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV:
        return RESOURCE_ACCEL_NV;
    default:
        return RESOURCE_ACCEL;
    }
}

static VkObjectType type_of_command(enum build_command command)
{
    switch ((int)command) {
    case COMMAND_DestroyMicromapEXT:
        return VK_OBJECT_TYPE_MICROMAP_EXT;
    case COMMAND_DestroyAccelerationStructureNV:
        return VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV;
    default:
        return VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    }
}

/* The three commands have the same parameters, up to the type of the handle. */
void check_destroyed(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_DestroyAccelerationStructureKHR *arguments = call->arguments;
    const struct check_context *context = walk->context;
    const struct location location = check_argument(call, NULL);
    struct pending_use use;
    struct destroyed_view destroyed = {
        .call = call,
        .object = check_find_object(walk->context, type_of_command(call->command),
                                    (uint64_t)(uintptr_t)arguments->accelerationStructure),
        .gets_callbacks = arguments->pAllocator != NULL,
    };
    if (context->level >= LEVEL_STATE)
        destroyed.has_callbacks = resources_has_callbacks(
            context->resources, kind_of(destroyed.object.object_type), destroyed.object.handle);
    if (context->level >= LEVEL_EXECUTION && destroyed.object.id &&
        context->hooks->find_use(context->user, destroyed.object.id, &use))
        destroyed.use = &use;
    walk_destroyed(walk, &destroyed, &location);
}
