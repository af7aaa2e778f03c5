/* SPDX-License-Identifier: Apache-2.0 */
/* Defines the evaluation of all rows, except for those about input data (src/check/content/) and
 * about host memory (src/check/call/parts.c). */
#include "src/check/walk/rows.h"

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
WALK_LEVEL(spheres, walk_location(spheres->data->geometry, SUBJECT_GEOMETRY))
WALK_LEVEL(swept_spheres, walk_location(swept_spheres->data->geometry, SUBJECT_GEOMETRY))
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
