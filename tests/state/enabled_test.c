/* SPDX-License-Identifier: Apache-2.0 */
/* What rules get: the flags and types that are valid on a device with one extension, those of the
 * registry; properties of formats; the other rules that a finding names; members and names of
 * inputs of builds. */
#include "src/model/formats.h"
#include "src/model/input_names.h"
#include "src/model/inputs.h"
#include "src/view/enabled.h"
#include "src/view/finding.h"
#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"

#define BUILD(name) VK_BUILD_ACCELERATION_STRUCTURE_##name

TEST(an_extension_enables_its_flags_alone)
{
    struct device_facts device = {.newer_than_registry = false};
    const struct {
        bool *extension;
        VkBuildAccelerationStructureFlagsKHR build;
        VkGeometryInstanceFlagsKHR instance;
    } cases[] = {
        {&device.extension.motion_blur_nv, BUILD(MOTION_BIT_NV), 0},
        {&device.extension.opacity_micromap_ext,
         BUILD(ALLOW_OPACITY_MICROMAP_UPDATE_BIT_EXT) |
             BUILD(ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_EXT) |
             BUILD(ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT),
         micromap_instance_flags},
        {&device.extension.opacity_micromap_khr,
         BUILD(ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR) |
             BUILD(ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR) | BUILD(MICROMAP_LOSSY_BIT_KHR),
         micromap_instance_flags},
        {&device.extension.displacement_micromap_nv,
         BUILD(ALLOW_DISPLACEMENT_MICROMAP_UPDATE_BIT_NV), 0},
        {&device.extension.position_fetch_khr, BUILD(ALLOW_DATA_ACCESS_BIT_KHR), 0},
        {&device.extension.cluster_acceleration_structure_nv,
         BUILD(ALLOW_CLUSTER_OPACITY_MICROMAPS_BIT_NV), 0},
    };
    const VkGeometryInstanceFlagsKHR instance_flags = 0xf; /* of VK_KHR_acceleration_structure */
    assert_int_equal(build_flags_enabled(&device), 0x1f);
    assert_int_equal(instance_flags_enabled(&device), instance_flags);
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        *cases[i].extension = true;
        assert_int_equal(build_flags_enabled(&device), 0x1f | cases[i].build);
        assert_int_equal(instance_flags_enabled(&device), instance_flags | cases[i].instance);
        *cases[i].extension = false;
    }
}

TEST(types_need_their_extension)
{
    struct device_facts device = {.newer_than_registry = false};
    const struct {
        VkGeometryTypeKHR type;
        bool *extension;
    } cases[] = {
        {VK_GEOMETRY_TYPE_SPHERES_NV, &device.extension.linear_swept_spheres_nv},
        {VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV, &device.extension.linear_swept_spheres_nv},
        {(VkGeometryTypeKHR)VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX,
         &device.extension.dense_geometry_format_amdx},
        {VK_GEOMETRY_TYPE_MICROMAP_KHR, &device.extension.opacity_micromap_khr},
        {VK_GEOMETRY_TYPE_MAX_ENUM_KHR, &device.newer_than_registry},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        assert_false(geometry_type_is_enabled(&device, cases[i].type));
        *cases[i].extension = true;
        assert_true(geometry_type_is_enabled(&device, cases[i].type));
        *cases[i].extension = false;
        assert_true(geometry_type_is_enabled(&device, VK_GEOMETRY_TYPE_TRIANGLES_KHR));
    }
    assert_false(accel_type_is_enabled(&device, VK_ACCELERATION_STRUCTURE_TYPE_MAX_ENUM_KHR));
    device.newer_than_registry = true;
    assert_true(accel_type_is_enabled(&device, VK_ACCELERATION_STRUCTURE_TYPE_MAX_ENUM_KHR));
}

TEST(formats_have_the_alignment_of_their_smallest_component)
{
    static const struct {
        VkFormat format;
        uint32_t component, size, alignment;
    } cases[] = {
        {VK_FORMAT_R32G32B32_SFLOAT, 4, 12, 4},
        {VK_FORMAT_R16G16B16A16_SNORM, 2, 8, 2},
        {VK_FORMAT_R8G8B8_UNORM, 1, 3, 1},
        {VK_FORMAT_R64G64B64_SFLOAT, 8, 24, 8},
        {VK_FORMAT_D32_SFLOAT_S8_UINT, 1, 5, 1}, /* components of two sizes */
        {VK_FORMAT_A2B10G10R10_SNORM_PACK32, 0, 4, 4},
        {VK_FORMAT_B10X6G10X6R10X6G10X6_422_UNORM_4PACK16, 0, 8, 8},
        {VK_FORMAT_MAX_ENUM, 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        if (format_smallest_component(cases[i].format) != cases[i].component ||
            format_size(cases[i].format) != cases[i].size ||
            format_alignment(cases[i].format) != cases[i].alignment)
            fail_msg("format %d: %u %u %u", (int)cases[i].format,
                     format_smallest_component(cases[i].format), format_size(cases[i].format),
                     format_alignment(cases[i].format));
        assert_int_equal(format_is_known(cases[i].format), cases[i].size > 0);
    }
    assert_true(format_is_known(VK_FORMAT_UNDEFINED));
}

TEST(a_finding_names_no_more_rules_than_fit)
{
    struct finding finding = {.also_count = 0};
    for (uint32_t i = 0; i < FINDING_ALSO + 2; i++) {
        assert_false(also_violates(&finding, (enum rule)i));
        assert_int_equal(finding.also_count, i < FINDING_ALSO ? i + 1 : FINDING_ALSO);
    }
}

/* A micromap of dense geometry has an index for each primitive up to the largest one. */
TEST(dense_geometry_reads_its_micromap_indices)
{
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry,
                 .geometryType =
                     (VkGeometryTypeKHR)VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX);
    const struct chained_input chained = {
        .dense = MAKE(VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX,
                      .compressedData.deviceAddress = 0x1000, .dataSize = 384, .numTriangles = 2,
                      .maxPrimitiveIndex = 6),
        .has_opacity = true,
        .opacity = MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT,
                        .indexType = VK_INDEX_TYPE_UINT32, .indexStride = 4,
                        .indexBuffer.deviceAddress = 0x6000),
    };
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 2};
    struct geometry_input inputs[GEOMETRY_INPUTS];
    assert_int_equal(inputs_of_geometry(0, &geometry, &chained, &range, inputs), 2);
    assert_int_equal(inputs[0].address.deviceAddress, 0x1000);
    assert_int_equal(input_end(&inputs[0]), 384);
    assert_int_equal(inputs[1].address.deviceAddress, 0x6000);
    assert_int_equal(input_end(&inputs[1]), 7 * 4);
}

TEST(each_input_of_a_geometry_has_a_member)
{
    const VkAccelerationStructureGeometryKHR geometry = {.sType = 0};
    const struct chained_input chained = {.has_opacity = false};
    for (enum input_role role = 0; role < INPUT_ROLES; role++)
        assert_int_equal(input_place(&geometry, &chained, role) == NULL,
                         role == INPUT_SCRATCH || role == INPUT_UPDATE_SCRATCH ||
                             role == INPUT_INDIRECT);
}

/* Only inputs of VK_NV_ray_tracing have a name there. */
TEST(each_input_has_names)
{
    for (unsigned role = 0; role < INPUT_ROLES; role++)
        for (unsigned form = INPUT_PLAIN; form < INPUT_OF_NV; form++)
            assert_true(input_name((enum input_role)role, (enum input_form)form) != NULL);
    assert_has(input_name(INPUT_AABBS, INPUT_OF_HOST), "geometry.aabbs.data.hostAddress");
    assert_has(input_name(INPUT_AABBS, INPUT_OF_NV), "geometry.aabbs.aabbData");
}
