/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about what the addresses of a build lead to. */
#include "src/rules/address.h"

#include "src/rules/input.h"
#include "src/rules/predicates.h"

/* ---- the addresses ---- */

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
    bool is_aabbs = geometry->geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR;
    check_input(walk, geometry, INPUT_VERTEX, &geometry->vertex);
    check_input(walk, geometry, INPUT_INDEX, &geometry->index_data);
    check_input(walk, geometry, INPUT_TRANSFORM, &geometry->transform);
    check_input(walk, geometry, is_aabbs ? INPUT_AABBS : INPUT_INSTANCES, &geometry->data);
    for (uint32_t i = 0; chained && i < chained->count; i++)
        check_input(walk, geometry, chained->items[i].role, &chained->items[i].facts);
}

/* Scratch of which a build needs no bytes may be anywhere. */
void check_scratch_address(struct walk *walk, const struct build_view *build)
{
    const struct address_view address = {
        .build = build, .role = INPUT_SCRATCH, .facts = &build->scratch};
    if (build->sizes.known && build_scratch_size(build))
        walk_address(walk, &address, LEVEL_STATE);
}

/* Of a build without geometries no build range is read. */
void check_indirect_address(struct walk *walk, const struct indirect_view *indirect)
{
    const struct address_view address = {
        .build = indirect->build, .role = INPUT_INDIRECT, .facts = &indirect->facts};
    if (indirect->build->info->geometryCount)
        walk_address(walk, &address, LEVEL_STATE);
}

/* ---- the rules ---- */

static struct value buffer(const struct address_view *address)
{
    return object(VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)address->facts->buffer);
}

/* Transforms, scratch and build ranges have rules of their own for that: 03808, 12258, 12259 and
 * 03646. */
bool input_address_is_in_a_buffer(const struct address_view *address, struct finding *finding)
{
    return address->facts->status != ADDRESS_NOWHERE || !address->geometry ||
           address->role == INPUT_TRANSFORM ||
           violated(finding, input_field(address->role),
                    "{} is in no buffer whose address was retrieved", hex(address->facts->address));
}

bool input_buffer_is_bound(const struct address_view *address, struct finding *finding)
{
    return address->facts->status != ADDRESS_UNBOUND ||
           violated(finding, input_field(address->role),
                    "{} is in {}, which is not bound to live memory", hex(address->facts->address),
                    buffer(address));
}

static bool has_build_input_usage(const struct address_view *address, struct finding *finding)
{
    const struct address_facts *facts = address->facts;
    return facts->status != ADDRESS_IN_BUFFER ||
           (facts->usage &
            VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR) ||
           violated(finding, input_field(address->role),
                    "{} is in {}, created with usage {}, without "
                    "VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR",
                    hex(facts->address), buffer(address), hex(facts->usage));
}

/* The sentence names these members; those of the structures of extensions are not among them. */
static bool is_input_of_geometry(enum input_role role)
{
    return role == INPUT_VERTEX || role == INPUT_INDEX || role == INPUT_TRANSFORM ||
           role == INPUT_AABBS || role == INPUT_INSTANCES;
}

bool input_buffer_has_build_input_usage(const struct address_view *address, struct finding *finding)
{
    return !is_input_of_geometry(address->role) || has_build_input_usage(address, finding);
}

bool micromap_buffers_have_build_input_usage(const struct address_view *address,
                                             struct finding *finding)
{
    return (address->role != INPUT_MICROMAP_DATA && address->role != INPUT_MICROMAP_TRIANGLES) ||
           has_build_input_usage(address, finding);
}
