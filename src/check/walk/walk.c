/* SPDX-License-Identifier: Apache-2.0 */
/* Starts a walk, selects its rules, evaluates the rows and reports findings. */
#include "src/check/walk/walk.h"

#include <string.h>

#include "src/check/walk/rows.h"

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
    walk->advice = NULL;
    walk->digesting = NULL;
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

/* ---- The evaluation of all rows, except for those about input data (src/check/content/) and about
 * host memory (src/check/call/parts.c) */

static struct location location_of_call(const struct call_view *call)
{
    return (struct location){.command = call->command, .subject = SUBJECT_CALL};
}

static struct location location_of_build(const struct build_view *build)
{
    return (struct location){
        .command = build->call->command, .subject = SUBJECT_BUILD, .build = build->index};
}

static struct location location_of_element(const struct build_view *build)
{
    return (struct location){
        .command = COMMAND_INDIRECT, .subject = SUBJECT_ELEMENT, .build = build->index};
}

static struct location location_of_address(const struct address_view *address)
{
    if (address->geometry)
        return walk_location(address->geometry, SUBJECT_GEOMETRY);
    return address->role == INPUT_INDIRECT ? location_of_element(address->build)
                                           : location_of_build(address->build);
}

WALK_LEVEL(call, location_of_call(call))
WALK_LEVEL(build, location_of_build(build))
WALK_LEVEL(geometry, walk_location(geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(range, walk_location(range->geometry, SUBJECT_RANGE))
WALK_LEVEL(address, location_of_address(address))
WALK_LEVEL(indirect, location_of_element(indirect->build))
WALK_ALL(pair)

/* ---- extensions of builds and geometries */

WALK_LEVEL(motion_build, location_of_build(motion_build->build))
WALK_LEVEL(motion_triangles, walk_location(motion_triangles->geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(spheres, walk_location(spheres->data.geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(swept_spheres, walk_location(swept_spheres->data.geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(dense_build, location_of_build(dense_build->build))
WALK_LEVEL(dense, walk_location(dense->geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(micromap_build, location_of_build(micromap_build->build))
WALK_LEVEL(micromap_geometry, walk_location(micromap_geometry->geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(micromap_data, walk_location(micromap_data->geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(opacity, walk_location(opacity->geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(opacity_ext, walk_location(opacity_ext->geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(displacement, walk_location(displacement->geometry, SUBJECT_GEOMETRY))

/* Updates and uses of micromaps are validated once, when the structures they refer to are known. */

WALK_ALL(update)
WALK_ALL(updated_geometry)
WALK_ALL(updated_dense)
WALK_ALL(updated_micromap)
WALK_ALL(used_micromap)

/* ---- vkCmdBuildAccelerationStructureNV, and the structures that it has in common with
 * vkCreateAccelerationStructureNV */

static const struct location nv_parameter = {.command = COMMAND_NV, .subject = SUBJECT_PARAMETER};

static struct location location_of_nv_info(const struct nv_info_view *info)
{
    return (struct location){.command = info->call->call->command, .subject = SUBJECT_BUILD};
}

static struct location location_of_nv_geometry(const struct nv_geometry_view *geometry)
{
    return (struct location){.command = geometry->call->call->command,
                             .subject = SUBJECT_GEOMETRY,
                             .geometry = geometry->index};
}

WALK_LEVEL(nv_call, nv_parameter)
WALK_LEVEL(nv_info, location_of_nv_info(nv_info))
WALK_LEVEL(nv_geometry, location_of_nv_geometry(nv_geometry))
