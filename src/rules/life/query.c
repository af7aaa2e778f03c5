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

/* ---- the pool */

static struct value pool_of(const struct query_view *query)
{
    return object(VK_OBJECT_TYPE_QUERY_POOL, handle_number(query->pool.handle));
}

/* If queryType is invalid, the pool cannot match it. */
bool query_pool_has_the_query_type(const struct query_view *query, struct finding *finding)
{
    return query->pool.alive != YES || query->pool.type == query->type ||
           !is_of_command(query->call->command, query->type) ||
           violated(finding, "queryPool", "{} was created with queryType {}, not {}",
                    pool_of(query), query_type(query->pool.type), query_type(query->type));
}

static const char *count_parameter(const struct query_view *query)
{
    return query->call->command == COMMAND_CmdWriteMicromapsPropertiesEXT
               ? "micromapCount"
               : "accelerationStructureCount";
}

bool queries_are_in_the_pool(const struct query_view *query, struct finding *finding)
{
    return query->pool.alive != YES ||
           (uint64_t)query->first_query + query->count <= query->pool.count ||
           violated(finding, "firstQuery", "{} plus {} {} exceeds the queryCount of {} ({})",
                    number(query->first_query), phrase(count_parameter(query)),
                    number(query->count), pool_of(query), number(query->pool.count));
}

bool read_queries_are_initialized(const struct read_queries_view *read_queries,
                                  struct finding *finding)
{
    return !read_queries->is_uninitialized ||
           violated(finding, "queryPool",
                    "{} has query {}, which no command has reset or written since the pool was "
                    "created",
                    object(VK_OBJECT_TYPE_QUERY_POOL, handle_number(read_queries->pool)),
                    number(read_queries->number));
}

/* ---- the structures' types */

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

/* ---- the results on the host */

static bool is_of_micromaps(VkQueryType type)
{
    return is_of_command(COMMAND_WriteMicromapsPropertiesEXT, type);
}

static bool stride_is_aligned(const struct query_view *query, struct finding *finding)
{
    return query->stride % sizeof(VkDeviceSize) == 0 ||
           violated(finding, "stride", "{} is not a multiple of {}, with queryType {}",
                    number(query->stride), count_of(sizeof(VkDeviceSize), "byte"),
                    query_type(query->type));
}

/*
 * Sizes of 0, and less than all results take, have ids of their own. Where pData lies is not
 * judged: a valid pointer is one that the host's processor can read through, and processors of
 * today read a VkDeviceSize at any address.
 */
static bool data_is_a_size(const struct query_view *query, struct finding *finding)
{
    return !query->data_size || query->data_size >= sizeof(VkDeviceSize) ||
           violated(finding, "pData", "points to {}, less than a VkDeviceSize takes",
                    count_of(query->data_size, "byte")) ||
           (!query_data_holds_all_results(query, NULL) &&
            is_reported_with(finding, RULE_query_data_holds_all_results));
}

bool size_query_stride_is_aligned(const struct query_view *query, struct finding *finding)
{
    return query->type != VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR ||
           stride_is_aligned(query, finding);
}

bool size_query_data_is_a_size(const struct query_view *query, struct finding *finding)
{
    return query->type != VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR ||
           data_is_a_size(query, finding);
}

bool pointers_query_stride_is_aligned(const struct query_view *query, struct finding *finding)
{
    return query->type !=
               VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR ||
           stride_is_aligned(query, finding);
}

bool pointers_query_data_is_a_size(const struct query_view *query, struct finding *finding)
{
    return query->type !=
               VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR ||
           data_is_a_size(query, finding);
}

bool compacted_size_query_stride_is_aligned(const struct query_view *query, struct finding *finding)
{
    return query->type != VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR ||
           stride_is_aligned(query, finding);
}

bool compacted_size_query_data_is_a_size(const struct query_view *query, struct finding *finding)
{
    return query->type != VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR ||
           data_is_a_size(query, finding);
}

bool serialization_size_query_stride_is_aligned(const struct query_view *query,
                                                struct finding *finding)
{
    return query->type != VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR ||
           stride_is_aligned(query, finding);
}

bool serialization_size_query_data_is_a_size(const struct query_view *query,
                                             struct finding *finding)
{
    return query->type != VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR ||
           data_is_a_size(query, finding);
}

bool micromap_query_stride_is_aligned(const struct query_view *query, struct finding *finding)
{
    return !is_of_micromaps(query->type) || stride_is_aligned(query, finding);
}

bool micromap_query_data_is_a_size(const struct query_view *query, struct finding *finding)
{
    return !is_of_micromaps(query->type) || data_is_a_size(query, finding);
}

bool query_data_holds_all_results(const struct query_view *query, struct finding *finding)
{
    size_t needed;
    const bool overflows = __builtin_mul_overflow(query->stride, (size_t)query->count, &needed);
    return (!overflows && needed <= query->data_size) ||
           violated(finding, "dataSize", "{} is less than {} times stride {}",
                    number(query->data_size), number(query->count), number(query->stride));
}

/* ---- the structures */

static struct value buffer_of(const struct life_object *object_)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(object_->buffer));
}

static bool is_backed(const struct life_object *object, struct finding *finding)
{
    if (object->backed != NO)
        return true;
    if (!object->buffer)
        return violated(finding, "", "{} is not bound to memory, or its memory was freed",
                        life_object_value(object));
    return violated_by_buffer_of(object, finding, "");
}

bool queried_structure_is_backed(const struct queried_view *queried, struct finding *finding)
{
    return is_backed(&queried->object, finding) ||
           also_violates(finding, RULE_queried_structure_is_host_visible);
}

bool queried_structure_is_host_visible(const struct queried_view *queried, struct finding *finding)
{
    const struct life_object *object = &queried->object;
    if (object->host_visible == NO)
        return violated(finding, "",
                        "{} lies in {}, which is bound to memory without "
                        "VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT",
                        life_object_value(object), buffer_of(object));
    return is_backed(object, finding) ||
           is_reported_with(finding, RULE_queried_structure_is_backed);
}

bool queried_structure_has_one_memory_instance(const struct queried_view *queried,
                                               struct finding *finding)
{
    const struct life_object *object = &queried->object;
    return object->multi_instance != YES ||
           violated(finding, "",
                    "{} lies in {}, which is bound to memory that was allocated with multiple "
                    "instances",
                    life_object_value(object), buffer_of(object));
}

bool queried_structure_was_created_with_a_buffer(const struct queried_view *queried,
                                                 struct finding *finding)
{
    return !queried->object.by_address ||
           violated(finding, "",
                    "{} was created with vkCreateAccelerationStructure2KHR, not "
                    "vkCreateAccelerationStructureKHR",
                    life_object_value(&queried->object));
}
