/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the triangles of micromaps, and the indices into micromaps. */
#include "src/check/content/micromap.h"

#include <string.h>

#include "src/check/assemble/views.h"
#include "src/model/geometry.h"
#include "src/rules/micromap/shared.h"
#include "src/state/builds/built.h"

static void read_triangles(struct content *content, VkDeviceOrHostAddressConstKHR triangles,
                           uint64_t count, uint64_t stride, uint64_t data_left)
{
    struct micromap_triangle_view view = {.geometry = content->range->geometry,
                                          .data_left = data_left};
    const uint8_t *first = NULL;
    if (stride >= sizeof(view.triangle)) /* a smaller stride is an error that has its own rule */
        first = content_find(content, triangles, 0, count, stride, sizeof(view.triangle));
    for (; first && view.index < count; view.index++) {
        memcpy(&view.triangle, first + view.index * stride, sizeof(view.triangle));
        content_walk_micromap_triangle(content, &view);
    }
}

static uint64_t data_left(const struct input_memory *memory,
                          const struct micromap_parameters *micromap)
{
    return memory->find_left ? memory->find_left(memory->context, micromap->data.deviceAddress) : 0;
}

/* Sets the triangle count if the structure was last built as a micromap. */
static void note_built(const struct built *built, struct opacity_index_view *view)
{
    if (!built || built->state != BUILT_BEFORE || !built->shapes || !built->shapes->count ||
        built->type != VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)
        return;
    view->count_known = built->shapes->items[0].count_known;
    view->triangle_count = built->shapes->items[0].primitive_count;
}

static void read_indices(struct content *content,
                         const VkAccelerationStructureTrianglesOpacityMicromapEXT *opacity,
                         const struct built *used)
{
    uint32_t count = content->range->range->primitiveCount;
    uint32_t size = index_type_size(opacity->indexType);
    struct opacity_index_view view = {.geometry = content->range->geometry,
                                      .micromap = (uint64_t)opacity->micromap,
                                      .base_triangle = opacity->baseTriangle,
                                      .bits = size * 8};
    if (!size)
        return;
    note_built(used, &view);
    const uint8_t *first =
        content_find(content, opacity->indexBuffer, 0, count, opacity->indexStride, size);
    for (; first && view.primitive < count; view.primitive++) {
        view.index = content_read_index(first + view.primitive * opacity->indexStride, size, 0);
        content_walk_opacity_index(content, &view);
    }
}

void content_check_micromaps(struct walk *walk, const struct range_view *range,
                             const struct input_memory *memory, const struct chained_input *chained,
                             const struct built *used)
{
    const VkAccelerationStructureGeometryKHR *geometry = range->geometry->geometry;
    struct content content = {.walk = walk, .range = range, .memory = memory};
    if (type_is_micromap(geometry->geometryType))
        read_triangles(&content, chained->micromap.triangles,
                       micromap_parameters_count(&chained->micromap), chained->micromap.stride,
                       data_left(memory, &chained->micromap));
    if (triangles_in(geometry) &&
        chained->opacity.sType ==
            VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR)
        read_indices(&content, &chained->opacity, used);
    content_report(&content);
}

/* ---- host builds */

static uint64_t find_mapped(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    const struct check_context *checked = context;
    *bytes = NULL;
    size = resources_find_mapped(checked->resources, address, size, bytes);
    return readable_extent(checked->readable, *bytes, (size_t)size);
}

void check_host_micromap(struct walk *walk, const struct geometry_view *geometry)
{
    const struct input_memory memory = {.find = find_mapped, .context = walk->context};
    const struct range_view range = {.geometry = geometry};
    struct content content = {.walk = walk, .range = &range, .memory = &memory};
    struct micromap_data_view view;
    if (!view_micromap_data(walk->context, geometry, &view) ||
        view.usages.count != view.data->usageCountsCount)
        return;
    read_triangles(&content,
                   (VkDeviceOrHostAddressConstKHR){.deviceAddress = view.data->triangleArray},
                   usages_sum(&view.usages), view.data->triangleArrayStride, 0);
    content_report(&content);
}
