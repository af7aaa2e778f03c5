/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules about single addresses and about host memory. */
#include "src/check/call/parts.h"

#include "src/check/assemble/views.h"
#include "src/check/walk/rows.h"
#include "src/view/formats.h"
#include "src/view/geometry_data.h"
#include "src/view/view.h"

static void check_input(struct walk *walk, const struct geometry_view *geometry,
                        enum input_role role, const struct address_facts *facts)
{
    const struct address_view address = {
        .build = geometry->build, .geometry = geometry, .role = role, .facts = facts};
    walk_address(walk, &address, LEVEL_STATE);
}

void check_geometry_addresses(struct walk *walk, const struct geometry_view *geometry)
{
    const struct chained_inputs *chained = geometry->chained;
    check_input(walk, geometry, INPUT_VERTEX, &geometry->vertex);
    check_input(walk, geometry, INPUT_INDEX, &geometry->index_data);
    check_input(walk, geometry, INPUT_MATRIX, &geometry->transform);
    check_input(walk, geometry, data_role(geometry), &geometry->data);
    for (uint32_t i = 0; chained && i < chained->count; i++)
        check_input(walk, geometry, chained->items[i].role, &chained->items[i].facts);
}

/* A build that needs no scratch may have any scratch address. */
void check_scratch_address(struct walk *walk, const struct build_view *build)
{
    const struct address_view address = {
        .build = build, .role = INPUT_SCRATCH, .facts = &build->scratch};
    if (build->sizes.known && build_scratch_size(build))
        walk_address(walk, &address, LEVEL_STATE);
}

/* A build without geometries reads no build range. */
static void check_indirect_address(struct walk *walk, const struct indirect_view *indirect)
{
    const struct address_view address = {
        .build = indirect->build, .role = INPUT_INDIRECT, .facts = &indirect->facts};
    if (indirect->build->info->geometryCount)
        walk_address(walk, &address, LEVEL_STATE);
}

void check_indirect(struct walk *walk, const struct build_view *build, bool with_state)
{
    struct check_context *context = walk->context;
    const struct call_view *call = build->call;
    struct indirect_view indirect = {
        .build = build,
        .address =
            call->indirect_addresses_readable ? &call->indirect_addresses[build->index] : NULL,
        .stride = call->indirect_strides_readable ? &call->indirect_strides[build->index] : NULL,
    };
    walk_indirect(walk, &indirect, LEVEL_PARAMETERS);
    if (!with_state || !indirect.address)
        return;
    resources_look_up_address(context->resources, *indirect.address, &indirect.facts);
    walk_indirect(walk, &indirect, LEVEL_STATE);
    check_indirect_address(walk, &indirect);
    if (context->recorder)
        context->recorder->record_indirect(context->user, &indirect);
}

/* ---- Host builds: which of their host memory is readable. */

/* Returns how many bytes of a vertex a build reads, without a fourth component. Returns 1 for
 * unknown formats. */
static uint32_t vertex_size(VkFormat format)
{
    uint32_t size = format_size(format), component = format_smallest_component(format);
    if (component && size == 4 * component)
        return 3 * component;
    return size ? size : 1;
}

/* If there are indices, they determine which vertices are read; then only the first byte counts. */
static struct host_bytes find_vertices(struct check_context *context,
                                       const VkAccelerationStructureGeometryTrianglesDataKHR *t,
                                       const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const void *address = t->vertexData.hostAddress;
    uint64_t first;
    if (index_type_size(t->indexType))
        return host_memory_bytes(context, address, 0, range->primitiveCount ? 1 : 0, 0, 1);
    if (__builtin_mul_overflow(t->vertexStride, (uint64_t)range->firstVertex, &first) ||
        __builtin_add_overflow(first, (uint64_t)range->primitiveOffset, &first))
        return (struct host_bytes){.address = address};
    return host_memory_bytes(context, address, first, (uint64_t)range->primitiveCount * 3,
                             t->vertexStride, vertex_size(t->vertexFormat));
}

static void view_triangles(struct check_context *context,
                           const VkAccelerationStructureGeometryTrianglesDataKHR *t,
                           const VkAccelerationStructureBuildRangeInfoKHR *range,
                           struct host_geometry_view *view)
{
    uint32_t index_size = index_type_size(t->indexType);
    view->vertices = find_vertices(context, t, range);
    view->transform =
        host_memory_bytes(context, t->transformData.hostAddress, range->transformOffset,
                          range->primitiveCount ? 1 : 0, 0, sizeof(VkTransformMatrixKHR));
    if (index_size)
        view->indices =
            host_memory_bytes(context, t->indexData.hostAddress, range->primitiveOffset,
                              (uint64_t)range->primitiveCount * 3, index_size, index_size);
}

/* Only the first byte of instances with motion, which other rules read. */
static struct host_bytes
find_instances(struct check_context *context, const struct build_view *build,
               const VkAccelerationStructureGeometryInstancesDataKHR *instances,
               const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    uint64_t size =
        instances->arrayOfPointers ? sizeof(void *) : sizeof(VkAccelerationStructureInstanceKHR);
    uint64_t count = range->primitiveCount;
    if (!instances->arrayOfPointers &&
        (build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV))
        count = count ? 1 : 0, size = 1;
    return host_memory_bytes(context, instances->data.hostAddress, range->primitiveOffset, count,
                             size, size);
}

static WALK_ALL(host_geometry)

    void check_host_geometry(struct walk *walk, const struct range_view *range)
{
    static const VkAccelerationStructureBuildRangeInfoKHR nothing = {0};
    const VkAccelerationStructureGeometryKHR *geometry = range->geometry->geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *read = range->range ? range->range : &nothing;
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(geometry);
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry);
    const VkAccelerationStructureGeometryInstancesDataKHR *instances = instances_in(geometry);
    struct host_geometry_view view = {.geometry = range->geometry};
    if (triangles)
        view_triangles(walk->context, triangles, read, &view);
    if (aabbs)
        view.data =
            host_memory_bytes(walk->context, aabbs->data.hostAddress, read->primitiveOffset,
                              read->primitiveCount, aabbs->stride, sizeof(VkAabbPositionsKHR));
    if (instances)
        view.data = find_instances(walk->context, range->geometry->build, instances, read);
    const struct location location = walk_location(range->geometry, SUBJECT_GEOMETRY);
    walk_host_geometry(walk, &view, &location);
}

static WALK_ALL(host_build)

    void check_host_build(struct walk *walk, const struct build_view *build)
{
    struct host_build_view view = {.build = build};
    view.scratch.address = build->info->scratchData.hostAddress;
    view.scratch.begin = (uint64_t)(uintptr_t)view.scratch.address;
    if (build->sizes.known)
        view.scratch.size = build_scratch_size(build);
    view.scratch.unreadable =
        !host_memory_is_there(walk->context, view.scratch.address, view.scratch.size);
    const struct location location = {
        .command = COMMAND_HOST, .subject = SUBJECT_BUILD, .build = build->index};
    walk_host_build(walk, &view, &location);
}
