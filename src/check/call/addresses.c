/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules about single addresses. */
#include "src/check/call/addresses.h"

#include "src/view/geometry_data.h"

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
