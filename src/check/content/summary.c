/* SPDX-License-Identifier: Apache-2.0 */
/* Stores the inputs that later updates are compared with, using the reference builder's reader. */
#include <stdlib.h>
#include <string.h>

#include "src/bvh/input/source.h"
#include "src/check/content/content.h"
#include "src/model/geometry.h"
#include "src/snapshots/build_input.h"

bool content_open_source(const struct content *content, const struct builder_geometry *described,
                         struct source *source)
{
    const VkAccelerationStructureBuildRangeInfoKHR range = {
        .primitiveCount = content->range->range->primitiveCount};
    return source_open(source, false, described, &range);
}

static bool formats_are_known(const struct builder_triangles *triangles)
{
    return vertex_format_find(triangles->vertex_format) &&
           (index_type_size(triangles->index_type) ||
            triangles->index_type == VK_INDEX_TYPE_NONE_KHR);
}

/* Ignores transforms, because they don't affect which triangles are inactive. */
bool content_describe(const struct content *content, struct builder_geometry *described)
{
    const VkAccelerationStructureGeometryKHR *geometry = content->range->geometry->geometry;
    struct builder_triangles *triangles = &described->triangles;
    build_input_describe(geometry, NULL, described);
    if (aabbs_in(geometry))
        described->aabbs.size = content_find_some_input(
            content, content_input(content, INPUT_AABBS), &described->aabbs.data);
    if (!triangles_in(geometry) || !formats_are_known(triangles))
        return aabbs_in(geometry);
    triangles->indices_size =
        content_find_some_input(content, content_input(content, INPUT_INDEX), &triangles->indices);
    triangles->vertices_size = content_find_some_input(
        content, content_input(content, INPUT_VERTEX), &triangles->vertices);
    return true;
}

static enum source_state read_state(const struct source *source, uint32_t primitive,
                                    VkGeometryTypeKHR type)
{
    struct triangle_record triangle;
    struct aabb_record box;
    return type_is_aabbs(type) ? source_aabb(source, primitive, &box)
                               : source_triangle(source, primitive, &triangle);
}

static uint64_t *make_bits(uint32_t count)
{
    return calloc((size_t)count / 64 + 1, sizeof(uint64_t));
}

static void set_inactive(uint64_t *inactive, uint32_t primitive)
{
    inactive[primitive / 64] |= UINT64_C(1) << primitive % 64;
}

/* Returns one bit for each primitive, set if it is inactive. Returns NULL if the state of any
 * primitive is unknown, if the build has motion, or if there is no memory. */
static uint64_t *find_inactive(const struct content *content)
{
    struct builder_geometry described;
    struct source source = {0};
    uint32_t count = content->range->range->primitiveCount;
    if ((content->range->geometry->build->info->flags &
         VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) ||
        !content_describe(content, &described) ||
        !content_open_source(content, &described, &source))
        return NULL;
    uint64_t *inactive = make_bits(count);
    if (triangles_in(content->range->geometry->geometry) &&
        source_triangles_are_active(&source, content->indices.max))
        return inactive;
    for (uint32_t i = 0; inactive && i < count; i++) {
        enum source_state state = read_state(&source, i, described.type);
        if (state == SOURCE_INACTIVE) {
            set_inactive(inactive, i);
        } else if (state != SOURCE_ACTIVE) {
            free(inactive);
            return NULL;
        }
    }
    return inactive;
}

static void retain_indices(const struct content_indices *indices, struct geometry_inputs *retained)
{
    if (!indices->bytes || !indices->count)
        return;
    retained->indices =
        indices->same
            ? (struct kept_indices *)kept_block_share(&indices->same->block)
            : kept_indices_create(indices->bytes, indices->count * indices->size, indices->max);
}

/* An update keeps the tree that its source was built with. */
static void retain_kept(const struct content *content)
{
    const struct geometry_inputs *source =
        build_inputs_of(content->walk->source_inputs, content->range->geometry->index);
    if (source && source->kept)
        content->retained->kept = kept_block_share(source->kept);
}

static struct geometry_inputs *retained_inputs_of(struct content *content)
{
    const struct build_view *build = content->range->geometry->build;
    struct walk *walk = content->walk;
    bool is_retained =
        (build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) ||
        build_is_update(build->info);
    if (build->call->command == COMMAND_HOST && is_retained && !walk->inputs)
        walk->inputs = build_inputs_create(build->geometry_count);
    return walk->inputs ? &walk->inputs->items[content->range->geometry->index] : NULL;
}

void content_retain_count(struct content *content)
{
    struct geometry_inputs *retained = content->retained = retained_inputs_of(content);
    if (!retained)
        return;
    retained->count_known = true;
    retained->primitive_count = content->range->range->primitiveCount;
}

void content_retain_inputs(const struct content *content)
{
    if (!content->retained)
        return;
    content->retained->inactive = find_inactive(content);
    retain_indices(&content->indices, content->retained);
    retain_kept(content);
}

void content_retain_instance(const struct content *content, uint32_t index, uint64_t reference)
{
    struct geometry_inputs *retained = content->retained;
    if (!retained || content->has_gaps)
        return;
    if (!retained->inactive)
        retained->inactive = make_bits(retained->primitive_count);
    if (retained->inactive && !reference)
        set_inactive(retained->inactive, index);
}

void content_retain_unknown_instance(struct content *content)
{
    content->has_gaps = true;
    if (!content->retained)
        return;
    free(content->retained->inactive);
    content->retained->inactive = NULL;
}

void content_release_inputs(struct walk *walk)
{
    build_inputs_release(walk->inputs);
    walk->inputs = NULL;
}
