/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the buffers that contain the addresses of a build. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"

static struct value buffer(const struct address_view *address)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(address->facts->buffer));
}

/* Transforms, scratch and build ranges have their own rules: 03808, 12258, 12259 and 03646. */
bool input_address_is_in_a_buffer(const struct address_view *address, struct finding *finding)
{
    return address->facts->status != ADDRESS_NOWHERE || !address->geometry ||
           address->role == INPUT_MATRIX ||
           violated(finding, input_field(address->role),
                    "{} is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, address->facts->address));
}

bool input_buffer_is_bound(const struct address_view *address, struct finding *finding)
{
    return address->facts->status != ADDRESS_UNBOUND ||
           violated(finding, input_field(address->role),
                    "{} is in {}, which is not bound to memory, or whose memory was freed",
                    hex(address->facts->address), buffer(address));
}

static bool has_build_input_usage(const struct address_view *address, struct finding *finding)
{
    const struct address_facts *facts = address->facts;
    return facts->status != ADDRESS_IN_BUFFER ||
           (facts->usage &
            VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR) ||
           violated(finding, input_field(address->role),
                    "{} is in {}, which was created with usage {}, without "
                    "VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR",
                    hex(facts->address), buffer(address), buffer_usage(facts->usage));
}

/* The valid usage names these members only, not those of extension structures. */
static bool is_input_of_geometry(enum input_role role)
{
    return role <= INPUT_LAST_PLAIN;
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
