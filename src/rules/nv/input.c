/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the buffers of one VkGeometryNV. The facts of a buffer that isn't given, or that the
 * geometry doesn't use, are all unknown. */
#include "src/model/input_names.h"
#include "src/rules/nv/objects.h"
#include "src/rules/predicates.h"

/* An offset is in its buffer if less than its size. */
static bool is_in_buffer(const struct nv_geometry_view *geometry, struct finding *finding,
                         enum input_role role)
{
    const struct buffer_facts *facts = &geometry->found[role];
    const VkDeviceSize offset = geometry->places[role].offset;
    return nv_geometry_is_empty(geometry) || facts->alive != YES || offset < facts->size ||
           violated(finding, input_name(role, INPUT_OFFSET_OF_NV),
                    "{} is not less than the size of {} ({})", number(offset),
                    nv_buffer(facts->handle), count_of(facts->size, "byte"));
}

/* Defines the rules about the buffer and the offset of an input. */
#define PLACE_RULES(buffer_rule, offset_rule, role)                                                \
    bool buffer_rule(const struct nv_geometry_view *nv_geometry, struct finding *finding)          \
    {                                                                                              \
        return nv_is_a_buffer(&nv_geometry->found[role], finding, input_name(role, INPUT_OF_NV));  \
    }                                                                                              \
    bool offset_rule(const struct nv_geometry_view *nv_geometry, struct finding *finding)          \
    {                                                                                              \
        return is_in_buffer(nv_geometry, finding, role);                                           \
    }

PLACE_RULES(nv_vertex_data_is_a_valid_buffer, nv_vertex_offset_is_in_the_buffer, INPUT_VERTEX)
PLACE_RULES(nv_index_data_is_null_or_a_valid_buffer, nv_index_offset_is_in_the_buffer, INPUT_INDEX)
PLACE_RULES(nv_transform_data_is_a_valid_buffer, nv_transform_offset_is_in_the_buffer, INPUT_MATRIX)
PLACE_RULES(nv_aabb_data_is_a_valid_buffer, nv_aabb_offset_is_in_the_buffer, INPUT_AABBS)

/* All buffers belong to one device, this or another: another rule covers the command's own
 * handles. */
bool nv_triangles_buffers_share_the_device(const struct nv_geometry_view *nv_geometry,
                                           struct finding *finding)
{
    const struct buffer_facts *found = nv_geometry->found;
    for (enum input_role i = INPUT_VERTEX; i <= INPUT_MATRIX; i++)
        for (enum input_role j = INPUT_VERTEX; j <= INPUT_MATRIX; j++)
            if (found[i].of_another_device && found[j].alive == YES)
                return violated(finding, input_name(i, INPUT_OF_NV),
                                "{} was created from another VkDevice than {}",
                                nv_buffer(found[i].handle), nv_buffer(found[j].handle));
    return true;
}

/* ---- the end of buffers */

/* Other rules are about an offset behind the buffer's end, and about strides that do not fit in 32
 * bits. */
static bool is_read_within(const struct buffer_facts *facts, struct finding *finding,
                           VkDeviceSize offset, const struct geometry_input *input)
{
    if (facts->alive != YES || offset >= facts->size || !input->size || input->stride > UINT32_MAX)
        return true;
    const uint64_t bytes = (input->count - 1) * input->stride + input->size;
    return bytes <= facts->size - offset ||
           violated(finding, input_name(input->role, INPUT_OFFSET_OF_NV),
                    "{} makes the build read {} of {}, {} past its end", number(offset),
                    count_of(bytes, "byte"), nv_buffer(facts->handle),
                    count_of(bytes - (facts->size - offset), "byte"));
}

/* Returns whether all that a build certainly reads of a geometry lies in the buffers `found` by
 * role. */
static bool are_read_within(const struct build_view *build, uint32_t geometry,
                            const struct nv_place *places, const struct buffer_facts *found,
                            struct finding *finding)
{
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const uint32_t count = geometry < build->geometry_count
                               ? inputs_of_geometry(0, &build->geometries[geometry], NULL,
                                                    &build->ranges[geometry], inputs)
                               : 0;
    for (uint32_t i = 0; i < count; i++)
        if (!inputs[i].is_chosen && !is_read_within(&found[inputs[i].role], finding,
                                                    places[inputs[i].role].offset, &inputs[i]))
            return false;
    return true;
}

/* Other rules are about too many triangles. */
bool nv_geometry_is_read_within_its_buffers(const struct nv_geometry_view *nv_geometry,
                                            struct finding *finding)
{
    const struct nv_call_view *call = nv_geometry->call;
    return nv_geometry_is_empty(nv_geometry) ||
           (nv_geometry->triangles && nv_geometry->index < call->build.geometry_count &&
            call->build.ranges[nv_geometry->index].primitiveCount >
                call->call->device->nv_limits.maxTriangleCount) ||
           are_read_within(&call->build, nv_geometry->index, nv_geometry->places,
                           nv_geometry->found, finding);
}

bool nv_instances_are_read_within_their_buffer(const struct nv_call_view *nv_call,
                                               struct finding *finding)
{
    const VkAccelerationStructureInfoNV *info = nv_call->info;
    const struct nv_place places[NV_PLACES] = {
        [INPUT_INSTANCES] = {.offset = nv_call->instance_offset}};
    const struct buffer_facts found[NV_PLACES] = {[INPUT_INSTANCES] = nv_call->instance_facts};
    return !info || info->type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV ||
           info->instanceCount > nv_call->call->device->nv_limits.maxInstanceCount ||
           are_read_within(&nv_call->build, 0, places, found, finding);
}
