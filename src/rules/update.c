/* SPDX-License-Identifier: Apache-2.0 */
/* Rules that compare an update with the last build of its source. They are evaluated only if that
 * build is known. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"

static struct value source(const struct update_view *update)
{
    return object(update->command == COMMAND_NV ? VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV
                                                : VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                  update->src);
}

#define LAST_BUILT "{} was last built with {} ({})"

bool update_differs(const struct update_view *update, struct finding *finding, const char *field,
                    struct value now, struct value then)
{
    return violated(finding, field, "is {}, but " LAST_BUILT, now, source(update), then,
                    built_at(update->source));
}

bool update_source_was_built_with_allow_update(const struct update_view *update,
                                               struct finding *finding)
{
    const char *field = update->command == COMMAND_NV ? "src" : "srcAccelerationStructure";
    const struct built *last = update->source;
    if (last->state == BUILT_NEVER)
        return violated(finding, field, "{} has never been built", source(update));
    return (last->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) ||
           violated(finding, field,
                    "{} was last built with flags {}, without "
                    "VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR ({})",
                    source(update), build_flags(last->flags), built_at(last));
}

bool geometry_count_matches_source(const struct update_view *update, struct finding *finding)
{
    return update->source->state == BUILT_NEVER ||
           update->requested->geometry_count == update->source->geometry_count ||
           update_differs(update, finding, "geometryCount",
                          number(update->requested->geometry_count),
                          number(update->source->geometry_count));
}

/* A source built without ALLOW_UPDATE has its own rule. */
bool build_flags_match_source(const struct update_view *update, struct finding *finding)
{
    const struct built *last = update->source;
    return !(last->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) ||
           update->requested->flags == last->flags ||
           update_differs(update, finding, "flags", build_flags(update->requested->flags),
                          build_flags(last->flags));
}

static bool first_types_differ(const struct update_view *update)
{
    const struct geometry_shapes *now = update->requested->shapes, *then = update->source->shapes;
    return now && then && now->count && then->count && now->items[0].type != then->items[0].type;
}

/* Structures of different types have geometries of different types. */
bool build_type_matches_source(const struct update_view *update, struct finding *finding)
{
    return update->source->state == BUILT_NEVER ||
           update->requested->type == update->source->type ||
           update_differs(update, finding, "type", accel_type(update->requested->type),
                          accel_type(update->source->type)) ||
           (first_types_differ(update) &&
            also_violates(finding, RULE_geometry_type_matches_source));
}

/* ---- geometries */

static bool geometry_differs(const struct updated_geometry_view *geometry, struct finding *finding,
                             const char *field, struct value now, struct value then)
{
    return update_differs(geometry->update, finding, field, now, then);
}

bool geometry_type_matches_source(const struct updated_geometry_view *updated_geometry,
                                  struct finding *finding)
{
    const struct geometry_shape *now = updated_geometry->requested,
                                *then = updated_geometry->source;
    return now->type == then->type ||
           geometry_differs(updated_geometry, finding, "geometryType", geometry_type(now->type),
                            geometry_type(then->type)) ||
           (updated_geometry->update->requested->type != updated_geometry->update->source->type &&
            is_reported_with(finding, RULE_build_type_matches_source));
}

bool geometry_flags_match_source(const struct updated_geometry_view *updated_geometry,
                                 struct finding *finding)
{
    const struct geometry_shape *now = updated_geometry->requested,
                                *then = updated_geometry->source;
    return now->flags == then->flags ||
           geometry_differs(updated_geometry, finding, "flags", geometry_flags_of(now->flags),
                            geometry_flags_of(then->flags));
}

static bool both_are_triangles(const struct updated_geometry_view *geometry)
{
    return type_is_triangles(geometry->requested->type) &&
           type_is_triangles(geometry->source->type);
}

bool vertex_format_matches_source(const struct updated_geometry_view *updated_geometry,
                                  struct finding *finding)
{
    const struct geometry_shape *now = updated_geometry->requested,
                                *then = updated_geometry->source;
    return !both_are_triangles(updated_geometry) || now->vertex_format == then->vertex_format ||
           geometry_differs(updated_geometry, finding, "geometry.triangles.vertexFormat",
                            format(now->vertex_format), format(then->vertex_format));
}

bool max_vertex_matches_source(const struct updated_geometry_view *updated_geometry,
                               struct finding *finding)
{
    const struct geometry_shape *now = updated_geometry->requested,
                                *then = updated_geometry->source;
    return !both_are_triangles(updated_geometry) || now->max_vertex == then->max_vertex ||
           geometry_differs(updated_geometry, finding, "geometry.triangles.maxVertex",
                            number(now->max_vertex), number(then->max_vertex));
}

bool index_type_matches_source(const struct updated_geometry_view *updated_geometry,
                               struct finding *finding)
{
    const struct geometry_shape *now = updated_geometry->requested,
                                *then = updated_geometry->source;
    return !both_are_triangles(updated_geometry) || now->index_type == then->index_type ||
           geometry_differs(updated_geometry, finding, "geometry.triangles.indexType",
                            index_type(now->index_type), index_type(then->index_type));
}

static const char *transform_field(const struct updated_geometry_view *geometry)
{
    return geometry->update->command == COMMAND_HOST ? input_name(INPUT_MATRIX, INPUT_OF_HOST)
                                                     : input_name(INPUT_MATRIX, INPUT_OF_DEVICE);
}

bool transform_is_absent_where_source_had_none(const struct updated_geometry_view *updated_geometry,
                                               struct finding *finding)
{
    return !both_are_triangles(updated_geometry) || updated_geometry->source->has_transform ||
           !updated_geometry->requested->has_transform ||
           geometry_differs(updated_geometry, finding, transform_field(updated_geometry),
                            phrase("given"), phrase("0"));
}

bool transform_is_given_where_source_had_one(const struct updated_geometry_view *updated_geometry,
                                             struct finding *finding)
{
    return !both_are_triangles(updated_geometry) || !updated_geometry->source->has_transform ||
           updated_geometry->requested->has_transform ||
           geometry_differs(updated_geometry, finding, transform_field(updated_geometry), number(0),
                            phrase("an address"));
}

/* The primitive counts of an indirect build are in its recorded inputs. */
static bool find_count(const struct geometry_shape *shape, const struct built *built,
                       uint32_t geometry, uint32_t *count)
{
    const struct geometry_inputs *inputs =
        shape->count_known ? NULL : build_inputs_of(built_inputs(built), geometry);
    *count = inputs ? inputs->primitive_count : shape->primitive_count;
    return shape->count_known || (inputs && inputs->count_known);
}

static bool count_matches(const struct updated_geometry_view *geometry, struct finding *finding)
{
    const struct update_view *update = geometry->update;
    uint32_t now, then;
    /* Reports once: if the command buffer reads the count, after it was read, although the source
     * may be known before. */
    bool is_known = (geometry->requested->count_known && geometry->source->count_known) ||
                    build_inputs_of(built_inputs(update->requested), geometry->index);
    return !is_known ||
           !find_count(geometry->requested, update->requested, geometry->index, &now) ||
           !find_count(geometry->source, update->source, geometry->index, &then) || now == then ||
           violated(finding, "", "has primitiveCount {} in its build range, but " LAST_BUILT,
                    number(now), source(update), number(then), built_at(update->source));
}

bool primitive_count_matches_source(const struct updated_geometry_view *updated_geometry,
                                    struct finding *finding)
{
    return count_matches(updated_geometry, finding);
}

bool indirect_primitive_count_matches_source(const struct updated_geometry_view *updated_geometry,
                                             struct finding *finding)
{
    return count_matches(updated_geometry, finding);
}
