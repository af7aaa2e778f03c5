/* SPDX-License-Identifier: Apache-2.0 */
/* Rules of VK_NV_ray_tracing_motion_blur: builds with motion, and the vertex positions of moving
 * triangles at the end of the motion. */
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

static bool has_motion_flag(const struct build_view *build)
{
    return build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
}

/* ---- builds */

static struct value dst(const struct build_view *build)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle_number(build->dst.handle));
}

static bool dst_has_motion_flag(const struct build_view *build)
{
    return build->dst.create_flags & VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV;
}

/* Whether dst lacks motion, and a geometry has motion data. */
static bool has_motion_geometry(const struct motion_build_view *motion_build)
{
    return motion_build->first_motion_geometry < motion_build->build->geometry_count;
}

bool motion_dst_is_built_with_motion(const struct motion_build_view *motion_build,
                                     struct finding *finding)
{
    const struct build_view *build = motion_build->build;
    return !build->dst.details_known || !dst_has_motion_flag(build) || has_motion_flag(build) ||
           violated(finding, "flags",
                    "{} lacks VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV, but {} was created "
                    "with VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV",
                    build_flags(build->info->flags), dst(build));
}

bool motion_build_has_a_motion_dst(const struct motion_build_view *motion_build,
                                   struct finding *finding)
{
    const struct build_view *build = motion_build->build;
    return !build->dst.details_known || !has_motion_flag(build) || dst_has_motion_flag(build) ||
           violated(finding, "flags",
                    "{} has VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV, but {} was created with "
                    "createFlags {}, without VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV",
                    build_flags(build->info->flags), dst(build),
                    accel_create_flags(build->dst.create_flags)) ||
           (has_motion_geometry(motion_build) &&
            also_violates(finding, build->dst.by_address
                                       ? RULE_motion_geometry_has_a_motion_dst_at_its_address
                                       : RULE_motion_geometry_has_a_motion_dst));
}

/* The creation knows no geometries, so builds validate what it says of them. */
static bool created_for_motion_geometry(const struct motion_build_view *motion_build,
                                        struct finding *finding)
{
    const struct build_view *build = motion_build->build;
    return !has_motion_geometry(motion_build) ||
           violated(finding, "dstAccelerationStructure",
                    "{} was created with createFlags {}, without "
                    "VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV, but geometry {} has a "
                    "VkAccelerationStructureGeometryMotionTrianglesDataNV",
                    dst(build), accel_create_flags(build->dst.create_flags),
                    number(motion_build->first_motion_geometry)) ||
           (has_motion_flag(build) &&
            is_reported_with(finding, RULE_motion_build_has_a_motion_dst));
}

bool motion_geometry_has_a_motion_dst(const struct motion_build_view *motion_build,
                                      struct finding *finding)
{
    return motion_build->build->dst.by_address ||
           created_for_motion_geometry(motion_build, finding);
}

bool motion_geometry_has_a_motion_dst_at_its_address(const struct motion_build_view *motion_build,
                                                     struct finding *finding)
{
    return !motion_build->build->dst.by_address ||
           created_for_motion_geometry(motion_build, finding);
}

bool motion_build_is_not_generic(const struct motion_build_view *motion_build,
                                 struct finding *finding)
{
    const struct build_view *build = motion_build->build;
    return !has_motion_flag(build) ||
           build->info->type != VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR ||
           violated(finding, "flags",
                    "{} has VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV, but type is "
                    "VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR",
                    build_flags(build->info->flags)) ||
           is_reported_with(finding, RULE_build_type_is_not_generic);
}

/* ---- triangles */

bool motion_vertex_address_is_given(const struct motion_triangles_view *motion_triangles,
                                    struct finding *finding)
{
    const struct geometry_view *geometry = motion_triangles->geometry;
    return !motion_triangles->vertices ||
           chained_address_is_given(geometry, finding, content_field(geometry, INPUT_MOTION_VERTEX),
                                    *motion_triangles->vertices);
}
