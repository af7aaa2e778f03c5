/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the micromaps that builds use when they execute. The rules about updates compare them
 * with the micromaps that the source was last built with. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"

static struct value structure(uint64_t handle)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, handle);
}

/* ---- uses */

bool opacity_micromap_was_constructed_before(const struct used_micromap_view *used_micromap,
                                             struct finding *finding)
{
    return used_micromap->use->is_ext || used_micromap->built->state != BUILT_NEVER ||
           violated(finding, OPACITY_DATA "micromap", "{} has never been built",
                    structure(used_micromap->handle));
}

bool ext_opacity_micromap_was_constructed_before(const struct used_micromap_view *used_micromap,
                                                 struct finding *finding)
{
    return !used_micromap->use->is_ext || used_micromap->built->state != BUILT_NEVER ||
           violated(finding, OPACITY_EXT_DATA "micromap", "{} has never been built",
                    object(VK_OBJECT_TYPE_MICROMAP_EXT, used_micromap->handle));
}

static bool was_built(const struct used_micromap_view *used)
{
    return !used->use->is_ext && used->built->state == BUILT_BEFORE;
}

bool opacity_micromap_was_built_as_micromap(const struct used_micromap_view *used_micromap,
                                            struct finding *finding)
{
    const struct built *built = used_micromap->built;
    return !was_built(used_micromap) ||
           built->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR ||
           violated(finding, OPACITY_DATA "micromap",
                    "{} was last built with type {}, not "
                    "VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR ({})",
                    structure(used_micromap->handle), accel_type(built->type), built_at(built));
}

bool opacity_triangles_are_within_micromap(const struct used_micromap_view *used_micromap,
                                           struct finding *finding)
{
    const struct journal_micromap *use = used_micromap->use;
    const struct built *built = used_micromap->built;
    if (!was_built(used_micromap) || !use->is_unindexed || !use->triangle_count ||
        built->type != VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR || !built->shapes ||
        !built->shapes->count || !built->shapes->items[0].count_known)
        return true;
    uint64_t last = (uint64_t)use->first + use->triangle_count - 1;
    return last <= built->shapes->items[0].primitive_count ||
           violated(finding, OPACITY_DATA "baseTriangle",
                    "{} and {} in the build range reach triangle {} of the micromap, but {} was "
                    "last built with {} ({})",
                    number(use->first), count_of(use->triangle_count, "triangle"), number(last),
                    structure(used_micromap->handle),
                    count_of(built->shapes->items[0].primitive_count, "triangle"), built_at(built));
}

/* The last build of a deserialized source is unknown, but the update must have the flags and
 * micromaps of that build. If the update gives them, and they must not change, they are the
 * source's. */
bool opacity_micromap_of_deserialized_source_is_deserialized(
    const struct used_micromap_view *used_micromap, struct finding *finding)
{
    return !used_micromap->source || used_micromap->source->state != BUILT_FILLED ||
           !used_micromap->use->must_stay || !was_built(used_micromap) ||
           violated(finding, OPACITY_DATA "micromap",
                    "{} was built ({}), but srcAccelerationStructure was "
                    "deserialized, so its micromaps must be deserialized, too",
                    structure(used_micromap->handle), built_at(used_micromap->built));
}

/* ---- updates */

static bool differs(const struct updated_micromap_view *view, struct finding *finding,
                    const char *field, const char *now, const char *then, uint64_t handle)
{
    const struct update_view *update = view->geometry->update;
    return violated(finding, field, "{}, but {} was last built with {} ({})", phrase(now),
                    structure(update->src), handle ? structure(handle) : phrase(then),
                    built_at(update->source));
}

static bool are_triangles(const struct updated_micromap_view *view)
{
    return type_is_triangles(view->geometry->requested->type) &&
           type_is_triangles(view->geometry->source->type);
}

bool opacity_micromap_is_kept_where_source_had_one(
    const struct updated_micromap_view *updated_micromap, struct finding *finding)
{
    const struct micromap_shape *requested = &updated_micromap->requested;
    uint64_t before = updated_micromap->source.handle;
    if (!are_triangles(updated_micromap) || !before || requested->handle)
        return true;
    return requested->given
               ? differs(updated_micromap, finding, OPACITY_DATA "micromap", "is VK_NULL_HANDLE",
                         NULL, before)
               : differs(updated_micromap, finding, "geometry.triangles.pNext",
                         "has no VkAccelerationStructureTrianglesOpacityMicromapKHR", NULL, before);
}

bool opacity_micromap_stays_null_where_source_had_null(
    const struct updated_micromap_view *updated_micromap, struct finding *finding)
{
    const struct micromap_shape *requested = &updated_micromap->requested;
    const struct micromap_shape *source = &updated_micromap->source;
    if (!are_triangles(updated_micromap) || !source->given || source->handle ||
        (requested->given && !requested->handle))
        return true;
    return requested->given ? differs(updated_micromap, finding, OPACITY_DATA "micromap",
                                      "is given", "VK_NULL_HANDLE there", 0)
                            : differs(updated_micromap, finding, "geometry.triangles.pNext",
                                      "has no VkAccelerationStructureTrianglesOpacityMicromapKHR",
                                      "one whose micromap is VK_NULL_HANDLE", 0);
}

bool opacity_micromap_stays_absent_where_source_had_none(
    const struct updated_micromap_view *updated_micromap, struct finding *finding)
{
    return !are_triangles(updated_micromap) || updated_micromap->source.given ||
           !updated_micromap->requested.given ||
           differs(updated_micromap, finding, "geometry.triangles.pNext",
                   "has a VkAccelerationStructureTrianglesOpacityMicromapKHR", "none", 0);
}

bool opacity_micromap_matches_source(const struct updated_micromap_view *updated_micromap,
                                     struct finding *finding)
{
    const VkBuildAccelerationStructureFlagsKHR may_change =
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT;
    uint64_t requested = updated_micromap->requested.handle,
             before = updated_micromap->source.handle;
    const struct update_view *update = updated_micromap->geometry->update;
    if (!are_triangles(updated_micromap) || !requested || !before || requested == before ||
        (update->source->flags & may_change))
        return true;
    return violated(finding, OPACITY_DATA "micromap",
                    "is {}, but {} was last built with {} ({}), and without flags that "
                    "let micromaps change",
                    structure(requested), structure(update->src), structure(before),
                    built_at(update->source));
}
