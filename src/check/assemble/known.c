/* SPDX-License-Identifier: Apache-2.0 */
/* Builds that were found valid before: whether a view is of one, and what was known of it. */
#include "src/check/assemble/views.h"
#include "src/state/builds/build_info.h"
#include "src/state/builds/known_builds.h"
#include "src/view/geometry_data.h"

/* The addresses that a geometry has, 0 where it has fewer; false where its data isn't what its type
 * says. */
static inline bool read_inputs(const VkAccelerationStructureGeometryKHR *geometry,
                               VkDeviceAddress inputs[KNOWN_INPUTS])
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(geometry);
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry);
    const VkAccelerationStructureGeometryInstancesDataKHR *instances = instances_in(geometry);
    inputs[0] = inputs[1] = inputs[2] = 0;
    if (triangles) {
        inputs[0] = triangles->vertexData.deviceAddress;
        inputs[1] = triangles->indexData.deviceAddress;
        inputs[2] = triangles->transformData.deviceAddress;
    } else if (aabbs) {
        inputs[0] = aabbs->data.deviceAddress;
    } else if (instances) {
        inputs[0] = instances->data.deviceAddress;
    }
    return triangles || aabbs || instances;
}

/* Those of them that are looked up; NULL: the geometry has no such. */
static inline void list_inputs(struct geometry_view *geometry,
                               struct address_facts *inputs[KNOWN_INPUTS])
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    inputs[0] = triangles ? &geometry->vertex : &geometry->data;
    inputs[1] = triangles && index_type_size(triangles->indexType) ? &geometry->index_data : NULL;
    inputs[2] = triangles && triangles->transformData.deviceAddress ? &geometry->transform : NULL;
}

/* Builds of one geometry, in an array of its own. */
static inline bool can_be_known(const struct build_view *build)
{
    return build->geometry_count == 1 && build->geometries && build->ranges;
}

static inline bool shape_of(const struct build_view *build, struct small_shape *shape)
{
    return small_shape_of(build->info, &build->ranges->primitiveCount,
                          VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, shape);
}

/* ---- recalling */

static inline bool ranges_are_equal(const struct known_build *known,
                                    const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    return !((known->primitive_offset ^ range->primitiveOffset) |
             (known->first_vertex ^ range->firstVertex) |
             (known->transform_offset ^ range->transformOffset));
}

/* All that rules read of a build but its dst. */
static inline bool is_asked_as_before(const struct known_build *known,
                                      const struct build_view *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    const VkAccelerationStructureGeometryKHR *geometry = build->geometries;
    VkDeviceAddress inputs[KNOWN_INPUTS];
    struct small_shape shape;
    return info->sType == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR &&
           geometry->sType == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR &&
           known->mode == info->mode && known->src == info->srcAccelerationStructure &&
           known->scratch_address == info->scratchData.deviceAddress &&
           read_inputs(geometry, inputs) && known->inputs[0] == inputs[0] &&
           known->inputs[1] == inputs[1] && known->inputs[2] == inputs[2] &&
           ranges_are_equal(known, build->ranges) && shape_of(build, &shape) &&
           small_shapes_are_equal(&known->shape, &shape);
}

static inline void recall_accel(const struct known_build *known, struct accel_facts *facts)
{
    *facts = (struct accel_facts){.id = known->accel.id,
                                  .size = known->accel.size,
                                  .begin = known->accel.begin,
                                  .memory = known->accel.memory,
                                  .alive = YES,
                                  .backed = YES,
                                  .handle = known->dst};
}

static inline void recall_address(VkDeviceAddress address, uint64_t buffer_id,
                                  struct address_facts *facts)
{
    *facts = (struct address_facts){
        .address = address, .buffer_id = buffer_id, .status = ADDRESS_IN_BUFFER};
}

bool view_recall(const struct check_context *context, struct known_build *known,
                 struct build_view *build, struct geometry_view *geometry)
{
    if (known->changes != context->changes || !can_be_known(build) ||
        !is_asked_as_before(known, build))
        return false;
    known->in_vain = false;
    recall_accel(known, &build->dst);
    if (known->src)
        recall_accel(known, &build->src);
    else
        build->src.handle = VK_NULL_HANDLE;
    recall_address(known->scratch_address, known->scratch.buffer_id, &build->scratch);
    build->scratch.bytes_left = known->scratch.bytes_left;
    build->scratch.begin = known->scratch.begin;
    build->scratch.memory = known->scratch.memory;
    build->sizes = known->sizes;
    struct address_facts *inputs[KNOWN_INPUTS];
    list_inputs(geometry, inputs);
#pragma GCC unroll 3 /* so that no list is written */
    for (int i = 0; i < KNOWN_INPUTS; i++)
        if (inputs[i])
            recall_address(known->inputs[i], known->input_buffers[i], inputs[i]);
    return true;
}

/* ---- keeping */

/* Whether what is known of a structure stays while resources_generation does; of none in a sparse
 * buffer is it known here whether it is backed. */
static bool accel_is_settled(const struct accel_facts *accel)
{
    return accel->alive == YES && accel->details_known && accel->backed == YES;
}

/* Likewise. */
static bool address_is_settled(const struct address_facts *address)
{
    return address->status == ADDRESS_IN_BUFFER && !address->is_sparse && !address->is_shared;
}

static bool is_settled(const struct build_view *build,
                       struct address_facts *const inputs[KNOWN_INPUTS])
{
    for (int i = 0; i < KNOWN_INPUTS; i++)
        if (inputs[i] && !address_is_settled(inputs[i]))
            return false;
    return build->sizes.known && !build->micromaps && accel_is_settled(&build->dst) &&
           (!build->src.handle || build->src.handle == build->dst.handle) &&
           address_is_settled(&build->scratch);
}

void view_keep_known(const struct check_context *context, const struct build_view *build,
                     struct geometry_view *geometry)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = build->info;
    VkDeviceAddress addresses[KNOWN_INPUTS];
    struct address_facts *inputs[KNOWN_INPUTS];
    struct small_shape shape;
    if (!can_be_known(build))
        return;
    list_inputs(geometry, inputs);
    if (!is_settled(build, inputs) || !read_inputs(geometry->geometry, addresses) ||
        !shape_of(build, &shape))
        return;
    if (known_builds_wants_trim(context->known))
        known_builds_trim(context->known, resources_accel_count(context->resources));
    struct known_build *known = known_builds_room(context->known, info->dstAccelerationStructure);
    if (!known)
        return;
    known->changes = context->changes;
    known->shape = shape;
    for (int i = 0; i < KNOWN_INPUTS; i++) {
        known->inputs[i] = addresses[i];
        known->input_buffers[i] = inputs[i] ? inputs[i]->buffer_id : 0;
    }
    known->src = info->srcAccelerationStructure;
    known->scratch_address = info->scratchData.deviceAddress;
    known->mode = info->mode;
    known->primitive_offset = build->ranges->primitiveOffset;
    known->first_vertex = build->ranges->firstVertex;
    known->transform_offset = build->ranges->transformOffset;
    known->accel.id = build->dst.id;
    known->accel.size = build->dst.size;
    known->accel.begin = build->dst.begin;
    known->accel.memory = build->dst.memory;
    known->scratch.buffer_id = build->scratch.buffer_id;
    known->scratch.bytes_left = build->scratch.bytes_left;
    known->scratch.begin = build->scratch.begin;
    known->scratch.memory = build->scratch.memory;
    known->sizes = build->sizes;
}
