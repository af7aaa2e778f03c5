/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about queries of properties of structures and micromaps. */
#include "src/rules/predicates.h"
#include "src/view/names.h"

static bool is_of_structures(VkQueryType type)
{
    return type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR ||
           type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR ||
           type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR ||
           type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR;
}

static bool is_of_command(enum build_command command, VkQueryType type)
{
    switch ((int)command) {
    case COMMAND_CmdWriteAccelerationStructuresPropertiesNV:
        return type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV;
    case COMMAND_CmdWriteMicromapsPropertiesEXT:
    case COMMAND_WriteMicromapsPropertiesEXT:
        return type == VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT ||
               type == VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT;
    default:
        return is_of_structures(type);
    }
}

bool query_type_is_of_the_command(const struct query_view *query, struct finding *finding)
{
    return is_of_command(query->call->command, query->type) ||
           violated(finding, "queryType", "{} is no property that this command writes",
                    query_type(query->type));
}

/* A structure of the generic type may have been built as either. */
bool pointers_are_queried_of_top_levels(const struct queried_view *queried, struct finding *finding)
{
    const struct life_object *object = &queried->object;
    return queried->query->type !=
               VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR ||
           !object->details_known || object->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ||
           object->type == VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR ||
           violated(finding, "",
                    "{} was created with type {}, and "
                    "VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR "
                    "is for top-level structures",
                    life_object_value(object),
                    accel_type((VkAccelerationStructureTypeKHR)object->type));
}
