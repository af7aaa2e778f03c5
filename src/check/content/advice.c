/* SPDX-License-Identifier: Apache-2.0 */
#include "src/check/content/advice.h"

#include "src/bvh/input/source.h"
#include "src/rules/advice.h"
#include "src/view/geometry_data.h"

/* ---- rows */

static void keep(void *user, enum advice id, const struct finding *finding, uint64_t weight)
{
    struct content_advice *advice = user;
    if (weight > advice->kept[id].weight)
        advice->kept[id] = (struct kept_advice){weight, *finding};
}

/* ---- triangles */

static bool find_other(const struct content *content, struct other_indices *other)
{
    const struct content_indices *indices = &content->indices;
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(content->range->geometry->geometry);
    const uint64_t limit = (uint64_t)triangles->maxVertex + 1 - content->range->range->firstVertex;
    return indices->bytes &&
           indices_suit_another_size(indices->bytes, indices->size, indices->count, limit, other);
}

static void judge_mesh(struct content *content, const struct source *source,
                       const struct triangle_figures *figures)
{
    struct content_advice *advice = content->walk->advice;
    struct other_indices other;
    struct stray_vertex stray;
    const double bounds = advice->limits->of[ADVICE_LIMIT_stray_times];
    const bool is_large = figures->measured && figures->extent >= bounds * figures->median;
    const struct mesh_view view = {
        .geometry = content->range->geometry,
        .limits = advice->limits,
        .figures = figures,
        .index_size = content->indices.size,
        .other = find_other(content, &other) ? &other : NULL,
        .stray = is_large && stray_vertex_find(source, figures, &stray) ? &stray : NULL,
    };
    advice_judge_mesh(&view, keep, advice);
}

/* Every index is within maxVertex, or the figures are unknown. */
static bool advise_triangles(struct content *content, const struct source *source)
{
    struct structure_contents *contents = &content->walk->advice->contents;
    struct triangle_figures figures;
    if (!triangle_figures_read(source, &figures))
        return false;
    contents->inactive += figures.inactive;
    contents->invisible += figures.degenerate;
    judge_mesh(content, source, &figures);
    return true;
}

/* A ray may hit an AABB without volume. */
static bool advise_boxes(struct content *content, const struct source *source)
{
    struct structure_contents *contents = &content->walk->advice->contents;
    for (uint32_t i = 0; i < source->count; i++) {
        struct aabb_record box;
        const enum source_state state = source_aabb(source, i, &box);
        if (state != SOURCE_ACTIVE && state != SOURCE_INACTIVE)
            return false;
        contents->inactive += state == SOURCE_INACTIVE;
    }
    return true;
}

/* Displaced triangles, and those that move, are not where their vertices are. */
static bool advise_primitives(struct content *content)
{
    const struct geometry_view *geometry = content->range->geometry;
    struct builder_geometry described;
    struct source source = {0};
    if ((geometry->build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) ||
        !content->chained || content->chained->has_displacement ||
        !content_describe(content, &described) ||
        !content_open_source(content, &described, &source))
        return false;
    return triangles_in(geometry->geometry) ? advise_triangles(content, &source)
                                            : advise_boxes(content, &source);
}

/* ---- instances */

static bool advise_instances(struct content *content)
{
    struct content_advice *advice = content->walk->advice;
    struct instance_figures *figures = &advice->instances;
    const struct placing_view view = {
        .geometry = content->range->geometry, .limits = advice->limits, .figures = figures};
    instance_figures_end(figures);
    if (figures->count != content->range->range->primitiveCount)
        return false;
    advice->contents.inactive += figures->inactive;
    advice->contents.invisible += figures->masked;
    advice_judge_placing(&view, keep, advice);
    return true;
}

void content_advise_begin(struct content *content)
{
    instance_figures_begin(&content->walk->advice->instances,
                           content->range->range->primitiveCount);
}

/* ---- builds */

void content_advise(struct content *content)
{
    struct content_advice *advice = content->walk->advice;
    const uint32_t count = content->range->range->primitiveCount;
    advice->contents.primitives += count;
    advice->geometry_count++;
    if (instances_in(content->range->geometry->geometry))
        advice->is_unknown |= !advise_instances(content);
    else if (count)
        advice->is_unknown |= !advise_primitives(content);
}

/* If no ray can hit anything, that is one advice, about the structure. A geometry whose range is in
 * a buffer that could not be copied was not read. */
bool content_advice_end(struct content_advice *advice, uint32_t geometry_count)
{
    if (structure_is_hollow(&advice->contents))
        advice->kept[ADVICE_most_triangles_can_be_hit].weight = 0;
    return !advice->is_unknown && advice->geometry_count == geometry_count;
}
