/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the view of an object that is about to be destroyed. */
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
    case COMMAND_DestroyBuffer:
        return VK_OBJECT_TYPE_BUFFER;
    case COMMAND_FreeMemory:
        return VK_OBJECT_TYPE_DEVICE_MEMORY;
    default:
        return VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    }
}

static struct life_object find_destroyed_object(struct check_context *context, VkObjectType type,
                                                uint64_t handle)
{
    return type == VK_OBJECT_TYPE_BUFFER || type == VK_OBJECT_TYPE_DEVICE_MEMORY
               ? (struct life_object){.object_type = type, .handle = handle}
               : check_find_object(context, type, handle);
}

static struct used_object used_object_of(struct check_context *context,
                                         const struct life_object *object)
{
    struct buffer_facts buffer;
    if (object->object_type == VK_OBJECT_TYPE_DEVICE_MEMORY)
        return (struct used_object){.memory = (VkDeviceMemory)(uintptr_t)object->handle,
                                    .may_hold_structures = true};
    if (object->object_type != VK_OBJECT_TYPE_BUFFER)
        return (struct used_object){.id = object->id};
    resources_look_up_buffer(context->resources, (VkBuffer)(uintptr_t)object->handle, &buffer);
    return (struct used_object){.buffer_id = buffer.id,
                                .may_hold_structures =
                                    buffer.usage &
                                    VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR};
}

/* The commands have the same parameters, up to the type of the handle. */
void check_destroyed(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_DestroyAccelerationStructureKHR *arguments = call->arguments;
    struct check_context *context = walk->context;
    const struct location location = check_argument(call, NULL);
    struct pending_use use;
    struct destroyed_view destroyed = {
        .call = call,
        .object = find_destroyed_object(context, type_of_command(call->command),
                                        handle_number(arguments->accelerationStructure)),
        .gets_callbacks = arguments->pAllocator != NULL,
    };
    if (context->level >= LEVEL_STATE && destroyed.object.id)
        destroyed.has_callbacks = resources_has_callbacks(
            context->resources, kind_of(destroyed.object.object_type), destroyed.object.handle);
    if (context->level >= LEVEL_EXECUTION) {
        const struct used_object used = used_object_of(context, &destroyed.object);
        if (context->hooks->find_use(context->user, &used, &use))
            destroyed.use = &use;
    }
    walk_destroyed(walk, &destroyed, &location);
}
