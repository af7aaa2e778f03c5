/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the structures of one geometry. Rules about its addresses are in input.c. */
#include "src/model/geometry.h"
#include "src/model/formats.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/enabled.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

static const struct device_facts *device_of(const struct geometry_view *geometry)
{
    return geometry->build->call->device;
}

bool geometry_has_its_stype(const struct geometry_view *geometry, struct finding *finding)
{
    VkStructureType type = geometry->geometry->sType;
    return type == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR ||
           violated(finding, "sType",
                    "{} is not VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR",
                    structure_type(type));
}

static bool chain_is_known(const struct geometry_view *geometry, const struct chain_facts *chain,
                           struct finding *finding, const char *field,
                           enum rule (*rule_of)(const struct geometry_view *))
{
    if (chain->unreadable)
        return violated(finding, field, "contains the pointer {}, which is not readable",
                        hex((uint64_t)(uintptr_t)chain->unreadable));
    return !chain->has_stray || device_of(geometry)->newer_than_registry ||
           violated(finding, field,
                    "has a structure of type {}, which the enabled extensions do not allow in this "
                    "chain",
                    structure_type(chain->stray)) ||
           is_reported_with(finding, rule_of(geometry));
}

static bool chain_has_no_duplicates(const struct chain_facts *chain, struct finding *finding,
                                    const char *field)
{
    return !chain->has_duplicate ||
           violated(finding, field, "has more than one structure of type {}",
                    structure_type(chain->duplicate));
}

bool geometry_chain_is_known(const struct geometry_view *geometry, struct finding *finding)
{
    return chain_is_known(geometry, &geometry->chain, finding, "pNext", rule_of_stray);
}

bool geometry_chain_has_no_duplicates(const struct geometry_view *geometry, struct finding *finding)
{
    const bool is_data = geometry->chain.duplicate ==
                         VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR;
    return chain_has_no_duplicates(&geometry->chain, finding, "pNext") ||
           (is_data && type_is_micromap(geometry->geometry->geometryType) &&
            device_of(geometry)->extension.opacity_micromap_khr &&
            also_violates(finding, RULE_micromap_geometry_has_micromap_data));
}

bool geometry_type_is_valid(const struct geometry_view *geometry, struct finding *finding)
{
    VkGeometryTypeKHR type = geometry->geometry->geometryType;
    return geometry_type_is_enabled(device_of(geometry), type) ||
           violated(finding, "geometryType",
                    "{} is not a VkGeometryTypeKHR value of an enabled extension",
                    geometry_type(type));
}

bool geometry_flags_are_valid(const struct geometry_view *geometry, struct finding *finding)
{
    VkGeometryFlagsKHR unknown = geometry->geometry->flags & ~geometry_flags;
    return !unknown || device_of(geometry)->newer_than_registry ||
           violated(finding, "flags", "{} has bits {}, which VkGeometryFlagBitsKHR does not define",
                    geometry_flags_of(geometry->geometry->flags), hex(unknown));
}

bool tlas_geometry_is_instances(const struct geometry_view *geometry, struct finding *finding)
{
    return geometry->build->info->type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ||
           type_is_instances(geometry->geometry->geometryType) ||
           violated(finding, "geometryType",
                    "{} is not VK_GEOMETRY_TYPE_INSTANCES_KHR, in the build of a top-level "
                    "structure",
                    geometry_type(geometry->geometry->geometryType));
}

bool blas_geometry_is_not_instances(const struct geometry_view *geometry, struct finding *finding)
{
    return geometry->build->info->type != VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR ||
           !type_is_instances(geometry->geometry->geometryType) ||
           violated_plainly(finding, "geometryType",
                            "is VK_GEOMETRY_TYPE_INSTANCES_KHR, in the build of a bottom-level "
                            "structure");
}

/* ---- the union
 *
 * If the wrong sType belongs to another member of the union, the application filled the wrong
 * member or gave the wrong geometryType. Any other wrong sType means that it didn't set the
 * sType. */

static VkStructureType data_stype(const struct geometry_view *geometry)
{
    return geometry->geometry->geometry.triangles.sType;
}

static bool is_a_data_stype(VkStructureType type)
{
    return type == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR ||
           type == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR ||
           type == VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
}

static bool member_is_filled(const struct geometry_view *geometry, struct finding *finding,
                             VkStructureType expected, const char *field)
{
    VkStructureType found = data_stype(geometry);
    return found == expected || !is_a_data_stype(found) ||
           violated(finding, field,
                    "is the member that geometryType {} selects, but the union holds a structure "
                    "of type {}",
                    geometry_type(geometry->geometry->geometryType), structure_type(found));
}

static bool member_has_its_stype(const struct geometry_view *geometry, struct finding *finding,
                                 VkStructureType expected, const char *field)
{
    VkStructureType found = data_stype(geometry);
    return found == expected || is_a_data_stype(found) ||
           violated(finding, field, "{} is not {}", structure_type(found),
                    structure_type(expected));
}

/* Defines both rules of a member of the union. */
#define MEMBER_RULES(filled_rule, stype_rule, member, stype)                                       \
    bool filled_rule(const struct geometry_view *geometry, struct finding *finding)                \
    {                                                                                              \
        return !type_is_##member(geometry->geometry->geometryType) ||                              \
               member_is_filled(geometry, finding, stype, "geometry." #member);                    \
    }                                                                                              \
    bool stype_rule(const struct geometry_view *geometry, struct finding *finding)                 \
    {                                                                                              \
        return !type_is_##member(geometry->geometry->geometryType) ||                              \
               member_has_its_stype(geometry, finding, stype, "geometry." #member ".sType");       \
    }

MEMBER_RULES(triangles_member_is_filled, triangles_have_their_stype, triangles,
             VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR)
MEMBER_RULES(aabbs_member_is_filled, aabbs_have_their_stype, aabbs,
             VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR)
MEMBER_RULES(instances_member_is_filled, instances_have_their_stype, instances,
             VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR)

static bool has_no_chain(const struct geometry_view *geometry, struct finding *finding,
                         const void *chain, const char *field)
{
    return !chain || device_of(geometry)->newer_than_registry ||
           violated(finding, field, "{} is not NULL", hex((uint64_t)(uintptr_t)chain));
}

bool aabbs_have_no_chain(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry->geometry);
    return !aabbs || has_no_chain(geometry, finding, aabbs->pNext, "geometry.aabbs.pNext");
}

bool instances_have_no_chain(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        instances_in(geometry->geometry);
    return !instances ||
           has_no_chain(geometry, finding, instances->pNext, "geometry.instances.pNext");
}

bool triangles_chain_is_known(const struct geometry_view *geometry, struct finding *finding)
{
    return chain_is_known(geometry, &geometry->triangles_chain, finding, "geometry.triangles.pNext",
                          rule_of_triangles_stray);
}

bool triangles_chain_has_no_duplicates(const struct geometry_view *geometry,
                                       struct finding *finding)
{
    return chain_has_no_duplicates(&geometry->triangles_chain, finding, "geometry.triangles.pNext");
}

/* ---- triangles */

bool vertex_format_is_valid(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || format_is_known(triangles->vertexFormat) ||
           device_of(geometry)->newer_than_registry ||
           violated(finding, "geometry.triangles.vertexFormat", "{} is not a VkFormat",
                    number((uint32_t)triangles->vertexFormat));
}

bool vertex_format_is_supported(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || geometry->vertex_format_supported != NO ||
           violated(finding, "geometry.triangles.vertexFormat",
                    "{} lacks VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR on "
                    "this device",
                    format(triangles->vertexFormat));
}

bool vertex_stride_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    uint32_t size = triangles ? format_smallest_component(triangles->vertexFormat) : 0;
    return !size || triangles->vertexStride % size == 0 ||
           violated(finding, "geometry.triangles.vertexStride",
                    "{} is not a multiple of the component size of {} ({})",
                    number(triangles->vertexStride), format(triangles->vertexFormat), number(size));
}

bool vertex_stride_fits_32_bits(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles ||
           stride_fits_32_bits(finding, "geometry.triangles.vertexStride", triangles->vertexStride);
}

/* VK_INDEX_TYPE_UINT8 has its own rule. */
bool index_type_is_valid(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || index_type_size(triangles->indexType) ||
           triangles->indexType == VK_INDEX_TYPE_NONE_KHR ||
           device_of(geometry)->newer_than_registry ||
           violated(finding, "geometry.triangles.indexType", "{} is not a VkIndexType",
                    index_type(triangles->indexType));
}

bool index_type_is_16_or_32_bits_or_none(const struct geometry_view *geometry,
                                         struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    return !triangles || triangles->indexType != VK_INDEX_TYPE_UINT8 ||
           violated_plainly(finding, "geometry.triangles.indexType",
                            "is VK_INDEX_TYPE_UINT8, which a build does not accept");
}

/* ---- AABBs */

bool aabb_stride_is_aligned(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry->geometry);
    return !aabbs || aabbs->stride % 8 == 0 ||
           violated(finding, "geometry.aabbs.stride", "{} is not a multiple of 8",
                    number(aabbs->stride));
}

bool aabb_stride_fits_32_bits(const struct geometry_view *geometry, struct finding *finding)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry->geometry);
    return !aabbs || stride_fits_32_bits(finding, "geometry.aabbs.stride", aabbs->stride);
}
