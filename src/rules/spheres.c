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
    return index_type_size(data->chained.spheres.indexType) != 0;
}

static bool is_host(const struct sphere_data *data)
{
    return data->geometry->build->call->command == COMMAND_HOST;
}

bool spheres_feature_is_enabled(const struct spheres_view *spheres, struct finding *finding)
{
    return device_of(spheres->data)->spheres ||
           violated_plainly(finding, "geometryType",
                            "is VK_GEOMETRY_TYPE_SPHERES_NV, but "
                            "VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV::spheres is "
                            "not enabled for the device");
}

bool swept_spheres_feature_is_enabled(const struct swept_spheres_view *swept_spheres,
                                      struct finding *finding)
{
    return device_of(swept_spheres->data)->linear_swept_spheres ||
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
        return check(spheres->data, finding, SPHERES_DATA member);                                 \
    }                                                                                              \
    bool swept_spheres_##rule(const struct swept_spheres_view *swept_spheres,                      \
                              struct finding *finding)                                             \
    {                                                                                              \
        return check(swept_spheres->data, finding, SWEPT_DATA member);                             \
    }

/* Defines the rule of an array for both structures. */
#define ARRAY_RULE_FOR_BOTH(rule, check, array)                                                    \
    bool spheres_##rule(const struct spheres_view *spheres, struct finding *finding)               \
    {                                                                                              \
        return check(spheres->data, finding, INPUT_SPHERE_##array);                                \
    }                                                                                              \
    bool swept_spheres_##rule(const struct swept_spheres_view *swept_spheres,                      \
                              struct finding *finding)                                             \
    {                                                                                              \
        return check(swept_spheres->data, finding, INPUT_SWEPT_##array);                           \
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
    return format_is_valid(data, finding, path, data->chained.spheres.vertexFormat);
}

static bool radius_format_is_a_format(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    return format_is_valid(data, finding, path, data->chained.spheres.radiusFormat);
}

static bool vertex_format_has_feature(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    return !data->given || data->vertex_format_supported != NO ||
           violated(finding, path,
                    "{} lacks VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR on "
                    "this device",
                    format(data->chained.spheres.vertexFormat));
}

static bool radius_format_has_feature(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    return !data->given || data->radius_format_supported != NO ||
           violated(finding, path,
                    "{} lacks VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV on "
                    "this device",
                    format(data->chained.spheres.radiusFormat));
}

RULE_FOR_BOTH(vertex_format_is_valid, vertex_format_is_a_format, "vertexFormat")
RULE_FOR_BOTH(radius_format_is_valid, radius_format_is_a_format, "radiusFormat")
RULE_FOR_BOTH(vertex_format_is_supported, vertex_format_has_feature, "vertexFormat")
RULE_FOR_BOTH(radius_format_is_supported, radius_format_has_feature, "radiusFormat")

static bool vertex_stride_is_multiple(const struct sphere_data *data, struct finding *finding,
                                      const char *path)
{
    uint32_t size = data->given ? format_alignment(data->chained.spheres.vertexFormat) : 0;
    return !size || data->chained.spheres.vertexStride % size == 0 ||
           violated(finding, path, "{} is not a multiple of the component size of {} ({})",
                    number(data->chained.spheres.vertexStride),
                    format(data->chained.spheres.vertexFormat), number(size));
}

RULE_FOR_BOTH(vertex_stride_is_aligned, vertex_stride_is_multiple, "vertexStride")

static bool strides_are_small(const struct sphere_data *data, struct finding *finding,
                              const char *vertex_path, const char *radius_path)
{
    if (data->chained.spheres.vertexStride > UINT32_MAX &&
        data->chained.spheres.radiusStride > UINT32_MAX)
        return violated(finding, vertex_path, "{} and radiusStride {} exceed 2^32 - 1",
                        number(data->chained.spheres.vertexStride),
                        number(data->chained.spheres.radiusStride));
    return stride_fits_32_bits(finding, vertex_path, data->chained.spheres.vertexStride) &&
           stride_fits_32_bits(finding, radius_path, data->chained.spheres.radiusStride);
}

bool spheres_strides_fit_32_bits(const struct spheres_view *spheres, struct finding *finding)
{
    return strides_are_small(spheres->data, finding, SPHERES_DATA "vertexStride",
                             SPHERES_DATA "radiusStride");
}

bool swept_spheres_strides_fit_32_bits(const struct swept_spheres_view *swept_spheres,
                                       struct finding *finding)
{
    return strides_are_small(swept_spheres->data, finding, SWEPT_DATA "vertexStride",
                             SWEPT_DATA "radiusStride");
}

/* ---- addresses: presence and host addresses. Other rules cover nonzero device addresses. */

static VkDeviceOrHostAddressConstKHR address_of(const struct sphere_data *data,
                                                enum input_role role)
{
    return *input_place(data->geometry->geometry, &data->chained, role);
}

static bool array_is_given(const struct sphere_data *data, struct finding *finding,
                           enum input_role role)
{
    return !data->given ||
           chained_address_is_given(data->geometry, finding, content_field(data->geometry, role),
                                    address_of(data, role));
}

static bool indices_are_given(const struct sphere_data *data, struct finding *finding,
                              enum input_role role)
{
    return !has_indices(data) || array_is_given(data, finding, role);
}

static bool no_indices_are_given(const struct sphere_data *data, struct finding *finding,
                                 enum input_role role)
{
    const VkDeviceOrHostAddressConstKHR indices = address_of(data, role);
    if (!data->given || data->chained.spheres.indexType != VK_INDEX_TYPE_NONE_KHR)
        return true;
    uint64_t address =
        is_host(data) ? (uint64_t)(uintptr_t)indices.hostAddress : indices.deviceAddress;
    return !address ||
           violated(finding, content_field(data->geometry, role),
                    "{} is not 0, but indexType is VK_INDEX_TYPE_NONE_KHR", hex(address));
}

ARRAY_RULE_FOR_BOTH(vertex_address_is_given, array_is_given, VERTEX)
ARRAY_RULE_FOR_BOTH(radius_address_is_given, array_is_given, RADIUS)
ARRAY_RULE_FOR_BOTH(without_indices_have_no_index_address, no_indices_are_given, INDEX)

static bool array_is_readable(const struct sphere_data *data, struct finding *finding,
                              enum input_role role)
{
    return !(data->unreadable & 1U << role) ||
           violated(finding, content_field(data->geometry, role), "{} is not readable",
                    hex((uint64_t)(uintptr_t)address_of(data, role).hostAddress));
}

ARRAY_RULE_FOR_BOTH(vertex_data_is_valid, array_is_readable, VERTEX)
ARRAY_RULE_FOR_BOTH(radius_data_is_valid, array_is_readable, RADIUS)
ARRAY_RULE_FOR_BOTH(index_data_is_valid, array_is_readable, INDEX)

/* ---- indices. VK_INDEX_TYPE_UINT8 has its own rule. */

static bool index_type_is_known(const struct sphere_data *data, struct finding *finding,
                                const char *path)
{
    return !data->given || has_indices(data) ||
           data->chained.spheres.indexType == VK_INDEX_TYPE_NONE_KHR ||
           device_of(data)->newer_than_registry ||
           violated(finding, path, "{} is not a VkIndexType",
                    index_type(data->chained.spheres.indexType));
}

static bool index_type_is_not_8_bits(const struct sphere_data *data, struct finding *finding,
                                     const char *path)
{
    return !data->given || data->chained.spheres.indexType != VK_INDEX_TYPE_UINT8 ||
           violated_plainly(finding, path, "is VK_INDEX_TYPE_UINT8, which a build does not accept");
}

RULE_FOR_BOTH(index_type_is_valid, index_type_is_known, "indexType")
RULE_FOR_BOTH(index_type_is_16_or_32_bits_or_none, index_type_is_not_8_bits, "indexType")

/* ---- linear swept spheres only */

bool swept_spheres_indexing_mode_is_valid(const struct swept_spheres_view *swept_spheres,
                                          struct finding *finding)
{
    VkRayTracingLssIndexingModeNV mode = swept_spheres->data->chained.spheres.indexingMode;
    return !swept_spheres->data->given || mode == VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV ||
           mode == VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV ||
           device_of(swept_spheres->data)->newer_than_registry ||
           violated(finding, SWEPT_DATA "indexingMode", "{} is not a VkRayTracingLssIndexingModeNV",
                    number((uint32_t)mode));
}

bool swept_spheres_end_caps_mode_is_valid(const struct swept_spheres_view *swept_spheres,
                                          struct finding *finding)
{
    VkRayTracingLssPrimitiveEndCapsModeNV mode = swept_spheres->data->chained.spheres.endCapsMode;
    return !swept_spheres->data->given ||
           mode == VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_NONE_NV ||
           mode == VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV ||
           device_of(swept_spheres->data)->newer_than_registry ||
           violated(finding, SWEPT_DATA "endCapsMode",
                    "{} is not a VkRayTracingLssPrimitiveEndCapsModeNV", number((uint32_t)mode));
}

bool spheres_index_address_is_given(const struct spheres_view *spheres, struct finding *finding)
{
    return indices_are_given(spheres->data, finding, INPUT_SPHERE_INDEX);
}

static bool is_successive(const struct swept_spheres_view *swept_spheres)
{
    return swept_spheres->data->chained.spheres.indexingMode ==
           VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
}

bool swept_spheres_index_address_is_given(const struct swept_spheres_view *swept_spheres,
                                          struct finding *finding)
{
    return indices_are_given(swept_spheres->data, finding, INPUT_SWEPT_INDEX) ||
           (is_successive(swept_spheres) &&
            also_violates(finding, RULE_successive_swept_spheres_have_index_data));
}

/* The valid usage applies whatever the indexType. If the indexType requires an address, too, the
 * message about that address names this id. */
bool successive_swept_spheres_have_index_data(const struct swept_spheres_view *swept_spheres,
                                              struct finding *finding)
{
    const struct sphere_data *data = swept_spheres->data;
    if (!data->given || !is_successive(swept_spheres))
        return true;
    const VkDeviceOrHostAddressConstKHR indices = address_of(data, INPUT_SWEPT_INDEX);
    bool is_null = is_host(data) ? !indices.hostAddress : !indices.deviceAddress;
    return !is_null || geometry_is_empty(data->geometry) ||
           violated_plainly(finding, input_name(INPUT_SWEPT_INDEX, INPUT_PLAIN),
                            "is NULL, but indexingMode is "
                            "VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV") ||
           (has_indices(data) &&
            is_reported_with(finding, RULE_swept_spheres_index_address_is_given));
}
