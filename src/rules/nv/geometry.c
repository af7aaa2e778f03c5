/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about VkGeometryNV and the structures in it. */
#include "src/model/geometry.h"
#include "src/model/formats.h"
#include "src/model/input_names.h"
#include "src/rules/nv/objects.h"
#include "src/rules/predicates.h"
#include "src/view/enabled.h"
#include "src/view/names.h"

#define TRIANGLES "geometry.triangles."
#define BOXES "geometry.aabbs."

static const struct device_facts *device_of(const struct nv_geometry_view *geometry)
{
    return geometry->call->call->device;
}

static bool has_no_chain(const struct nv_geometry_view *geometry, struct finding *finding,
                         const char *field, const void *chain)
{
    return !chain || device_of(geometry)->newer_than_registry ||
           violated(finding, field, "{} is not NULL", hex((uint64_t)(uintptr_t)chain));
}

bool nv_geometry_has_its_stype(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    VkStructureType type = nv_geometry->geometry->sType;
    return type == VK_STRUCTURE_TYPE_GEOMETRY_NV ||
           violated(finding, "sType", "{} is not VK_STRUCTURE_TYPE_GEOMETRY_NV",
                    structure_type(type));
}

bool nv_geometry_has_no_chain(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return has_no_chain(nv_geometry, finding, "pNext", nv_geometry->geometry->pNext);
}

static bool is_nv_type(VkGeometryTypeKHR type)
{
    return type_is_triangles(type) || type_is_aabbs(type);
}

bool nv_geometry_type_is_valid(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    VkGeometryTypeKHR type = nv_geometry->geometry->geometryType;
    return geometry_type_is_enabled(device_of(nv_geometry), type) ||
           violated(finding, "geometryType",
                    "{} is not a VkGeometryTypeKHR value of an enabled extension",
                    geometry_type(type));
}

/* Values outside the enumeration have their own rule. */
bool nv_geometry_type_is_triangles_or_aabbs(const struct nv_geometry_view *nv_geometry,
                                            struct finding *finding)
{
    VkGeometryTypeKHR type = nv_geometry->geometry->geometryType;
    return is_nv_type(type) || !geometry_type_is_enabled(device_of(nv_geometry), type) ||
           device_of(nv_geometry)->newer_than_registry ||
           violated(finding, "geometryType",
                    "{} is neither VK_GEOMETRY_TYPE_TRIANGLES_NV nor VK_GEOMETRY_TYPE_AABBS_NV",
                    geometry_type(type));
}

bool nv_geometry_flags_are_valid(const struct nv_geometry_view *nv_geometry,
                                 struct finding *finding)
{
    return geometry_flags_are_valid(&nv_geometry->translated, finding);
}

/* ---- the members of VkGeometryDataNV
 *
 * Both members must be valid. If both have a wrong sType, the application filled neither. If one
 * has a wrong sType, the id depends on whether geometryType selects it. */

static VkStructureType triangles_stype(const struct nv_geometry_view *geometry)
{
    return geometry->geometry->geometry.triangles.sType;
}

static VkStructureType aabbs_stype(const struct nv_geometry_view *geometry)
{
    return geometry->geometry->geometry.aabbs.sType;
}

static bool triangles_are_typed(const struct nv_geometry_view *geometry)
{
    return triangles_stype(geometry) == VK_STRUCTURE_TYPE_GEOMETRY_TRIANGLES_NV;
}

static bool aabbs_are_typed(const struct nv_geometry_view *geometry)
{
    return aabbs_stype(geometry) == VK_STRUCTURE_TYPE_GEOMETRY_AABB_NV;
}

static bool is_of_type(const struct nv_geometry_view *geometry, VkGeometryTypeKHR type)
{
    return geometry->geometry->geometryType == type;
}

bool nv_geometry_data_is_filled(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return !is_nv_type(nv_geometry->geometry->geometryType) || triangles_are_typed(nv_geometry) ||
           aabbs_are_typed(nv_geometry) ||
           violated(finding, "geometry",
                    "is not filled: triangles.sType is {}, and aabbs.sType is {}",
                    structure_type(triangles_stype(nv_geometry)),
                    structure_type(aabbs_stype(nv_geometry)));
}

static bool only_triangles_stype_is_wrong(const struct nv_geometry_view *geometry,
                                          VkGeometryTypeKHR type)
{
    return is_of_type(geometry, type) && !triangles_are_typed(geometry) &&
           aabbs_are_typed(geometry);
}

static bool only_aabbs_stype_is_wrong(const struct nv_geometry_view *geometry,
                                      VkGeometryTypeKHR type)
{
    return is_of_type(geometry, type) && triangles_are_typed(geometry) &&
           !aabbs_are_typed(geometry);
}

bool nv_triangles_have_their_stype(const struct nv_geometry_view *nv_geometry,
                                   struct finding *finding)
{
    return !only_triangles_stype_is_wrong(nv_geometry, VK_GEOMETRY_TYPE_TRIANGLES_NV) ||
           violated(finding, TRIANGLES "sType", "{} is not VK_STRUCTURE_TYPE_GEOMETRY_TRIANGLES_NV",
                    structure_type(triangles_stype(nv_geometry)));
}

bool nv_aabbs_have_their_stype(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return !only_aabbs_stype_is_wrong(nv_geometry, VK_GEOMETRY_TYPE_AABBS_NV) ||
           violated(finding, BOXES "sType", "{} is not VK_STRUCTURE_TYPE_GEOMETRY_AABB_NV",
                    structure_type(aabbs_stype(nv_geometry)));
}

bool nv_unused_triangles_have_their_stype(const struct nv_geometry_view *nv_geometry,
                                          struct finding *finding)
{
    return !only_triangles_stype_is_wrong(nv_geometry, VK_GEOMETRY_TYPE_AABBS_NV) ||
           violated(finding, TRIANGLES "sType",
                    "{} is not VK_STRUCTURE_TYPE_GEOMETRY_TRIANGLES_NV, which a geometry of AABBs "
                    "requires, too",
                    structure_type(triangles_stype(nv_geometry)));
}

bool nv_unused_aabbs_have_their_stype(const struct nv_geometry_view *nv_geometry,
                                      struct finding *finding)
{
    return !only_aabbs_stype_is_wrong(nv_geometry, VK_GEOMETRY_TYPE_TRIANGLES_NV) ||
           violated(finding, BOXES "sType",
                    "{} is not VK_STRUCTURE_TYPE_GEOMETRY_AABB_NV, which a geometry of triangles "
                    "requires, too",
                    structure_type(aabbs_stype(nv_geometry)));
}

bool nv_triangles_have_no_chain(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return !nv_geometry->triangles ||
           has_no_chain(nv_geometry, finding, TRIANGLES "pNext", nv_geometry->triangles->pNext);
}

bool nv_aabbs_have_no_chain(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return !nv_geometry->aabbs ||
           has_no_chain(nv_geometry, finding, BOXES "pNext", nv_geometry->aabbs->pNext);
}

/* ---- triangles */

bool nv_vertex_format_is_valid(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return !nv_geometry->triangles || vertex_format_is_valid(&nv_geometry->translated, finding);
}

static bool is_allowed(VkFormat format)
{
    return format == VK_FORMAT_R32G32B32_SFLOAT || format == VK_FORMAT_R32G32_SFLOAT ||
           format == VK_FORMAT_R16G16B16_SFLOAT || format == VK_FORMAT_R16G16_SFLOAT ||
           format == VK_FORMAT_R16G16_SNORM || format == VK_FORMAT_R16G16B16_SNORM;
}

/* Values outside the enumeration have their own rule. */
bool nv_vertex_format_is_allowed(const struct nv_geometry_view *nv_geometry,
                                 struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || is_allowed(triangles->vertexFormat) ||
           !format_is_known(triangles->vertexFormat) ||
           violated(finding, TRIANGLES "vertexFormat",
                    "{} is not one of the formats that VK_NV_ray_tracing accepts",
                    format(triangles->vertexFormat));
}

static bool offset_is_multiple(const struct nv_geometry_view *geometry, struct finding *finding,
                               enum input_role role, uint32_t of)
{
    const VkDeviceSize offset = geometry->places[role].offset;
    return !of || offset % of == 0 ||
           violated(finding, input_name(role, INPUT_OFFSET_OF_NV), "{} is not a multiple of {}",
                    number(offset), number(of));
}

bool nv_vertex_offset_is_aligned(const struct nv_geometry_view *nv_geometry,
                                 struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || offset_is_multiple(nv_geometry, finding, INPUT_VERTEX,
                                            format_smallest_component(triangles->vertexFormat));
}

bool nv_vertex_stride_fits_32_bits(const struct nv_geometry_view *nv_geometry,
                                   struct finding *finding)
{
    return !nv_geometry->triangles || vertex_stride_fits_32_bits(&nv_geometry->translated, finding);
}

static bool is_unindexed(const VkGeometryTrianglesNV *triangles)
{
    return triangles->indexType == VK_INDEX_TYPE_NONE_NV;
}

bool nv_index_type_is_valid(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return !nv_geometry->triangles || index_type_is_valid(&nv_geometry->translated, finding);
}

bool nv_index_type_is_16_or_32_bits_or_none(const struct nv_geometry_view *nv_geometry,
                                            struct finding *finding)
{
    return !nv_geometry->triangles ||
           index_type_is_16_or_32_bits_or_none(&nv_geometry->translated, finding);
}

bool nv_index_offset_is_aligned(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || offset_is_multiple(nv_geometry, finding, INPUT_INDEX,
                                            index_type_size(triangles->indexType));
}

/* The rule about indexData covers a destroyed buffer. */
bool nv_indexed_triangles_have_index_data(const struct nv_geometry_view *nv_geometry,
                                          struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || !index_type_size(triangles->indexType) ||
           nv_geometry->places[INPUT_INDEX].buffer || nv_geometry_is_empty(nv_geometry) ||
           violated(finding, input_name(INPUT_INDEX, INPUT_OF_NV),
                    "is VK_NULL_HANDLE, but indexType is {}", index_type(triangles->indexType));
}

bool nv_unindexed_triangles_have_no_index_data(const struct nv_geometry_view *nv_geometry,
                                               struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || !is_unindexed(triangles) || !triangles->indexData ||
           violated(finding, input_name(INPUT_INDEX, INPUT_OF_NV),
                    "{} is not VK_NULL_HANDLE, but indexType is VK_INDEX_TYPE_NONE_NV",
                    nv_buffer(triangles->indexData));
}

bool nv_unindexed_triangles_have_no_index_count(const struct nv_geometry_view *nv_geometry,
                                                struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || !is_unindexed(triangles) || !triangles->indexCount ||
           violated(finding, TRIANGLES "indexCount",
                    "{} is not 0, but indexType is VK_INDEX_TYPE_NONE_NV",
                    number(triangles->indexCount));
}

bool nv_transform_offset_is_aligned(const struct nv_geometry_view *nv_geometry,
                                    struct finding *finding)
{
    return offset_is_multiple(nv_geometry, finding, INPUT_MATRIX, 16);
}

/* ---- AABBs */

bool nv_aabb_offset_is_aligned(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return offset_is_multiple(nv_geometry, finding, INPUT_AABBS, 8);
}

bool nv_aabb_stride_is_aligned(const struct nv_geometry_view *nv_geometry, struct finding *finding)
{
    return !nv_geometry->aabbs || aabb_stride_is_aligned(&nv_geometry->translated, finding);
}
