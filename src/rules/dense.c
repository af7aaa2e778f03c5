/* SPDX-License-Identifier: Apache-2.0 */
/* Rules of VK_AMDX_dense_geometry_format: builds and updates of compressed triangles. */
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

/* ---- builds */

bool dense_geometry_is_alone(const struct dense_build_view *dense_build, struct finding *finding)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = dense_build->build->info;
    return info->type != VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR ||
           info->geometryCount == 1 ||
           violated(finding, "geometryCount",
                    "{} is not 1, which a geometry of type "
                    "VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX requires",
                    number(info->geometryCount));
}

bool dense_geometry_has_no_build_ranges(const struct dense_build_view *dense_build,
                                        struct finding *finding)
{
    const struct build_view *build = dense_build->build;
    const struct call_view *call = build->call;
    const void *ranges = call->build_ranges_readable ? call->build_ranges[build->index] : NULL;
    return !ranges ||
           violated(finding, "",
                    "has a geometry of type VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX, "
                    "but ppBuildRangeInfos[{}] {} is not NULL",
                    number(build->index), hex((uint64_t)(uintptr_t)ranges));
}

/* ---- geometries */

static const struct device_facts *device_of(const struct dense_view *dense)
{
    return dense->geometry->build->call->device;
}

bool host_build_has_no_dense_geometry(const struct dense_view *dense, struct finding *finding)
{
    return violated(finding, "geometryType", "is {}, which a host build does not accept",
                    geometry_type(dense->geometry->geometry->geometryType));
}

bool dense_geometry_feature_is_enabled(const struct dense_view *dense, struct finding *finding)
{
    return device_of(dense)->dense_geometry_format ||
           violated_plainly(finding, "geometryType",
                            "is VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX, but "
                            "VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX::denseGeometryFormat "
                            "is not enabled for the device");
}

/* A structure is identified by its sType: with a wrong sType it counts as missing. */
bool dense_triangles_have_their_stype(const struct dense_view *dense, struct finding *finding)
{
    return dense->data || !dense->missing ||
           violated(
               finding, DENSE_DATA "sType",
               "is the sType of no structure in the pNext chain, but geometryType {} requires one",
               geometry_type(dense->geometry->geometry->geometryType));
}

bool dense_format_is_valid(const struct dense_view *dense, struct finding *finding)
{
    return !dense->data || dense_format_is_known(dense->data->format) ||
           device_of(dense)->newer_than_registry ||
           violated(finding, DENSE_DATA "format", "{} is not a VkCompressedTriangleFormatAMDX",
                    number((uint32_t)dense->data->format));
}

static const char *data_field(const struct dense_view *dense)
{
    return dense->geometry->build->call->command == COMMAND_HOST
               ? DENSE_DATA "compressedData.hostAddress"
               : DENSE_DATA "compressedData.deviceAddress";
}

/* The rules about all inputs cover addresses other than 0. */
bool dense_data_is_valid(const struct dense_view *dense, struct finding *finding)
{
    return !dense->data || dense_is_empty(dense->data) ||
           address_is_given(finding, data_field(dense), dense->data->compressedData.deviceAddress);
}

bool dense_data_is_aligned(const struct dense_view *dense, struct finding *finding)
{
    return !dense->data || !dense_format_is_known(dense->data->format) ||
           address_is_aligned(finding, data_field(dense), dense->data->compressedData.deviceAddress,
                              VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_BYTE_ALIGNMENT_AMDX);
}

bool dense_data_size_is_aligned(const struct dense_view *dense, struct finding *finding)
{
    const uint32_t stride = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_BYTE_STRIDE_AMDX;
    return !dense->data || !dense_format_is_known(dense->data->format) ||
           dense->data->dataSize % stride == 0 ||
           violated(finding, DENSE_DATA "dataSize", "{} is not a multiple of {}",
                    number(dense->data->dataSize), number(stride));
}

bool dense_buffer_has_compressed_data_usage(const struct dense_view *dense, struct finding *finding)
{
    const struct address_facts *facts = dense->address;
    return !facts || facts->status != ADDRESS_IN_BUFFER ||
           (facts->usage & VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX) ||
           violated(finding, DENSE_DATA "compressedData.deviceAddress",
                    "{} is in {}, which was created with usage {}, without "
                    "VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX",
                    hex(facts->address),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer)),
                    buffer_usage(facts->usage));
}

/* ---- updates */

static bool matches(const struct updated_dense_view *dense, struct finding *finding,
                    const char *field, uint64_t now, uint64_t then)
{
    return now == then || update_differs(dense->update, finding, field, number(now), number(then));
}

bool dense_triangle_count_matches_source(const struct updated_dense_view *updated_dense,
                                         struct finding *finding)
{
    return matches(updated_dense, finding, DENSE_DATA "numTriangles",
                   updated_dense->requested->triangle_count, updated_dense->source->triangle_count);
}

bool dense_vertex_count_matches_source(const struct updated_dense_view *updated_dense,
                                       struct finding *finding)
{
    return matches(updated_dense, finding, DENSE_DATA "numVertices",
                   updated_dense->requested->vertex_count, updated_dense->source->vertex_count);
}

bool dense_max_primitive_index_matches_source(const struct updated_dense_view *updated_dense,
                                              struct finding *finding)
{
    return matches(updated_dense, finding, DENSE_DATA "maxPrimitiveIndex",
                   updated_dense->requested->max_primitive_index,
                   updated_dense->source->max_primitive_index);
}

bool dense_max_geometry_index_matches_source(const struct updated_dense_view *updated_dense,
                                             struct finding *finding)
{
    return matches(updated_dense, finding, DENSE_DATA "maxGeometryIndex",
                   updated_dense->requested->max_geometry_index,
                   updated_dense->source->max_geometry_index);
}

bool dense_format_matches_source(const struct updated_dense_view *updated_dense,
                                 struct finding *finding)
{
    return matches(updated_dense, finding, DENSE_DATA "format", updated_dense->requested->format,
                   updated_dense->source->format);
}

bool dense_data_size_matches_source(const struct updated_dense_view *updated_dense,
                                    struct finding *finding)
{
    return matches(updated_dense, finding, DENSE_DATA "dataSize",
                   updated_dense->requested->data_size, updated_dense->source->data_size);
}
