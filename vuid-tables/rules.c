/* SPDX-License-Identifier: Apache-2.0 */
/* The rows as a table, and the maps between ids and rows. */
#include "vuid-tables/rules.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "structure_columns.h"

/* The registry has an id of this command, 11700, under the name of another one. */
#define COLUMNS_OF_vkCmdCopyAccelerationStructureToMemoryKHR(vuid_)                                \
    .vuid[COMMAND_CmdCopyMemoryToAccelerationStructureKHR] = (vuid_),

const struct rule_info rule_infos[RULE_COUNT] = {
#define DEVICE(tail) .vuid[COMMAND_DEVICE] = VUID_vkCmdBuildAccelerationStructuresKHR_##tail,
#define INDIRECT(tail)                                                                             \
    .vuid[COMMAND_INDIRECT] = VUID_vkCmdBuildAccelerationStructuresIndirectKHR_##tail,
#define HOST(tail) .vuid[COMMAND_HOST] = VUID_vkBuildAccelerationStructuresKHR_##tail,
#define NV(tail) .vuid[COMMAND_NV] = VUID_vkCmdBuildAccelerationStructureNV_##tail,
#define OWN_WARNING(command, name) .vuid[COMMAND_##command] = WARNING_##name,
#define SHARED_WARNING(command, name) OWN_WARNING(command, name)
#define IN_NV(structure, tail) .vuid[COMMAND_NV] = VUID_##structure##_##tail,
#define INFO_NV(structure, tail)                                                                   \
    IN_NV(structure, tail).vuid[COMMAND_CreateAccelerationStructureNV] = VUID_##structure##_##tail,
#define IN(structure, tail)                                                                        \
    .vuid[COMMAND_DEVICE] = VUID_##structure##_##tail,                                             \
    .vuid[COMMAND_INDIRECT] = VUID_##structure##_##tail,                                           \
    .vuid[COMMAND_HOST] = VUID_##structure##_##tail,                                               \
    .vuid[COMMAND_NV] = VUID_##structure##_##tail,
#define SIZED(structure, tail)                                                                     \
    IN(structure, tail).vuid[COMMAND_GetAccelerationStructureBuildSizesKHR] =                      \
        VUID_##structure##_##tail,
#define OF(command, tail) .vuid[COMMAND_##command] = VUID_vk##command##_##tail,
#define WITHIN(structure, tail) COLUMNS_OF_##structure(VUID_##structure##_##tail)
#define HINT(hint_) .hint = hint_,
#define RULE(subject_, name_, level_, ids)                                                         \
    [RULE_##name_] = {.name = #name_, .subject = #subject_, .level = LEVEL_##level_, ids},
#define PENDING(name_, level_, waits_for_, ids)                                                    \
    [RULE_##name_] = {.name = #name_, .waits_for = waits_for_, .level = LEVEL_##level_, ids},
#include "vuid-tables/rules.def"
};

/* A switch without default: an id without a row, or with two, does not compile. */
enum rule rule_of_vuid(enum vuid vuid)
{
    switch (vuid) {
#define DEVICE(tail) case VUID_vkCmdBuildAccelerationStructuresKHR_##tail:
#define INDIRECT(tail) case VUID_vkCmdBuildAccelerationStructuresIndirectKHR_##tail:
#define HOST(tail) case VUID_vkBuildAccelerationStructuresKHR_##tail:
#define NV(tail) case VUID_vkCmdBuildAccelerationStructureNV_##tail:
#define OWN_WARNING(command, name) case WARNING_##name:
#define SHARED_WARNING(command, name)
#define IN(structure, tail) case VUID_##structure##_##tail:
#define IN_NV(structure, tail) case VUID_##structure##_##tail:
#define INFO_NV(structure, tail) case VUID_##structure##_##tail:
#define SIZED(structure, tail) case VUID_##structure##_##tail:
#define OF(command, tail) case VUID_vk##command##_##tail:
#define WITHIN(structure, tail) case VUID_##structure##_##tail:
#define HINT(hint)
#define RULE(subject, name, level, ids) ids return RULE_##name;
#define PENDING(name, level, waits_for, ids) ids return RULE_##name;
#include "vuid-tables/rules.def"
    case VUID_NONE:
    case VUID_COUNT:
    case MESSAGE_ID_COUNT:
        break;
    }
    return RULE_COUNT;
}

static const struct {
    const char *id;
    enum vuid current;
    const char *field;
} retired[] = {
#define RETIRED(id, current, field) {id, VUID_##current, field},
#include "vuid-tables/retired.def"
#undef RETIRED
};

const char *vuid_of_retired_row(unsigned row)
{
    return retired[row].id;
}

const char *vuid_retired(enum vuid vuid, unsigned n)
{
    for (size_t i = 0; i < sizeof(retired) / sizeof(retired[0]); i++)
        if (retired[i].current == vuid && n-- == 0)
            return retired[i].id;
    return NULL;
}

/* An id is "VUID-", the command or structure, and "-...". An id of a structure is of any command.
 */
static bool is_of_command(const char *id, enum build_command command)
{
    const char *scope = id + strlen("VUID-"), *name = build_command_name(command);
    size_t length = strlen(name);
    return strncmp(scope, "vk", 2) != 0 ||
           (strncmp(scope, name, length) == 0 && scope[length] == '-');
}

const char *vuid_listed(enum vuid vuid, enum build_command command, const char *field)
{
    for (size_t i = 0; i < sizeof(retired) / sizeof(retired[0]); i++)
        if (retired[i].current == vuid && is_of_command(retired[i].id, command) &&
            strncmp(field, retired[i].field, strlen(retired[i].field)) == 0)
            return retired[i].id;
    return NULL;
}

const char *build_command_name(enum build_command command)
{
    static const char *const names[COMMAND_COUNT] = {
        [COMMAND_DEVICE] = "vkCmdBuildAccelerationStructuresKHR",
        [COMMAND_INDIRECT] = "vkCmdBuildAccelerationStructuresIndirectKHR",
        [COMMAND_HOST] = "vkBuildAccelerationStructuresKHR",
        [COMMAND_NV] = "vkCmdBuildAccelerationStructureNV",
#define COMMAND(name) [COMMAND_##name] = "vk" #name,
#include "vuid-tables/commands.def"
    };
    return command < COMMAND_COUNT ? names[command] : "";
}

bool command_is_recorded(enum build_command command)
{
    return strncmp(build_command_name(command), "vkCmd", strlen("vkCmd")) == 0;
}

const char *level_name(enum level level)
{
    switch (level) {
    case LEVEL_PARAMETERS:
        return "parameters";
    case LEVEL_STATE:
        return "state";
    case LEVEL_EXECUTION:
        return "execution";
    case LEVEL_CONTENT:
        return "content";
    case LEVEL_COUNT:
        break;
    }
    return "-";
}
