/* SPDX-License-Identifier: Apache-2.0 */
/* The rules as data: the ids, the rule that validates each id, and its level.
 *
 * The rows are in rows/; rules.def includes them. A row is one of
 *
 *     RULE(subject, name, LEVEL, ids)          validated by the predicate `name`
 *     PENDING(name, LEVEL, "waits for", ids)   not validated yet
 *
 * LEVEL is an enum level without its prefix. `ids` lists the valid-usage ids that the rule
 * validates:
 *
 *     DEVICE(tail) INDIRECT(tail) HOST(tail) NV(tail)   an id of that build command
 *     OF(command, tail)         an id of another command, such as OF(CopyMicromapEXT, tail)
 *     EACH(tail)                the id of each other command that has one of that tail
 *     IN(structure, tail)       an id of a structure, for all build commands
 *     SIZED(structure, tail)    the same, and for vkGetAccelerationStructureBuildSizesKHR: the
 *                               structure decides the sizes of a build
 *     IN_NV(structure, tail)    an id of a structure that only the NV command takes
 *     INFO_NV(structure, tail)  the same, and for vkCreateAccelerationStructureNV, which takes the
 *                               structure of the builds to come
 *     WITHIN(structure, tail)   an id of a structure that other commands take, for all of these
 *     OWN_WARNING(COMMAND, name)   an id of the layer's own (warnings.def), reported as a warning
 *     SHARED_WARNING(COMMAND, name)   the same for any command, if another command or row has the
 *                               id, too
 *
 * The last column is optional: HINT("what to do") is the second sentence of a message, such as
 * HINT("Create the VkBuffer with VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT."). It is an imperative that
 * is right whenever the row is violated; it ends with a full stop, names no id, and has at most
 * HINT_LENGTH characters.
 */
#ifndef ASSAY_VUID_TABLES_RULES_H
#define ASSAY_VUID_TABLES_RULES_H

#include <stdbool.h>
#include <stdint.h>

#include "shared_columns.h"

/* The commands: the columns of a row. The build commands come first. */
enum build_command {
    COMMAND_DEVICE,   /* vkCmdBuildAccelerationStructuresKHR */
    COMMAND_INDIRECT, /* vkCmdBuildAccelerationStructuresIndirectKHR */
    COMMAND_HOST,     /* vkBuildAccelerationStructuresKHR */
    COMMAND_NV,       /* vkCmdBuildAccelerationStructureNV */
/* All others about acceleration structures and micromaps, such as
 * COMMAND_CopyAccelerationStructureKHR. */
#define COMMAND(name) COMMAND_##name,
#include "vuid-tables/commands.def"
    COMMAND_COUNT,
    BUILD_COMMAND_COUNT = COMMAND_NV + 1,
};

/* The state that a rule needs. Each level includes those before it. */
enum level {
    LEVEL_PARAMETERS, /* the structures of the call */
    LEVEL_STATE,      /* created objects, bindings, features, limits, sizes */
    LEVEL_EXECUTION,  /* the structures as they are when the command executes */
    LEVEL_CONTENT,    /* the input data itself */
    LEVEL_COUNT,
};

enum { HINT_LENGTH = 160 };

enum vuid {
    VUID_NONE,
#define VUID(scope, tail) VUID_##scope##_##tail,
#include "implicit_vuids.def"
#include "vuid-tables/vuids.def"
#undef VUID
    VUID_COUNT,
/* Ids of the layer's own: the registry lacks them, and scripts/coverage does not count them. */
#define WARNING(name, id) WARNING_##name,
#include "vuid-tables/warnings.def"
#undef WARNING
    MESSAGE_ID_COUNT,
};

/* Whether an id is one of the layer's own. */
static inline bool vuid_is_warning(enum vuid vuid)
{
    return vuid > VUID_COUNT;
}

enum rule {
#define RULE(subject, name, level, ids) RULE_##name,
#define PENDING(name, level, waits_for, ids) RULE_##name,
#include "vuid-tables/rules.def"
    RULE_COUNT,
};

/* The build commands whose ids a rule validates, as bits 1 << COMMAND_... */
enum {
#define DEVICE(tail) | 1 << COMMAND_DEVICE
#define INDIRECT(tail) | 1 << COMMAND_INDIRECT
#define HOST(tail) | 1 << COMMAND_HOST
#define NV(tail) | 1 << COMMAND_NV
#define OWN_WARNING(command, name)                                                                 \
    | (COMMAND_##command < BUILD_COMMAND_COUNT) << COMMAND_##command % BUILD_COMMAND_COUNT
#define SHARED_WARNING(command, name) OWN_WARNING(command, name)
#define IN(structure, tail) | ((1 << BUILD_COMMAND_COUNT) - 1)
#define IN_NV(structure, tail) | 1 << COMMAND_NV
#define INFO_NV(structure, tail) IN_NV(structure, tail)
#define SIZED(structure, tail) IN(structure, tail)
#define OF(command, tail)
#define WITHIN(structure, tail)
#define HINT(hint)
#define RULE(subject, name, level, ids) COMMANDS_OF_##name = 0 ids,
#define PENDING(name, level, waits_for, ids) COMMANDS_OF_##name = 0 ids,
#include "vuid-tables/rules.def"
};

/* One row. */
struct rule_info {
    const char *name;
    const char *subject;   /* NULL for PENDING */
    const char *waits_for; /* NULL for RULE */
    enum level level;
    const char *hint; /* NULL: none */
    /* The id by command; VUID_NONE if the command has no such id. */
    uint16_t vuid[COMMAND_COUNT];
};

extern const struct rule_info rule_infos[RULE_COUNT];

/* Returns the rule that validates an id. The compiler checks that each id has one. */
enum rule rule_of_vuid(enum vuid vuid);

/* The rows of retired.def, which may have an id twice. */
enum {
    RETIRED_COUNT = 0
#define RETIRED(id, current, field) +1
#include "vuid-tables/retired.def"
#undef RETIRED
};
const char *vuid_of_retired_row(unsigned row);

/* Returns the n-th id that the registry has replaced by `vuid`, or NULL. */
const char *vuid_retired(enum vuid vuid, unsigned n);

/* Returns the retired id of a finding about a field of a call of this command; NULL: none. */
const char *vuid_listed(enum vuid vuid, enum build_command command, const char *field);

/* The installed registry's text of an id; generated at build time from validusage.json. */
struct vuid_text {
    const char *id;       /* "VUID-..." */
    const char *sentence; /* plain text; "" if the registry lacks the id */
    const char *page;     /* e.g. "chapters/accelstructures.html" */
};

extern const struct vuid_text vuid_texts[MESSAGE_ID_COUNT];

/* Returns the name of a command, such as "vkCmdBuildAccelerationStructuresKHR". */
const char *build_command_name(enum build_command command);

/* Returns whether a command is recorded in command buffers: its name begins with vkCmd. */
bool command_is_recorded(enum build_command command);

/* Returns the value of setting level that names it, or "-" for LEVEL_COUNT. */
const char *level_name(enum level level);

#endif
