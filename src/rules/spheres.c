/* SPDX-License-Identifier: Apache-2.0 */
/* Rules of VK_NV_ray_tracing_linear_swept_spheres: spheres and linear swept spheres, whose
 * structures share most members. They apply to geometries of these types only. */
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

static const struct device_facts *device_of(const struct sphere_data *data)
{
    return data->geometry->build->call->device;
}

static bool has_indices(const struct sphere_data *data)
{
    return index_type_size(data->index_type) != 0;
}

static bool is_host(const struct sphere_data *data)
{
    return data->geometry->build->call->command == COMMAND_HOST;
}

bool spheres_feature_is_enabled(const struct spheres_view *spheres, struct finding *finding)
{
    return device_of(&spheres->data)->spheres ||
           violated_plainly(finding, "geometryType",
                            "is VK_GEOMETRY_TYPE_SPHERES_NV, but "
                            "VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV::spheres is "
                            "not enabled for the device");
}

bool swept_spheres_feature_is_enabled(const struct swept_spheres_view *swept_spheres,
                                      struct finding *finding)
{
    return device_of(&swept_spheres->data)->linear_swept_spheres ||
           violated_plainly(finding, "geometryType",
                            "is VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, but "
                            "VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV::"
                            "linearSweptSpheres is not enabled for the device");
}

/* Defines the rule of a shared member for both structures: `check` is the statement about the
 * member at `path`. */
#define RULE_FOR_BOTH(rule, check, member)                                                         \
    bool spheres_##rule(const struct spheres_view *spheres, struct finding *finding)               \
    {                                                                                              \
        return check(&spheres->data, finding, SPHERES_DATA member);                                \
    }                                                                                              \
    bool swept_spheres_##rule(const struct swept_spheres_view *swept_spheres,                      \
                              struct finding *finding)                                             \
    {                                                                                              \
        return check(&swept_spheres->data, finding, SWEPT_DATA member);                            \
    }

/* Defines the rule of an address for both structures. The path depends on whether the build is a
 * host build. */
#define ADDRESS_RULE_FOR_BOTH(rule, check, member)                                                 \
    bool spheres_##rule(const struct spheres_view *spheres, struct finding *finding)               \
    {                                                                                              \
        return check(&spheres->data, finding,                                                      \
                     is_host(&spheres->data) ? SPHERES_DATA member ".hostAddress"                  \
                                             : SPHERES_DATA member ".deviceAddress");              \
    }                                                                                              \
    bool swept_spheres_##rule(const struct swept_spheres_view *swept_spheres,                      \
                              struct finding *finding)                                             \
    {                                                                                              \
        return check(&swept_spheres->data, finding,                                                \
                     is_host(&swept_spheres->data) ? SWEPT_DATA member ".hostAddress"              \
                                                   : SWEPT_DATA member ".deviceAddress");          \
    }

/* A structure is identified by its sType: with a wrong sType it counts as missing. */
static bool has_structure(const struct sphere_data *data, struct finding *finding, const char *path)
{
    return data->given || !data->missing ||
           violated(
               finding, path,
               "is the sType of no structure in the pNext chain, but geometryType {} requires one",
               geometry_type(data->geometry->geometry->geometryType));
}

RULE_FOR_BOTH(have_their_stype, has_structure, "sType")

static bool format_is_valid(const struct sphere_data *data, struct finding *finding,
                            const char *path, VkFormat format)
{
    return !data->given || format_is_known(format) || device_of(data)->newer_than_registry ||
           violated(finding, path, "{} is not a VkFormat", number((uint32_t)format));
}

static bool vertex_format_is_a_format(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    return format_is_valid(data, finding, path, data->vertex_format);
}

static bool radius_format_is_a_format(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    return format_is_valid(data, finding, path, data->radius_format);
}

static bool vertex_format_has_feature(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    return !data->given || data->vertex_format_supported != NO ||
           violated(finding, path,
                    "{} lacks VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR on "
                    "this device",
                    format(data->vertex_format));
}

static bool radius_format_has_feature(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    return !data->given || data->radius_format_supported != NO ||
           violated(finding, path,
                    "{} lacks VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV on "
                    "this device",
                    format(data->radius_format));
}

RULE_FOR_BOTH(vertex_format_is_valid, vertex_format_is_a_format, "vertexFormat")
RULE_FOR_BOTH(radius_format_is_valid, radius_format_is_a_format, "radiusFormat")
RULE_FOR_BOTH(vertex_format_is_supported, vertex_format_has_feature, "vertexFormat")
RULE_FOR_BOTH(radius_format_is_supported, radius_format_has_feature, "radiusFormat")

static bool vertex_stride_is_multiple(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    uint32_t size = data->given ? format_alignment(data->vertex_format) : 0;
    return !size || data->vertex_stride % size == 0 ||
           violated(finding, path, "{} is not a multiple of the component size of {} ({})",
                    number(data->vertex_stride), format(data->vertex_format), number(size));
}

RULE_FOR_BOTH(vertex_stride_is_aligned, vertex_stride_is_multiple, "vertexStride")

static bool strides_are_small(const struct sphere_data *data, struct finding *finding,
                              const char *vertex_path, const char *radius_path)
{
    if (data->vertex_stride > UINT32_MAX && data->radius_stride > UINT32_MAX)
        return violated(finding, vertex_path, "{} and radiusStride {} exceed 2^32 - 1",
                        number(data->vertex_stride), number(data->radius_stride));
    return stride_fits_32_bits(finding, vertex_path, data->vertex_stride) &&
           stride_fits_32_bits(finding, radius_path, data->radius_stride);
}

bool spheres_strides_fit_32_bits(const struct spheres_view *spheres, struct finding *finding)
{
    return strides_are_small(&spheres->data, finding, SPHERES_DATA "vertexStride",
                             SPHERES_DATA "radiusStride");
}

bool swept_spheres_strides_fit_32_bits(const struct swept_spheres_view *swept_spheres,
                                       struct finding *finding)
{
    return strides_are_small(&swept_spheres->data, finding, SWEPT_DATA "vertexStride",
                             SWEPT_DATA "radiusStride");
}

/* ---- addresses: presence and host addresses. Other rules cover nonzero device addresses. */

static bool union_is_given(const struct sphere_data *data, struct finding *finding,
                           const char *path, VkDeviceOrHostAddressConstKHR address)
{
    if (!data->given)
        return true;
    return is_host(data) ? host_input_is_given(data->geometry, finding, path, address.hostAddress)
                         : input_is_given(data->geometry, finding, path, address.deviceAddress);
}

static bool vertices_are_given(const struct sphere_data *data, struct finding *finding,
                               const char *path)
{
    return union_is_given(data, finding, path, data->vertices);
}

static bool radii_are_given(const struct sphere_data *data, struct finding *finding,
                            const char *path)
{
    return union_is_given(data, finding, path, data->radii);
}

static bool indices_are_given(const struct sphere_data *data, struct finding *finding,
                              const char *path)
{
    return !has_indices(data) || union_is_given(data, finding, path, data->indices);
}

static bool no_indices_are_given(const struct sphere_data *data, struct finding *finding,
                                 const char *path)
{
    if (!data->given || data->index_type != VK_INDEX_TYPE_NONE_KHR)
        return true;
    uint64_t address = is_host(data) ? (uint64_t)(uintptr_t)data->indices.hostAddress
                                     : data->indices.deviceAddress;
    return !address ||
           violated(finding, path, "{} is not 0, but indexType is VK_INDEX_TYPE_NONE_KHR",
                    hex(address));
}

ADDRESS_RULE_FOR_BOTH(vertex_address_is_given, vertices_are_given, "vertexData")
ADDRESS_RULE_FOR_BOTH(radius_address_is_given, radii_are_given, "radiusData")
ADDRESS_RULE_FOR_BOTH(without_indices_have_no_index_address, no_indices_are_given, "indexData")

static bool host_address_is_readable(struct finding *finding, const char *path,
                                     VkDeviceOrHostAddressConstKHR address, bool is_unreadable)
{
    return !is_unreadable || violated(finding, path, "{} is not readable",
                                      hex((uint64_t)(uintptr_t)address.hostAddress));
}

static bool vertices_are_readable(const struct sphere_data *data, struct finding *finding,
                                  const char *path)
{
    return host_address_is_readable(finding, path, data->vertices, data->vertices_unreadable);
}

static bool radii_are_readable(const struct sphere_data *data, struct finding *finding,
                               const char *path)
{
    return host_address_is_readable(finding, path, data->radii, data->radii_unreadable);
}

static bool indices_are_readable(const struct sphere_data *data, struct finding *finding,
                                 const char *path)
{
    return host_address_is_readable(finding, path, data->indices, data->indices_unreadable);
}

ADDRESS_RULE_FOR_BOTH(vertex_data_is_valid, vertices_are_readable, "vertexData")
ADDRESS_RULE_FOR_BOTH(radius_data_is_valid, radii_are_readable, "radiusData")
ADDRESS_RULE_FOR_BOTH(index_data_is_valid, indices_are_readable, "indexData")

/* ---- indices. VK_INDEX_TYPE_UINT8 has its own rule. */

static bool index_type_is_known(const struct sphere_data *data, struct finding *finding,
                                const char *path)
{
    return !data->given || has_indices(data) || data->index_type == VK_INDEX_TYPE_NONE_KHR ||
           device_of(data)->newer_than_registry ||
           violated(finding, path, "{} is not a VkIndexType", index_type(data->index_type));
}

static bool index_type_is_not_8_bits(const struct sphere_data *data, struct finding *finding,
                                     const char *path)
{
    return !data->given || data->index_type != VK_INDEX_TYPE_UINT8 ||
           violated_plainly(finding, path, "is VK_INDEX_TYPE_UINT8, which a build does not accept");
}

RULE_FOR_BOTH(index_type_is_valid, index_type_is_known, "indexType")
RULE_FOR_BOTH(index_type_is_16_or_32_bits_or_none, index_type_is_not_8_bits, "indexType")

/* ---- linear swept spheres only */

bool swept_spheres_indexing_mode_is_valid(const struct swept_spheres_view *swept_spheres,
                                          struct finding *finding)
{
    VkRayTracingLssIndexingModeNV mode = swept_spheres->indexing_mode;
    return !swept_spheres->data.given || mode == VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV ||
           mode == VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV ||
           device_of(&swept_spheres->data)->newer_than_registry ||
           violated(finding, SWEPT_DATA "indexingMode", "{} is not a VkRayTracingLssIndexingModeNV",
                    number((uint32_t)mode));
}

bool swept_spheres_end_caps_mode_is_valid(const struct swept_spheres_view *swept_spheres,
                                          struct finding *finding)
{
    VkRayTracingLssPrimitiveEndCapsModeNV mode = swept_spheres->end_caps_mode;
    return !swept_spheres->data.given ||
           mode == VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_NONE_NV ||
           mode == VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV ||
           device_of(&swept_spheres->data)->newer_than_registry ||
           violated(finding, SWEPT_DATA "endCapsMode",
                    "{} is not a VkRayTracingLssPrimitiveEndCapsModeNV", number((uint32_t)mode));
}

bool spheres_index_address_is_given(const struct spheres_view *spheres, struct finding *finding)
{
    return indices_are_given(&spheres->data, finding,
                             is_host(&spheres->data) ? SPHERES_DATA "indexData.hostAddress"
                                                     : SPHERES_DATA "indexData.deviceAddress");
}

static bool is_successive(const struct swept_spheres_view *swept_spheres)
{
    return swept_spheres->indexing_mode == VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
}

bool swept_spheres_index_address_is_given(const struct swept_spheres_view *swept_spheres,
                                          struct finding *finding)
{
    const struct sphere_data *data = &swept_spheres->data;
    return indices_are_given(data, finding,
                             is_host(data) ? SWEPT_DATA "indexData.hostAddress"
                                           : SWEPT_DATA "indexData.deviceAddress") ||
           (is_successive(swept_spheres) &&
            also_violates(finding, RULE_successive_swept_spheres_have_index_data));
}

/* The valid usage applies whatever the indexType. If the indexType requires an address, too, the
 * message about that address names this id. */
bool successive_swept_spheres_have_index_data(const struct swept_spheres_view *swept_spheres,
                                              struct finding *finding)
{
    const struct sphere_data *data = &swept_spheres->data;
    if (!data->given || !is_successive(swept_spheres))
        return true;
    bool is_null = is_host(data) ? !data->indices.hostAddress : !data->indices.deviceAddress;
    return !is_null || geometry_is_empty(data->geometry) ||
           violated_plainly(finding, SWEPT_DATA "indexData",
                            "is NULL, but indexingMode is "
                            "VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV") ||
           (has_indices(data) &&
            is_reported_with(finding, RULE_swept_spheres_index_address_is_given));
}
