/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the micromaps of builds and geometries. */
#include "src/base/array.h"
#include "src/check/assemble/views.h"
#include "src/check/call/parts.h"
#include "src/rules/micromap/shared.h"

/* The micromaps of the current build. */

const struct micromap_uses *found_micromaps(const struct walk *walk)
{
    const struct micromap_uses *uses = &walk->micromaps;
    return uses->count || unknown_is_set(&uses->unknown) || uses->built_count_known ? uses : NULL;
}

static void add_use(struct walk *walk, const struct micromap_use *use)
{
    struct micromap_uses *uses = &walk->micromaps;
    if (ARRAY_HAS_ROOM(uses->items, uses->count, uses->capacity))
        uses->items[uses->count++] = *use;
    else
        unknown_set(&uses->unknown, UNKNOWN_MICROMAPS);
}

static void note_opacity(struct walk *walk, const struct opacity_view *view)
{
    const VkAccelerationStructureTrianglesOpacityMicromapKHR *opacity = view->opacity;
    struct micromap_use use = {.geometry = view->geometry->index,
                               .handle = handle_number(opacity->micromap),
                               .id = view->micromap.id,
                               .accel = view->micromap};
    if (opacity->indexType == VK_INDEX_TYPE_NONE_KHR && view->count_known) {
        use.is_unindexed = true;
        use.first = opacity->baseTriangle;
        use.triangle_count = view->primitive_count;
    }
    add_use(walk, &use);
}

static void note_opacity_ext(struct walk *walk, const struct opacity_ext_view *view)
{
    struct micromap_use use = {.geometry = view->geometry->index,
                               .is_ext = true,
                               .handle = handle_number(view->opacity->micromap),
                               .id = view->micromap.id};
    add_use(walk, &use);
}

static void note_data(struct walk *walk, const struct micromap_data_view *view)
{
    uint64_t sum = usages_sum(&view->usages);
    bool is_whole = view->usages.count == view->data->usageCountsCount;
    walk->micromaps.built_count_known = is_whole && sum <= UINT32_MAX;
    walk->micromaps.built_triangle_count = (uint32_t)sum;
}

/* Returns whether the build info has a type or flags of micromaps. */
static bool is_about_micromaps(const VkAccelerationStructureBuildGeometryInfoKHR *info)
{
    const VkBuildAccelerationStructureFlagsKHR flags =
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT |
        VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR;
    return info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR || info->flags & flags;
}

void check_micromap_build(struct walk *walk, const struct build_view *build, bool with_state)
{
    const struct micromap_build_view view = {.build = build};
    walk->micromaps.count = 0;
    walk->micromaps.unknown = (struct unknown){0};
    walk->micromaps.built_count_known = false;
    if (!is_about_micromaps(build->info))
        return;
    walk_micromap_build(walk, &view, LEVEL_PARAMETERS);
    if (with_state)
        walk_micromap_build(walk, &view, LEVEL_STATE);
}

/* ---- geometries: each subject at both levels, if the geometry has its structure */

static void check_opacity(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    struct opacity_view view;
    if (!view_opacity(geometry, &view))
        return;
    walk_opacity(walk, &view, LEVEL_PARAMETERS);
    if (with_state) {
        view_opacity_state(walk->context, geometry, &view);
        walk_opacity(walk, &view, LEVEL_STATE);
    }
    note_opacity(walk, &view);
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
    note_opacity_ext(walk, &view);
}

static void check_displacement(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    struct displacement_view view;
    if (!view_displacement(walk->context, geometry, &view))
        return;
    walk_displacement(walk, &view, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view_displacement_state(walk->context, geometry, &view);
    walk_displacement(walk, &view, LEVEL_STATE);
}

static bool check_data(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    struct micromap_data_view view;
    if (!view_micromap_data(walk->context, geometry, &view))
        return false;
    walk_micromap_data(walk, &view, LEVEL_PARAMETERS);
    note_data(walk, &view);
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
