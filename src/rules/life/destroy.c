/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the destruction of structures and micromaps, and of what they and builds use. */
#include "src/rules/predicates.h"

/* Whether two sets of callbacks are compatible is unknown. */
bool callbacks_of_creation_are_given(const struct destroyed_view *destroyed,
                                     struct finding *finding)
{
    return destroyed->has_callbacks != YES || destroyed->gets_callbacks ||
           violated(finding, "pAllocator", "is NULL, and {} was created with VkAllocationCallbacks",
                    life_object_value(&destroyed->object));
}

bool callbacks_are_those_of_creation(const struct destroyed_view *destroyed,
                                     struct finding *finding)
{
    return destroyed->has_callbacks != NO || !destroyed->gets_callbacks ||
           violated(finding, "pAllocator",
                    "is not NULL, and {} was created without VkAllocationCallbacks",
                    life_object_value(&destroyed->object));
}

static const char *parameter_of(VkObjectType type)
{
    switch ((int)type) {
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        return "micromap";
    case VK_OBJECT_TYPE_BUFFER:
        return "buffer";
    case VK_OBJECT_TYPE_DEVICE_MEMORY:
        return "memory";
    default:
        return "accelerationStructure";
    }
}

/* Which structure an instance refers to is known once the build has executed. */
static bool no_instance_referred_to_it(const struct destroyed_view *destroyed,
                                       struct finding *finding)
{
    const struct pending_instance *instance = destroyed->instance;
    return !instance ||
           violated(
               finding, "accelerationStructure",
               "{} was destroyed while instance {} of {} referred to it by {}, and that build "
               "had not completed as far as the application had observed",
               destroyed_object(destroyed->object.object_type, destroyed->object.handle,
                                destroyed->object.id),
               number(instance->index), phrase(build_command_name(instance->command)),
               address_of_missing(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, instance->reference));
}

bool destroyed_object_is_not_in_use(const struct destroyed_view *destroyed, struct finding *finding)
{
    const struct pending_use *use = destroyed->use;
    if (!use)
        return no_instance_referred_to_it(destroyed, finding);
    return violated(finding, parameter_of(destroyed->object.object_type),
                    "{} is used by {} in {}, which was submitted to {} (submission {}) and has not "
                    "completed as far as the application has observed",
                    life_object_value(&destroyed->object), phrase(build_command_name(use->command)),
                    object(VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(use->command_buffer)),
                    object(VK_OBJECT_TYPE_QUEUE, handle_number(use->queue)),
                    number(use->submission)) ||
           (use->timeout &&
            remarks(finding,
                    "A wait of the host since then returned VK_TIMEOUT: its timeout was {} ns",
                    number(use->timeout)));
}
