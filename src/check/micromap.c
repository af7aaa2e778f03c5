/* SPDX-License-Identifier: Apache-2.0 */
/* The rows about micromaps, subject by subject, as code, and the order in which they are walked. */
#include "check/extensions.h"
#include "check/micromap_views.h"
#include "check/predicates.h"

/* The rows of one subject are in a file of their own. */
#define RULE(subject, name, row_level, ids)                                                        \
    if (LEVEL_##row_level == level && walk->wants[RULE_##name] && !name(subject, &finding))        \
        walk_hand_on(walk, RULE_##name, &location, &finding);

static void walk_micromap_build(struct walk *walk, const struct micromap_build_view *micromap_build,
                                enum level level)
{
    const struct build_view *build = micromap_build->build;
    const struct location location = {
        .command = build->call->command, .subject = SUBJECT_BUILD, .build = build->index};
    struct finding finding;
#include "rows/micromap_build.def"
}

static void walk_micromap_geometry(struct walk *walk,
                                   const struct micromap_geometry_view *micromap_geometry,
                                   enum level level)
{
    const struct location location = walk_location(micromap_geometry->geometry, SUBJECT_GEOMETRY);
    struct finding finding;
#include "rows/micromap_geometry.def"
}

static void walk_micromap_data(struct walk *walk, const struct micromap_data_view *micromap_data,
                               enum level level)
{
    const struct location location = walk_location(micromap_data->geometry, SUBJECT_GEOMETRY);
    struct finding finding;
#include "rows/micromap_data.def"
}

static void walk_opacity(struct walk *walk, const struct opacity_view *opacity, enum level level)
{
    const struct location location = walk_location(opacity->geometry, SUBJECT_GEOMETRY);
    struct finding finding;
#include "rows/micromap_opacity.def"
}

static void walk_opacity_ext(struct walk *walk, const struct opacity_ext_view *opacity_ext,
                             enum level level)
{
    const struct location location = walk_location(opacity_ext->geometry, SUBJECT_GEOMETRY);
    struct finding finding;
#include "rows/micromap_opacity_ext.def"
}

static void walk_displacement(struct walk *walk, const struct displacement_view *displacement,
                              enum level level)
{
    const struct location location = walk_location(displacement->geometry, SUBJECT_GEOMETRY);
    struct finding finding;
#include "rows/micromap_displacement.def"
}

void check_micromap_build(struct walk *walk, const struct build_view *build, bool with_state)
{
    const struct micromap_build_view view = {.build = build};
    walk_micromap_build(walk, &view, LEVEL_PARAMETERS);
    if (with_state)
        walk_micromap_build(walk, &view, LEVEL_STATE);
}

/* Geometries. Each subject at both levels, if the geometry has its structure. */

static void check_opacity(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    struct opacity_view view;
    if (!view_opacity(geometry, &view))
        return;
    walk_opacity(walk, &view, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view_opacity_state(walk->context, geometry, &view);
    walk_opacity(walk, &view, LEVEL_STATE);
}

static void check_opacity_ext(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    struct opacity_ext_view view;
    if (!view_opacity_ext(walk->context, geometry, &view))
        return;
    walk_opacity_ext(walk, &view, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view_opacity_ext_state(walk->context, geometry, &view);
    walk_opacity_ext(walk, &view, LEVEL_STATE);
}

static void check_displacement(struct walk *walk, const struct geometry_view *geometry,
                               bool with_state)
{
    struct displacement_view view;
    if (!view_displacement(walk->context, geometry, &view))
        return;
    walk_displacement(walk, &view, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view_displacement_state(walk->context, &view);
    walk_displacement(walk, &view, LEVEL_STATE);
}

static bool check_data(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    struct micromap_data_view view;
    if (!view_micromap_data(walk->context, geometry, &view))
        return false;
    walk_micromap_data(walk, &view, LEVEL_PARAMETERS);
    if (with_state) {
        view_micromap_data_state(walk->context, geometry, &view);
        walk_micromap_data(walk, &view, LEVEL_STATE);
    }
    return true;
}

void check_micromaps(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    struct micromap_geometry_view view = {.geometry = geometry};
    view.has_data = check_data(walk, geometry, with_state);
    walk_micromap_geometry(walk, &view, LEVEL_PARAMETERS);
    check_opacity(walk, geometry, with_state);
    check_opacity_ext(walk, geometry, with_state);
    check_displacement(walk, geometry, with_state);
}
