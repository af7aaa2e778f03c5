/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of queries of properties of structures and micromaps. */
#include "arguments.h"
#include "src/check/life/life.h"
#include "src/state/commands/query_pools.h"

/* The structures of a query; their handles are 64-bit words. */
struct queried {
    const uint64_t *handles; /* of the application */
    VkObjectType type;
    const char *parameter;
};

static struct queried view_recorded(struct check_context *context, struct query_view *query)
{
    const struct arguments_of_CmdWriteAccelerationStructuresPropertiesKHR *arguments =
        query->call->arguments;
    query->count = arguments->accelerationStructureCount;
    query->type = arguments->queryType;
    if (context->level >= LEVEL_STATE)
        query_pools_facts(context->query_pools, arguments->queryPool, &query->pool);
    query->first_query = arguments->firstQuery;
    return (struct queried){.handles = (const void *)arguments->pAccelerationStructures};
}

static struct queried view_hosted(struct query_view *query)
{
    const struct arguments_of_WriteAccelerationStructuresPropertiesKHR *arguments =
        query->call->arguments;
    query->count = arguments->accelerationStructureCount;
    query->type = arguments->queryType;
    query->data_size = arguments->dataSize;
    query->data = arguments->pData;
    query->stride = arguments->stride;
    return (struct queried){.handles = (const void *)arguments->pAccelerationStructures};
}

/* The commands of one kind have the same parameters, up to the type of the handles. */
#define SAME_ARGUMENTS(a, b)                                                                       \
    _Static_assert(sizeof(struct arguments_of_##a) == sizeof(struct arguments_of_##b), #b)
SAME_ARGUMENTS(CmdWriteAccelerationStructuresPropertiesKHR,
               CmdWriteAccelerationStructuresPropertiesNV);
SAME_ARGUMENTS(CmdWriteAccelerationStructuresPropertiesKHR, CmdWriteMicromapsPropertiesEXT);
SAME_ARGUMENTS(WriteAccelerationStructuresPropertiesKHR, WriteMicromapsPropertiesEXT);

static struct queried view_arguments(struct check_context *context, struct query_view *query)
{
    enum build_command command = query->call->command;
    struct queried queried =
        command_is_recorded(command) ? view_recorded(context, query) : view_hosted(query);
    bool is_of_micromaps = command == COMMAND_CmdWriteMicromapsPropertiesEXT ||
                           command == COMMAND_WriteMicromapsPropertiesEXT;
    queried.parameter = is_of_micromaps ? "pMicromaps" : "pAccelerationStructures";
    queried.type = is_of_micromaps ? VK_OBJECT_TYPE_MICROMAP_EXT
                   : command == COMMAND_CmdWriteAccelerationStructuresPropertiesNV
                       ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                       : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    return queried;
}

void check_read_queries(struct walk *walk, const struct call_view *call)
{
    const struct arguments_of_GetQueryPoolResults *arguments = call->arguments;
    struct read_queries_view read = {.pool = arguments->queryPool};
    const struct location location = check_argument(call, NULL);
    if (walk->context->level < LEVEL_STATE)
        return;
    read.is_uninitialized =
        query_pools_find_untouched(walk->context->query_pools, arguments->queryPool,
                                   arguments->firstQuery, arguments->queryCount, &read.number);
    walk_read_queries(walk, &read, &location);
}

void check_query(struct walk *walk, const struct call_view *call)
{
    struct query_view query = {.call = call};
    struct queried all = view_arguments(walk->context, &query);
    const struct location parameters = check_argument(call, NULL);
    const uint64_t *handles =
        check_read(walk->context, all.handles, query.count * sizeof(*all.handles));
    walk_query(walk, &query, &parameters);
    for (uint32_t i = 0; handles && i < query.count; i++) {
        struct queried_view queried = {.query = &query,
                                       .index = i,
                                       .object =
                                           check_find_object(walk->context, all.type, handles[i])};
        const struct location location = check_element(call, all.parameter, i);
        walk_queried(walk, &queried, &location);
    }
}
