/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/reading.h"

#include <math.h>
#include <stdlib.h>

#include "src/advice/figures/refits.h"
#include "src/advice/rules.h"
#include "src/base/array.h"
#include "src/bvh/input/source.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"

static struct content_advice *advice_of(struct build_reader *reader)
{
    return ((struct advice_reading *)reader)->advice;
}

/* ---- rows */

static void keep_advice(void *user, enum advice id, const struct finding *finding, uint64_t weight)
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
    return indices->bytes && indices_suit_another_size(indices->bytes, indices->size,
                                                       indices->count, indices->max, limit, other);
}

/* With another stride, firstVertex would be elsewhere. */
static bool find_stride(const struct content *content, const struct source *source,
                        const struct triangle_figures *figures, struct other_stride *other)
{
    struct builder_geometry described;
    return !content->range->range->firstVertex && content_describe(content, &described) &&
           other_stride_find(source, figures, described.triangles.vertices_size, other);
}

/* Nearly all vertices from the first one to the last one are used. */
static bool find_used(const struct content *content, struct used_vertices *used)
{
    const struct content_indices *indices = &content->indices;
    if (!indices->size) {
        *used = (struct used_vertices){0, (uint32_t)indices->count - 1, indices->count};
        return indices->count;
    }
    return indices_find_used(indices->bytes, indices->size, indices->count, indices->max, used) &&
           used->count * 10 >= ((uint64_t)used->largest - used->smallest + 1) * 9;
}

/* Geometries of data that is not there yet may share it. */
static bool find_layout(const struct content *content, const struct source *source,
                        const struct triangle_figures *figures, struct vertex_layout *layout)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(content->range->geometry->geometry);
    const uint64_t stride = triangles->vertexStride;
    const struct geometry_input *vertices = content_input(content, INPUT_VERTEX);
    struct used_vertices used;
    if (!vertices || content->range->geometry->build->geometry_count < 2 ||
        figures->measured * 2 < figures->count || !find_used(content, &used))
        return false;
    *layout = (struct vertex_layout){
        .begin = vertices->address.deviceAddress + vertices->offset + used.smallest * stride,
        .count = (uint64_t)used.largest - used.smallest + 1,
        .stride = stride,
        .geometry = content->range->geometry->index,
        .format = triangles->vertexFormat,
        .component = format_smallest_component(triangles->vertexFormat),
        .is_float = source->format->has_nan,
    };
    return true;
}

static void drop_refit(struct content_advice *advice)
{
    triangle_sample_release(advice->refit.built);
    triangle_sample_release(advice->refit.now);
    advice->refit = (struct refit){0};
}

static void keep_refit(struct content_advice *advice, uint32_t geometry,
                       struct triangle_sample *built, const struct source *now)
{
    const struct refit *kept = &advice->refit;
    if (advice->number < advice->limits->of[ADVICE_LIMIT_refits] || now->count != built->of ||
        (kept->now && kept->now->of >= now->count))
        return;
    struct triangle_sample *sample = triangle_sample_create(now);
    if (!sample)
        return;
    drop_refit(advice);
    advice->refit = (struct refit){geometry, triangle_sample_share(built), sample};
}

/* Samples what is built, and what is updated if the build was sampled. */
static void sample_triangles(struct content_advice *advice, const struct content *content,
                             const struct source *source)
{
    const struct geometry_view *geometry = content->range->geometry;
    struct geometry_inputs *retained = content->retained;
    if (retained && !build_is_update(geometry->build->info))
        retained->kept = (struct kept_block *)triangle_sample_create(source);
    else if (retained && retained->kept)
        keep_refit(advice, geometry->index, (struct triangle_sample *)retained->kept, source);
}

static void judge_mesh(struct content_advice *advice, const struct content *content,
                       const struct source *source, const struct triangle_figures *figures)
{
    struct vertex_layout layout;
    struct other_stride smooth;
    struct other_indices other;
    struct stray_vertex stray;
    const bool has_layout = find_layout(content, source, figures, &layout);
    const double bounds = advice->limits->of[ADVICE_LIMIT_stray_times];
    const bool is_large = figures->measured && figures->extent >= bounds * figures->median;
    const struct mesh_view view = {
        .geometry = content->range->geometry,
        .limits = advice->limits,
        .figures = figures,
        .index_size = content->indices.size,
        .other = find_other(content, &other) ? &other : NULL,
        .stray = is_large && stray_vertex_find(source, figures, &stray) ? &stray : NULL,
        .smooth = find_stride(content, source, figures, &smooth) ? &smooth : NULL,
        .layout = has_layout ? &layout : NULL,
        .contradicting = has_layout ? vertex_layouts_find_other(&advice->layouts, &layout) : NULL,
    };
    advice_judge_mesh(&view, keep_advice, advice);
    sample_triangles(advice, content, source);
    if (has_layout)
        vertex_layouts_add(&advice->layouts, &layout);
}

static void add_to_box(struct content_advice *advice, const float lower[3], const float upper[3])
{
    struct structure_contents *contents = &advice->contents;
    figure_box_add(&contents->box, !contents->has_box, lower, upper);
    contents->has_box = true;
}

/* The figures are those before the geometry's transform, and of finite triangles. */
static void add_triangles_to_box(struct content_advice *advice, const struct content *content,
                                 const struct triangle_figures *figures)
{
    advice->has_unknown_box |=
        input_address(content->range->geometry->geometry, INPUT_MATRIX) ||
        figures->measured + figures->inactive + figures->degenerate != figures->count;
    if (figures->measured)
        add_to_box(advice, figures->lower, figures->upper);
}

/* Every index is within maxVertex, or the figures are unknown. */
static bool advise_triangles(struct content_advice *advice, const struct content *content,
                             const struct source *source)
{
    struct structure_contents *contents = &advice->contents;
    struct triangle_figures figures;
    if (!triangle_figures_read(source, &figures))
        return false;
    contents->inactive += figures.inactive;
    contents->invisible += figures.degenerate;
    add_triangles_to_box(advice, content, &figures);
    judge_mesh(advice, content, source, &figures);
    return !figures.undefined;
}

/* A ray may hit an AABB without volume. */
static bool advise_boxes(struct content_advice *advice, const struct source *source)
{
    for (uint32_t i = 0; i < source->count; i++) {
        struct aabb_record box;
        const enum source_state state = source_aabb(source, i, &box);
        if (state != SOURCE_ACTIVE && state != SOURCE_INACTIVE)
            return false;
        advice->contents.inactive += state == SOURCE_INACTIVE;
        if (state == SOURCE_ACTIVE)
            add_to_box(advice, box.lower, box.upper);
    }
    return true;
}

/* Displaced triangles, and those that move, are not where their vertices are. */
static bool advise_primitives(struct content_advice *advice, const struct content *content)
{
    const struct geometry_view *geometry = content->range->geometry;
    struct builder_geometry described;
    struct source source = {0};
    if ((geometry->build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) ||
        !content->chained || content->chained->has_displacement ||
        !content_describe(content, &described) ||
        !content_open_source(content, &described, &source))
        return false;
    return triangles_in(geometry->geometry) ? advise_triangles(advice, content, &source)
                                            : advise_boxes(advice, &source);
}

/* ---- instances */

static bool advise_instances(struct content_advice *advice, const struct content *content)
{
    struct instance_figures *figures = &advice->instances;
    const struct placing_view view = {
        .geometry = content->range->geometry, .limits = advice->limits, .figures = figures};
    instance_figures_end(figures);
    if (figures->count != content->range->range->primitiveCount)
        return false;
    advice->contents.inactive += figures->inactive;
    advice->contents.invisible += figures->masked;
    advice_judge_placing(&view, keep_advice, advice);
    return true;
}

static void begin_instances(struct build_reader *reader, struct content *content)
{
    instance_figures_begin(&advice_of(reader)->instances, content->range->range->primitiveCount);
}

/* Returns NULL without memory. */
static struct known_box *box_at(struct content_advice *advice, uint32_t use)
{
    while (advice->box_count <= use) {
        if (!ARRAY_HAS_ROOM(advice->boxes, advice->box_count, advice->box_capacity))
            return NULL;
        advice->boxes[advice->box_count++] = (struct known_box){0};
    }
    return &advice->boxes[use];
}

/* Looks up the box of a structure once for all its instances. Returns NULL if it is unknown. */
static const struct figure_box *find_box(struct content_advice *advice,
                                         const struct content *content,
                                         const struct instance_use *use)
{
    const struct structures *structures = content->walk->context->structures;
    const struct instance_uses *uses = content->walk->instances;
    struct known_box *known = box_at(advice, (uint32_t)(use - uses->items));
    if (!known || !structures)
        return NULL;
    if (!known->was_looked_up)
        known->is_known = uses_find_box(structures, use->referenced.id, &known->box);
    known->was_looked_up = true;
    return known->is_known ? &known->box : NULL;
}

static void add_instance(struct build_reader *reader, struct content *content,
                         const VkAccelerationStructureInstanceKHR *instance)
{
    struct content_advice *advice = advice_of(reader);
    struct instance_use other;
    const struct instance_use *use =
        content_find_use(content, instance->accelerationStructureReference, &other);
    instance_figures_add(&advice->instances, instance,
                         use == &other ? NULL : find_box(advice, content, use));
}

/* ---- builds */

/* No ray hits a micromap, and its build has no range, so it has no primitives either. */
static bool is_of_micromap(const struct content *content)
{
    const struct geometry_view *geometry = content->range->geometry;
    return type_is_micromap(geometry->geometry->geometryType);
}

static void judge_geometry(struct content_advice *advice, const struct content *content)
{
    const uint32_t count = content->range->range->primitiveCount;
    advice->contents.primitives += count;
    advice->geometry_count++;
    if (is_of_micromap(content))
        advice->is_unknown = true;
    else if (instances_in(content->range->geometry->geometry))
        advice->is_unknown |= !advise_instances(advice, content);
    else if (count)
        advice->is_unknown |= !advise_primitives(advice, content);
}

/* Leaves one advice for each mistake. If two geometries read the same bytes, one of them is
 * misread, which explains odd triangles. A wrong stride explains both. */
static void leave_reason(struct kept_advice *kept)
{
    if (kept[ADVICE_triangles_do_not_jump].weight)
        kept[ADVICE_vertices_have_one_layout].weight = 0;
    if (!kept[ADVICE_vertices_have_one_layout].weight)
        return;
    kept[ADVICE_no_vertex_is_far_from_all_others].weight = 0;
    kept[ADVICE_coordinates_are_fine_enough].weight = 0;
    kept[ADVICE_most_triangles_can_be_hit].weight = 0;
}

/* Triangles that are misread have moved for another reason. */
static bool is_misread(const struct kept_advice *kept)
{
    return kept[ADVICE_indices_have_their_type].weight ||
           kept[ADVICE_vertices_do_not_overlap].weight || kept[ADVICE_triangles_do_not_jump].weight;
}

/* An AABB may reach infinity. */
static bool is_finite(const struct figure_box *box)
{
    return isfinite(box->upper[0] - box->lower[0]) && isfinite(box->upper[1] - box->lower[1]) &&
           isfinite(box->upper[2] - box->lower[2]);
}

/* If no ray can hit anything, that is one advice, about the structure. A geometry whose range is in
 * a buffer that could not be copied was not read. */
static bool end_advice(struct content_advice *advice, const struct build_parameters *given)
{
    leave_reason(advice->kept);
    if (is_misread(advice->kept))
        drop_refit(advice);
    if (structure_is_hollow(&advice->contents))
        advice->kept[ADVICE_most_triangles_can_be_hit].weight = 0;
    advice->contents.has_box &= !advice->has_unknown_box && is_finite(&advice->contents.box);
    advice->contents.is_top = given->info.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    return !advice->is_unknown && advice->geometry_count == given->info.geometryCount;
}

/* ---- the reader */

static void read_geometry(struct build_reader *reader, struct content *content)
{
    struct advice_reading *reading = (struct advice_reading *)reader;
    if (reading->advice)
        judge_geometry(reading->advice, content);
    if (reading->has_digest)
        digest_add(&reading->digesting, content);
}

void advice_reading_begin(struct advice_reading *reading, const struct build_parameters *given,
                          const struct advice_limits *limits, uint32_t number, bool wants_digest)
{
    *reading =
        (struct advice_reading){.reader.on_geometry = read_geometry, .has_digest = wants_digest};
    if (wants_digest)
        digest_begin(&reading->digesting, given);
    reading->advice = limits ? calloc(1, sizeof(*reading->advice)) : NULL;
    if (!reading->advice)
        return;
    reading->advice->limits = limits;
    reading->advice->number = number;
    reading->reader.on_instances = begin_instances;
    reading->reader.on_instance = add_instance;
}

bool advice_reading_end(struct advice_reading *reading, const struct build_parameters *given)
{
    return reading->advice && end_advice(reading->advice, given);
}

void advice_reading_free(struct advice_reading *reading)
{
    if (!reading->advice)
        return;
    drop_refit(reading->advice);
    free(reading->advice->boxes);
    free(reading->advice);
}
