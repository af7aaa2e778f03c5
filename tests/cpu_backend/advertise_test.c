/* SPDX-License-Identifier: Apache-2.0 */
/* What a physical device offers on backend cpu, and devices made of that. */
#include <string.h>

#include "src/bvh/input/displacement.h"
#include "src/bvh/input/formats.h"
#include "src/bvh/micromap.h"
#include "tests/fixture/device_wish.h"
#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"
#include "vuid-tables/registry.h"

/* ---- instances and devices with the layer over one driver */

struct instance_fixture_setup {
    const char *backend;  /* assay_validation.backend; NULL: cpu */
    uint32_t api_version; /* that the application asks for; 0: 1.3 */
    bool driver_traces;   /* the null driver keeps its ray tracing; lavapipe always does */
    void (*configure)(struct null_driver_config *config); /* NULL: as it is */
};

static void configure(const struct platform *platform, const struct instance_fixture_setup *setup)
{
    struct null_driver_config config = platform->null_driver.default_config();
    for (size_t i = 0; !setup->driver_traces && i < registry_ray_tracing_count; i++)
        null_driver_hide_extension(&config, registry_ray_tracing[i]);
    if (setup->configure != NULL)
        setup->configure(&config);
    platform->null_driver.configure(&config);
}

static void instance_fixture_open(struct instance_fixture *fixture, const struct platform *platform,
                                  const struct instance_fixture_setup *setup)
{
    const struct instance_settings settings = {
        .backend = setup->backend ? setup->backend : "cpu",
        .api_version = setup->api_version,
    };
    if (platform->is_null)
        configure(platform, setup);
    instance_fixture_create(fixture, platform, &settings);
}

/* All that the backend offers. */
enum { KHR_STRUCTURES, DEFERRED, NV_STRUCTURES = 3, BACKEND_EXTENSIONS = 9 };
static const char *const backend_extensions[BACKEND_EXTENSIONS] = {
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME,
    VK_NV_RAY_TRACING_EXTENSION_NAME,
    VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_EXTENSION_NAME,
    VK_AMDX_DENSE_GEOMETRY_FORMAT_EXTENSION_NAME,
    VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
    VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME,
    VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME,
};

static struct platform platform;
static struct instance_fixture fixture; /* of an OFFER_TEST */
static struct instance_fixture other;

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name);
}

static void offer_open(void)
{
    instance_fixture_open(&fixture, &platform, &(struct instance_fixture_setup){0});
}

static void offer_close(void)
{
    messages_expect_none(&fixture.messages);
    instance_fixture_close(&fixture);
}

#define OFFER_TEST(name) TEST_BETWEEN(name, offer_open, offer_close)

static const struct instance_fixture_setup on_driver = {.backend = "driver", .driver_traces = true};

/* ---- extensions */

static bool is_offered(const char *name)
{
    for (size_t i = 0; i < BACKEND_EXTENSIONS; i++)
        if (strcmp(name, backend_extensions[i]) == 0)
            return true;
    return false;
}

OFFER_TEST(test_extensions)
{
    for (size_t i = 0; i < registry_ray_tracing_count; i++)
        assert_int_equal(instance_fixture_count_extension(&fixture, registry_ray_tracing[i]),
                         is_offered(registry_ray_tracing[i]));
    for (uint32_t i = 0; i < fixture.extension_count; i++)
        assert_int_equal(
            instance_fixture_count_extension(&fixture, fixture.extensions[i].extensionName), 1);
}

/* The rest is the driver's, in the driver's order. */
OFFER_TEST(test_other_extensions)
{
    instance_fixture_open(&other, &platform, &on_driver);
    uint32_t at = 0;
    for (uint32_t i = 0; i < other.extension_count; i++) {
        const VkExtensionProperties *theirs = &other.extensions[i];
        if (registry_is_ray_tracing(theirs->extensionName))
            continue;
        assert_string_equal(fixture.extensions[at].extensionName, theirs->extensionName);
        assert_int_equal(fixture.extensions[at++].specVersion, theirs->specVersion);
    }
    assert_int_equal(at + BACKEND_EXTENSIONS, fixture.extension_count);
    if (platform.is_null)
        assert_int_equal(instance_fixture_count_extension(&other, VK_KHR_RAY_QUERY_EXTENSION_NAME),
                         1);
    instance_fixture_close(&other);
}

OFFER_TEST(test_extension_counts)
{
    const PFN_vkEnumerateDeviceExtensionProperties enumerate =
        fixture.vk.EnumerateDeviceExtensionProperties;
    static VkExtensionProperties list[INSTANCE_FIXTURE_EXTENSIONS_MAX];
    uint32_t count = 77;
    GET(enumerate(fixture.physical, NULL, &count, NULL));
    assert_int_equal(count, fixture.extension_count);

    for (uint32_t room = 0; room <= fixture.extension_count + 1; room++) {
        memset(list, 0x5a, sizeof(list));
        count = room;
        const bool is_all = room >= fixture.extension_count;
        assert_int_equal(enumerate(fixture.physical, NULL, &count, list),
                         is_all ? VK_SUCCESS : VK_INCOMPLETE);
        assert_int_equal(count, is_all ? fixture.extension_count : room);
        assert_memory_equal(list, fixture.extensions, count * sizeof(*list));
        assert_int_equal(list[count].extensionName[0], 0x5a);
    }
}

OFFER_TEST(test_failing_enumeration)
{
    if (!platform.is_null)
        skip();
    uint32_t count = 77;
    platform.null_driver.fail_at("vkEnumerateDeviceExtensionProperties", 1,
                                 VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(
        fixture.vk.EnumerateDeviceExtensionProperties(fixture.physical, NULL, &count, NULL),
        VK_ERROR_OUT_OF_HOST_MEMORY);
}

/* ---- features and properties */

/* An extension's features. */
#define FEATURE(structure, name, ...)                                                              \
    {                                                                                              \
        "VkPhysicalDevice" #structure "." #name, __VA_ARGS__                                       \
    }
static const struct {
    const char *name;
    bool is_offered;
    const char *message; /* to a device that asks for it; NULL: none of the test does */
} backend_features[] = {
    FEATURE(AccelerationStructureFeaturesKHR, accelerationStructure, true),
    FEATURE(AccelerationStructureFeaturesKHR, accelerationStructureIndirectBuild, true),
    FEATURE(AccelerationStructureFeaturesKHR, accelerationStructureHostCommands, true),
    FEATURE(AccelerationStructureFeaturesKHR, accelerationStructureCaptureReplay, false,
            "CaptureReplay"),
    FEATURE(AccelerationStructureFeaturesKHR, descriptorBindingAccelerationStructureUpdateAfterBind,
            false),
    FEATURE(RayQueryFeaturesKHR, rayQuery, false, "RayQueryFeatures"),
    FEATURE(RayTracingMotionBlurFeaturesNV, rayTracingMotionBlur, true),
    FEATURE(RayTracingMotionBlurFeaturesNV, rayTracingMotionBlurPipelineTraceRaysIndirect, false,
            "PipelineTraceRaysIndirect"),
    FEATURE(RayTracingLinearSweptSpheresFeaturesNV, spheres, true),
    FEATURE(RayTracingLinearSweptSpheresFeaturesNV, linearSweptSpheres, true),
    FEATURE(DenseGeometryFormatFeaturesAMDX, denseGeometryFormat, true),
    FEATURE(OpacityMicromapFeaturesEXT, micromap, true),
    FEATURE(OpacityMicromapFeaturesEXT, micromapHostCommands, true),
    FEATURE(OpacityMicromapFeaturesEXT, micromapCaptureReplay, false),
    FEATURE(OpacityMicromapFeaturesKHR, micromap, true),
    FEATURE(DisplacementMicromapFeaturesNV, displacementMicromap, true),
};

/* Before the query each feature is what it must not be. A device is made of what is offered. */
OFFER_TEST(test_features)
{
    static struct device_wish wish;
    struct {
        VkStructureType sType;
        void *pNext;
        uint32_t unknown;
    } unknown = {VK_STRUCTURE_TYPE_MAX_ENUM, NULL, 77};
    STRUCT(VkPhysicalDeviceVulkan12Features, core, .pNext = &unknown);
    VkDevice device;
    VkuDeviceDispatchTable vk;
    device_wish_begin(&wish);
    for (size_t i = 0; i < ARRAY_COUNT(backend_features); i++)
        assert_true(
            device_wish_set(&wish, backend_features[i].name, !backend_features[i].is_offered));
    void *const chain = unknown.pNext = wish.features.pNext;
    wish.features.pNext = &core;
    fixture.vk.GetPhysicalDeviceFeatures2(fixture.physical, &wish.features);
    for (size_t i = 0; i < ARRAY_COUNT(backend_features); i++)
        if (device_wish_has(&wish, backend_features[i].name) != backend_features[i].is_offered)
            fail_msg("%s", backend_features[i].name);
    assert_int_equal(unknown.unknown, 77);
    assert_ptr_equal(core.pNext, &unknown);
    assert_ptr_equal(unknown.pNext, chain);
    assert_true(core.bufferDeviceAddress);
    assert_true(core.timelineSemaphore);
    GET(instance_fixture_create_device(&fixture, chain, backend_extensions, BACKEND_EXTENSIONS,
                                       &device, &vk));
    vk.DestroyDevice(device, NULL);
}

OFFER_TEST(test_properties)
{
    STRUCT(VkPhysicalDeviceRayTracingPipelinePropertiesKHR, pipelines, .maxRayRecursionDepth = 77);
    STRUCT(VkPhysicalDeviceDisplacementMicromapPropertiesNV, displacement, .pNext = &pipelines);
    STRUCT(VkPhysicalDeviceOpacityMicromapPropertiesKHR, micromap_khr, .pNext = &displacement);
    STRUCT(VkPhysicalDeviceOpacityMicromapPropertiesEXT, micromap_ext, .pNext = &micromap_khr);
    STRUCT(VkPhysicalDeviceRayTracingPropertiesNV, nv, .pNext = &micromap_ext,
           .maxDescriptorSetAccelerationStructures = 77);
    STRUCT(VkPhysicalDeviceAccelerationStructurePropertiesKHR, structures, .pNext = &nv);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &structures);
    fixture.vk.GetPhysicalDeviceProperties2(fixture.physical, &properties);
    /* The least that the specification allows. */
    assert_true(structures.maxGeometryCount >= (1 << 24) - 1);
    assert_true(structures.maxInstanceCount >= (1 << 24) - 1);
    assert_true(structures.maxPrimitiveCount >= (1 << 29) - 1);
    assert_int_equal(structures.minAccelerationStructureScratchOffsetAlignment, 256);
    assert_int_equal(structures.maxPerStageDescriptorAccelerationStructures, 0);
    assert_true(nv.maxGeometryCount >= (1 << 24) - 1);
    assert_true(nv.maxInstanceCount >= (1 << 24) - 1);
    assert_true(nv.maxTriangleCount >= (1 << 29) - 1);
    assert_int_equal(nv.shaderGroupHandleSize, 16);
    assert_int_equal(nv.shaderGroupBaseAlignment, 64);
    assert_int_equal(nv.maxDescriptorSetAccelerationStructures, 0);
    assert_ptr_equal(structures.pNext, &nv);
    assert_ptr_equal(nv.pNext, &micromap_ext);
    assert_int_equal(micromap_ext.maxOpacity2StateSubdivisionLevel, MICROMAP_MAX_LEVEL);
    assert_int_equal(micromap_ext.maxOpacity4StateSubdivisionLevel, MICROMAP_MAX_LEVEL);
    assert_int_equal(micromap_khr.maxOpacityLossy4StateSubdivisionLevel, MICROMAP_MAX_LEVEL);
    assert_true(micromap_khr.maxMicromapTriangles >= (1 << 29) - 1);
    assert_int_equal(displacement.maxDisplacementMicromapSubdivisionLevel, DISPLACEMENT_MAX_LEVEL);
    assert_int_equal(pipelines.maxRayRecursionDepth, 0);
    assert_true(properties.properties.limits.maxMemoryAllocationCount > 0);
}

/* ---- formats */

enum {
    VERTICES = VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR,
};

OFFER_TEST(test_formats)
{
    for (VkFormat format = VK_FORMAT_UNDEFINED; format <= VK_FORMAT_ASTC_12x12_SRGB_BLOCK;
         format++) {
        const bool is_vertex = vertex_format_find(format) != NULL;
        VkFormatProperties first;
        fixture.vk.GetPhysicalDeviceFormatProperties(fixture.physical, format, &first);
        assert_int_equal((first.bufferFeatures & VERTICES) != 0, is_vertex);

        STRUCT(VkFormatProperties3, third);
        STRUCT(VkFormatProperties2, second, .pNext = &third);
        fixture.vk.GetPhysicalDeviceFormatProperties2(fixture.physical, format, &second);
        assert_int_equal(second.formatProperties.bufferFeatures, first.bufferFeatures);
        assert_int_equal((third.bufferFeatures & VERTICES) != 0, is_vertex);
        const bool is_radius =
            third.bufferFeatures & VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV;
        assert_int_equal(is_radius, radius_format_size(format) != 0);
    }
}

/* ---- physical devices that the backend can't serve */

static void configure_1_0(struct null_driver_config *config)
{
    config->api_version = VK_API_VERSION_1_0;
}

static void configure_without_addresses(struct null_driver_config *config)
{
    null_driver_set_feature(
        config, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES,
        offsetof(VkPhysicalDeviceBufferDeviceAddressFeatures, bufferDeviceAddress), VK_FALSE);
}

TEST(test_without_what_it_needs)
{
    static const struct instance_fixture_setup setups[] = {
        {.configure = configure_1_0},
        {.api_version = VK_API_VERSION_1_0},
        {.configure = configure_without_addresses},
    };
    if (!platform.is_null)
        skip();
    for (size_t i = 0; i < ARRAY_COUNT(setups); i++) {
        VkFormatProperties properties;
        instance_fixture_open(&other, &platform, &setups[i]);
        assert_int_equal(
            instance_fixture_count_extension(&other, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME),
            0);
        other.vk.GetPhysicalDeviceFormatProperties(other.physical, VK_FORMAT_R8G8_UNORM,
                                                   &properties);
        assert_false(properties.bufferFeatures & VERTICES);
        instance_fixture_close(&other);
    }
}

TEST(test_backend_driver)
{
    instance_fixture_open(&other, &platform, &on_driver);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures);
    STRUCT(VkPhysicalDeviceFeatures2, features, .pNext = &structures);
    other.vk.GetPhysicalDeviceFeatures2(other.physical, &features);
    assert_int_equal(structures.accelerationStructureCaptureReplay, platform.is_null);
    instance_fixture_close(&other);
}

/* ---- devices */

/* Whether devices with some of the backend's extensions have a command. Either of those that have
 * structures is enough to trace them; the layer's own commands are those of backend cpu. */
static const struct command_row {
    const char *name;
    unsigned first, count; /* of the extensions */
    bool is_there, is_on_driver;
} commands[] = {
    {"vkCreateAccelerationStructureKHR", 0, BACKEND_EXTENSIONS, true},
    {"vkGetAccelerationStructureDeviceAddressKHR", 0, BACKEND_EXTENSIONS, true},
    {"vkCreateRayTracingPipelinesKHR", 0, BACKEND_EXTENSIONS, false},
    {"vkNoSuchCommand", 0, BACKEND_EXTENSIONS, false},
    {"vkCreateAccelerationStructureKHR", 0, 0, false},
    {"vkCreateDeferredOperationKHR", 0, 0, false},
    {"vkTraceRaysASSAY", 0, 0, false},
    {"vkGetCountersASSAY", 0, 0, false},
    {"vkCreateAccelerationStructureNV", NV_STRUCTURES, 1, true},
    {"vkCmdBuildAccelerationStructureNV", NV_STRUCTURES, 1, true},
    {"vkCmdTraceRaysNV", NV_STRUCTURES, 1, true},
    {"vkCreateAccelerationStructureKHR", NV_STRUCTURES, 1, false},
    {"vkCreateDeferredOperationKHR", NV_STRUCTURES, 1, false},
    {"vkTraceRaysASSAY", NV_STRUCTURES, 1, true},
    {"vkCreateAccelerationStructureNV", DEFERRED, 1, false},
    {"vkCreateRayTracingPipelinesNV", DEFERRED, 1, false},
    {"vkTraceRaysASSAY", KHR_STRUCTURES, 2, true},
    {"vkGetCountersASSAY", KHR_STRUCTURES, 2, true},
    {"vkTraceRaysASSAY", KHR_STRUCTURES, 2, false, .is_on_driver = true},
    {"vkGetCountersASSAY", KHR_STRUCTURES, 2, false, .is_on_driver = true},
};

/* While there is the device, another one, which has none of the extensions, comes and goes. */
OFFER_TEST(test_commands)
{
    VkuDeviceDispatchTable vk, plain;
    VkDevice device = VK_NULL_HANDLE, without;
    instance_fixture_open(&other, &platform, &on_driver);
    for (size_t i = 0; i < ARRAY_COUNT(commands); i++) {
        const struct command_row *row = &commands[i], *last = i > 0 ? row - 1 : NULL;
        const struct instance_fixture *of = row->is_on_driver ? &other : &fixture;
        if (!last || last->first != row->first || last->count != row->count ||
            last->is_on_driver != row->is_on_driver) {
            if (last)
                vk.DestroyDevice(device, NULL);
            GET(instance_fixture_create_device(of, NULL, backend_extensions + row->first,
                                               row->count, &device, &vk));
            GET(instance_fixture_create_device(of, NULL, NULL, 0, &without, &plain));
            plain.DestroyDevice(without, NULL);
        }
        if ((of->get_device_proc_addr(device, row->name) != NULL) != row->is_there)
            fail_msg("%s with %u extensions from number %u", row->name, row->count, row->first);
    }
    vk.DestroyDevice(device, NULL);
    instance_fixture_close(&other);
}

/* What a driver has of the same extension isn't asked. */
TEST(test_over_a_driver_with_nv)
{
    if (!platform.is_null)
        skip();
    static const struct instance_fixture_setup setup = {.driver_traces = true};
    static const char *const extensions[] = {VK_NV_RAY_TRACING_EXTENSION_NAME};
    VkuDeviceDispatchTable vk;
    VkDevice device;
    VkAccelerationStructureNV structure;
    const STRUCT(VkAccelerationStructureCreateInfoNV, info,
                 .info = MAKE(VkAccelerationStructureInfoNV));
    instance_fixture_open(&other, &platform, &setup);
    assert_int_equal(instance_fixture_count_extension(&other, VK_NV_RAY_TRACING_EXTENSION_NAME), 1);
    GET(instance_fixture_create_device(&other, NULL, extensions, 1, &device, &vk));
    GET(vk.CreateAccelerationStructureNV(device, &info, NULL, &structure));
    vk.DestroyAccelerationStructureNV(device, structure, NULL);
    assert_int_equal(platform.null_driver.calls("vkCreateAccelerationStructureNV"), 0);
    vk.DestroyDevice(device, NULL);
    instance_fixture_close(&other);
}

/* Known and unknown structures stand before and behind the features in the chain. */
OFFER_TEST(test_chains)
{
    enum { LINKS = 5 };
    for (unsigned place = 0; place < LINKS; place++) {
        struct {
            VkStructureType sType;
            void *pNext;
            uint64_t members[300];
        } unknown[2] = {{.sType = VK_STRUCTURE_TYPE_MAX_ENUM},
                        {.sType = VK_STRUCTURE_TYPE_MAX_ENUM - 1}};
        STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, none);
        STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
               .accelerationStructure = VK_TRUE, .accelerationStructureHostCommands = VK_TRUE);
        STRUCT(VkPhysicalDeviceRayTracingMotionBlurFeaturesNV, motion,
               .rayTracingMotionBlur = VK_TRUE);
        VkBaseOutStructure *links[LINKS], *chain = NULL, heads[LINKS];
        unsigned count = 0;
        void *others[] = {&unknown[0], &none, &motion, &unknown[1]};
        for (unsigned i = 0; i < LINKS; i++)
            links[i] = i == place ? (void *)&structures : others[count++];
        for (unsigned i = LINKS; i-- > 0;) {
            links[i]->pNext = chain;
            chain = links[i];
        }
        for (unsigned i = 0; i < LINKS; i++)
            heads[i] = *links[i];
        VkuDeviceDispatchTable vk;
        VkDevice device;
        GET(instance_fixture_create_device(&fixture, chain, backend_extensions, 3, &device, &vk));
        for (unsigned i = 0; i < LINKS; i++)
            assert_memory_equal(&heads[i], links[i], sizeof(heads[i]));
        vk.DestroyDevice(device, NULL);
    }
}

/* Each refused with one message about the feature, if it is not an extension that is refused. */
OFFER_TEST(test_what_is_not_offered)
{
    static struct device_wish wish;
    VkuDeviceDispatchTable vk;
    VkDevice device;
    for (size_t i = 0; i < ARRAY_COUNT(backend_features); i++) {
        if (!backend_features[i].message)
            continue;
        messages_clear(&fixture.messages);
        device_wish_begin(&wish);
        device_wish_set(&wish, backend_features[i].name, VK_TRUE);
        assert_int_equal(instance_fixture_create_device(&fixture, wish.features.pNext,
                                                        wish.extensions, wish.extension_count,
                                                        &device, &vk),
                         VK_ERROR_FEATURE_NOT_PRESENT);
        assert_int_equal(
            messages_count(&fixture.messages, "ASSAY-error", "assay_validation.backend"), 1);
        assert_int_equal(
            messages_count(&fixture.messages, "ASSAY-error", backend_features[i].message), 1);
    }
    device_wish_add(&wish, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    assert_int_equal(instance_fixture_create_device(&fixture, NULL, wish.extensions,
                                                    wish.extension_count, &device, &vk),
                     VK_ERROR_EXTENSION_NOT_PRESENT);
    messages_clear(&fixture.messages);
}
