/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules about single addresses and about host memory. */
#include "src/check/call/parts.h"

#include "src/check/assemble/views.h"
#include "src/check/walk/rows.h"
#include "src/model/geometry.h"
#include "src/model/inputs.h"
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
    for (enum input_role role = INPUT_VERTEX; role <= INPUT_MATRIX; role++)
        check_input(walk, geometry, role, input_facts(geometry, role));
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

/* If there are indices, they determine which vertices are read; then only the first byte counts, as
 * it does of instances with motion, which other rules read. */
static struct host_bytes find_input(struct check_context *context,
                                    const struct geometry_input *input, bool is_read)
{
    const void *address = input->address.hostAddress;
    if (!is_read || input->offset == UINT64_MAX)
        return (struct host_bytes){.address = address};
    if (input->is_chosen)
        return host_memory_bytes(context, address, 0, 1, 0, 1);
    if (input->role == INPUT_INSTANCES && input->stride != input->size)
        return host_memory_bytes(context, address, input->offset, 1, 1, 1);
    return host_memory_bytes(context, address, input->offset, input->count, input->stride,
                             input->size ? input->size : 1);
}

static void find_inputs(struct check_context *context, const struct range_view *range,
                        struct host_geometry_view *view)
{
    static const VkAccelerationStructureBuildRangeInfoKHR one = {.primitiveCount = 1};
    const bool is_read = range->range && range->range->primitiveCount;
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const uint32_t count =
        inputs_of_geometry(range->geometry->build->info->flags, range->geometry->geometry, NULL,
                           is_read ? range->range : &one, inputs);
    for (uint32_t i = 0; i < count; i++)
        view->inputs[inputs[i].role] = find_input(context, &inputs[i], is_read);
}

static WALK_ALL(host_geometry)

    void check_host_geometry(struct walk *walk, const struct range_view *range)
{
    const VkAccelerationStructureGeometryKHR *geometry = range->geometry->geometry;
    struct host_geometry_view view = {.geometry = range->geometry};
    if (triangles_in(geometry) || aabbs_in(geometry) || instances_in(geometry))
        find_inputs(walk->context, range, &view);
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
