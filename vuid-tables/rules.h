/* SPDX-License-Identifier: Apache-2.0 */
/* The rules as data: which ids there are, which rule decides each, and from what level on.
 *
 * The rows live in rows/; rules.def includes them. A row reads
 *
 *     RULE(subject, name, LEVEL, ids)      decided by the predicate `name`
 *     PENDING(name, LEVEL, "waits for", ids)   not decided yet
 *
 * SHAPE as a level is PARAMETERS of a rule that reads nothing but the shape of its build
 * (src/state/builds/previous_shape.h): what holds of one build holds of all of its shape. LIMIT as
 * a level is STATE of a rule about that shape, or the primitive counts, and what the device
 * supports.
 *
 * and its ids are a list of DEVICE(tail) INDIRECT(tail) HOST(tail) NV(tail), one for each build
 * command whose statement it is, or IN(structure, tail) for a structure's own, which every command
 * shares; IN_NV for that of a structure that only the NV command takes. NV_WARNING(name) is an id
 * of the layer's own (warnings.def), which goes out as a warning.
 */
#ifndef ASSAY_VUID_TABLES_RULES_H
#define ASSAY_VUID_TABLES_RULES_H

#include <stdbool.h>
#include <stdint.h>

/* The build commands: the columns of a row. */
enum build_command {
    COMMAND_DEVICE,   /* vkCmdBuildAccelerationStructuresKHR */
    COMMAND_INDIRECT, /* vkCmdBuildAccelerationStructuresIndirectKHR */
    COMMAND_HOST,     /* vkBuildAccelerationStructuresKHR */
    COMMAND_NV,       /* vkCmdBuildAccelerationStructureNV */
    COMMAND_COUNT,
};

/* What has to be known to decide a rule; each level includes those before it. */
enum level {
    LEVEL_PARAMETERS, /* the structures of the call */
    LEVEL_STATE,      /* created objects, bindings, features, limits, sizes */
    LEVEL_EXECUTION,  /* what has been built by the time the command executes */
    LEVEL_CONTENT,    /* the input data itself */
    LEVEL_COUNT,
    LEVEL_SHAPE = LEVEL_PARAMETERS,
    LEVEL_LIMIT = LEVEL_STATE,
};

/* Whether a word for a level says that the rule reads the shape alone. */
enum {
    READS_SHAPE_SHAPE = 1,
    READS_SHAPE_PARAMETERS = 0,
    READS_SHAPE_STATE = 0,
    READS_SHAPE_LIMIT = 0,
    READS_SHAPE_EXECUTION = 0,
    READS_SHAPE_CONTENT = 0,
};

/* Whether a word for a level says that the rule is about what
 * vkGetAccelerationStructureBuildSizesKHR reads of a build, a geometry or a range: if it doesn't
 * hold the driver must not be asked. */
enum {
    IS_OF_SIZES_SHAPE = 1,
    IS_OF_SIZES_LIMIT = 1,
    IS_OF_SIZES_PARAMETERS = 0,
    IS_OF_SIZES_STATE = 0,
    IS_OF_SIZES_EXECUTION = 0,
    IS_OF_SIZES_CONTENT = 0,
};

enum vuid {
    VUID_NONE,
#define VUID(scope, tail) VUID_##scope##_##tail,
#include "vuid-tables/vuids.def"
#undef VUID
    VUID_COUNT,
/* Not the registry's, so they are not in scope, and not counted. */
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

/* The commands whose statement a rule is, as bits 1 << COMMAND_... */
enum {
#define DEVICE(tail) | 1 << COMMAND_DEVICE
#define INDIRECT(tail) | 1 << COMMAND_INDIRECT
#define HOST(tail) | 1 << COMMAND_HOST
#define NV(tail) | 1 << COMMAND_NV
#define NV_WARNING(name) | 1 << COMMAND_NV
#define IN(structure, tail) | ((1 << COMMAND_COUNT) - 1)
#define IN_NV(structure, tail) | 1 << COMMAND_NV
#define RULE(subject, name, level, ids) COMMANDS_OF_##name = 0 ids,
#define PENDING(name, level, waits_for, ids) COMMANDS_OF_##name = 0 ids,
#include "vuid-tables/rules.def"
};

/* One row. */
struct rule_info {
    const char *name;
    const char *subject;   /* NULL: pending */
    const char *waits_for; /* NULL: decided */
    enum level level;
    bool is_of_sizes; /* see IS_OF_SIZES_SHAPE */
    /* The id by command, VUID_NONE where the command has no such statement. */
    enum vuid vuid[COMMAND_COUNT];
};

extern const struct rule_info rule_infos[RULE_COUNT];

/* The row that decides an id. Total over the ids: the compiler checks it. */
enum rule rule_of_vuid(enum vuid vuid);

/* The n-th id that the registry has retired in favour of `vuid`, or NULL. */
const char *vuid_retired(enum vuid vuid, unsigned n);

/* The retired id that a finding about a field of a call of this command once had; NULL: none. */
const char *vuid_listed(enum vuid vuid, enum build_command command, const char *field);

/* What the installed registry says of an id; generated at build time from validusage.json. */
struct vuid_text {
    const char *id;       /* "VUID-..." */
    const char *sentence; /* plain text; "" when the registry lacks the id */
    const char *page;     /* e.g. "chapters/accelstructures.html" */
};

extern const struct vuid_text vuid_texts[MESSAGE_ID_COUNT];

/* The spec spelling of a command, e.g. "vkCmdBuildAccelerationStructuresKHR". */
const char *build_command_name(enum build_command command);

#endif
