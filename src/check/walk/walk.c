/* SPDX-License-Identifier: Apache-2.0 */
/* Starts a walk, selects its rules and reports its findings. */
#include "src/check/walk/walk.h"

#include <string.h>

void check_select(enum build_command command, enum level level, const bool muted[MESSAGE_ID_COUNT],
                  bool active[RULE_COUNT])
{
    for (int rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *info = &rule_infos[rule];
        enum vuid vuid = info->vuid[command];
        active[rule] = info->subject && info->level <= level && vuid != VUID_NONE && !muted[vuid];
    }
}

void walk_start(struct walk *walk, struct check_context *context)
{
    walk->context = context;
    walk->findings = 0;
    walk->hides_sizes = false;
    walk->micromaps = (struct micromap_uses){0};
    walk->instances = NULL;
    walk->readers = NULL;
    walk->inputs = NULL;
    walk->source_inputs = NULL;
    walk->point = context->point;
    walk->active = context->active;
}

void walk_stop_rule(struct walk *walk, enum rule rule)
{
    if (walk->active != walk->remaining)
        memcpy(walk->remaining, walk->active, sizeof(walk->remaining));
    walk->active = walk->remaining;
    walk->remaining[rule] = false;
}

/* Returns whether vkGetAccelerationStructureBuildSizesKHR requires a rule, too: it takes the
 * structures of a build, except for the build ranges. */
static bool sizes_require(enum rule rule)
{
    return rule_infos[rule].vuid[COMMAND_GetAccelerationStructureBuildSizesKHR] != VUID_NONE;
}

void walk_report(struct walk *walk, enum rule rule, struct location location,
                 const struct finding *finding)
{
    struct check_context *context = walk->context;
    enum rule other = finding->reported_with;
    walk->findings++;
    walk->hides_sizes |= sizes_require(rule);
    if (other != RULE_COUNT && context->active[other])
        return;
    if (!context->hooks->found(context->user, rule, &location, finding))
        walk_stop_rule(walk, rule);
}

struct location walk_location(const struct geometry_view *geometry, enum subject subject)
{
    return (struct location){.command = geometry->build->call->command,
                             .subject = subject,
                             .build = geometry->build->index,
                             .geometry = geometry->index,
                             .geometry_by_pointer = geometry->build->geometry_pointers != NULL};
}
