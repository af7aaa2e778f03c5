/* SPDX-License-Identifier: Apache-2.0 */
/* versions_test null|lavapipe: the layer calls no command of a physical device that the application
 * itself may not call, for the version that it asks for or for want of an extension. The strict
 * layer, below this one, counts such calls. */
#include <dlfcn.h>

#include "loader_test.h"
#include "strict_layer.h"

enum { GEOMETRIES = 257 }; /* one more than the null driver's limit */

static unsigned (*violations)(void);
static struct messages messages;

const char *loader_test_open(void)
{
    setenv("VK_LAYER_PATH", EXPLICIT_FOLDER ":" STRICT_FOLDER, 1);
    void *library = dlopen(STRICT_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(library);
    violations = (unsigned (*)(void))dlsym(library, "strict_layer_violations");
    assert_non_null(violations);
    return NULL;
}

struct application {
    uint32_t api_version, driver_version; /* 0: VK_API_VERSION_1_3 */
    bool has_properties2;                 /* enables VK_KHR_get_physical_device_properties2 */
    const char *backend;                  /* NULL: driver */
};

static void configure(const struct application *application)
{
    if (!platform.is_null)
        return;
    struct null_driver_config config = platform.null_driver.default_config();
    if (application->driver_version)
        config.api_version = application->driver_version;
    platform.null_driver.configure(&config);
}

static VkInstance create_instance(const struct application *application)
{
    static const char *const layers[] = {LAYER_NAME, STRICT_LAYER_NAME};
    static const char *const extensions[] = {
        VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME};
    const VkLayerSettingEXT setting = {LAYER_NAME, "backend", VK_LAYER_SETTING_TYPE_STRING_EXT, 1,
                                       &application->backend};
    const STRUCT(VkLayerSettingsCreateInfoEXT, settings,
                 .settingCount = application->backend ? 1 : 0, .pSettings = &setting);
    const STRUCT(VkApplicationInfo, info, .apiVersion = application->api_version);
    const STRUCT(VkInstanceCreateInfo, create_info, .pNext = &settings, .pApplicationInfo = &info,
                 .enabledLayerCount = 2, .ppEnabledLayerNames = layers,
                 .enabledExtensionCount = application->has_properties2 ? 2 : 1,
                 .ppEnabledExtensionNames = extensions);
    VkInstance instance;
    configure(application);
    GET(GLOBAL(CreateInstance)(&create_info, NULL, &instance));
    return instance;
}

static bool offers(const VkuInstanceDispatchTable *vki, VkPhysicalDevice physical_device,
                   const char *extension)
{
    static VkExtensionProperties list[512];
    uint32_t count = 512;
    GET(vki->EnumerateDeviceExtensionProperties(physical_device, NULL, &count, list));
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(list[i].extensionName, extension) == 0)
            return true;
    return false;
}

/* Records a build of more geometries than the null driver takes. */
static void build(VkDevice device, const VkuDeviceDispatchTable *vk)
{
    static VkGeometryNV geometries[GEOMETRIES];
    const STRUCT(VkAccelerationStructureInfoNV, info,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV,
                 .geometryCount = GEOMETRIES, .pGeometries = geometries);
    for (int i = 0; i < GEOMETRIES; i++)
        geometries[i].sType = VK_STRUCTURE_TYPE_GEOMETRY_NV;
    const VkCommandPool pool = command_pool_create(vk, device);
    const VkCommandBuffer commands =
        commands_begin(vk, device, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    messages_clear(&messages);
    messages.answer = VK_TRUE;
    vk->CmdBuildAccelerationStructureNV(commands, &info, VK_NULL_HANDLE, 0, VK_FALSE,
                                        VK_NULL_HANDLE, VK_NULL_HANDLE, VK_NULL_HANDLE, 0);
    messages.answer = VK_FALSE;
    vk->DestroyCommandPool(device, pool, NULL);
}

static void use_device(const VkuInstanceDispatchTable *vki, VkInstance instance,
                       VkPhysicalDevice physical_device)
{
    static const char *const extensions[] = {VK_KHR_GET_MEMORY_REQUIREMENTS_2_EXTENSION_NAME,
                                             VK_NV_RAY_TRACING_EXTENSION_NAME};
    const float priority = 1;
    const STRUCT(VkDeviceQueueCreateInfo, queue, .queueCount = 1, .pQueuePriorities = &priority);
    const STRUCT(VkDeviceCreateInfo, info, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue,
                 .enabledExtensionCount = offers(vki, physical_device, extensions[1]) ? 2 : 1,
                 .ppEnabledExtensionNames = extensions);
    VkuDeviceDispatchTable vk;
    VkDevice device;
    GET(COMMAND_OF(instance, CreateDevice)(physical_device, &info, NULL, &device));
    vkuInitDeviceDispatchTable(device, &vk, COMMAND_OF(instance, GetDeviceProcAddr));
    if (info.enabledExtensionCount == 2)
        build(device, &vk);
    vk.DestroyDevice(device, NULL);
}

/* Whether the application finds VK_NV_ray_tracing. What it does with that is in `messages`. */
static bool run(const struct application *application)
{
    const VkInstance instance = create_instance(application);
    const VkDebugUtilsMessengerCreateInfoEXT info = messages_messenger(&messages);
    VkuInstanceDispatchTable vki;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical_device;
    uint32_t count = 1;

    vkuInitInstanceDispatchTable(instance, &vki, platform.get_instance_proc_addr);
    messages_clear(&messages);
    GET(vki.CreateDebugUtilsMessengerEXT(instance, &info, NULL, &messenger));
    vki.EnumeratePhysicalDevices(instance, &count, &physical_device);
    assert_int_equal(count, 1);
    const bool has_extension = offers(&vki, physical_device, VK_NV_RAY_TRACING_EXTENSION_NAME);
    use_device(&vki, instance, physical_device);
    vki.DestroyDebugUtilsMessengerEXT(instance, messenger, NULL);
    vki.DestroyInstance(instance, NULL);
    assert_int_equal(violations(), 0);
    return has_extension;
}

static bool limit_was_exceeded(void)
{
    return messages_count(&messages, "VUID-vkCmdBuildAccelerationStructureNV-geometryCount-02241",
                          NULL) > 0;
}

/* ---- limits that the application may not ask for bound nothing */

enum answer { NO, YES, IF_NULL, ANY }; /* IF_NULL: on the null driver */

static const struct version_case {
    const char *test;
    struct application application;
    enum answer has_extension, limit_exceeded;
} cases[] = {
    {"test_1_0_with_the_extension",
     {.api_version = VK_API_VERSION_1_0, .has_properties2 = true},
     IF_NULL,
     IF_NULL},
    {"test_1_0_without_the_extension", {.api_version = VK_API_VERSION_1_0}, ANY, NO},
    {"test_no_version", {0}, ANY, NO},
    {"test_1_1", {.api_version = VK_API_VERSION_1_1}, ANY, IF_NULL},
    /* The physical device's version counts, too. */
    {"test_1_1_over_a_driver_of_1_0",
     {.api_version = VK_API_VERSION_1_1, .driver_version = VK_API_VERSION_1_0},
     ANY,
     NO},
    {"test_1_1_with_the_extension_over_a_driver_of_1_0",
     {.api_version = VK_API_VERSION_1_1,
      .driver_version = VK_API_VERSION_1_0,
      .has_properties2 = true},
     ANY,
     IF_NULL},
    {"test_cpu_1_0_with_the_extension",
     {.api_version = VK_API_VERSION_1_0, .has_properties2 = true, .backend = "cpu"},
     YES,
     NO},
    /* VK_NV_ray_tracing needs the extension, or Vulkan 1.1. The null driver has its own. */
    {"test_cpu_1_0_without_the_extension",
     {.api_version = VK_API_VERSION_1_0, .backend = "cpu"},
     IF_NULL,
     ANY},
    {"test_cpu_1_1", {.api_version = VK_API_VERSION_1_1, .backend = "cpu"}, YES, ANY},
};

static void assert_answer(enum answer expected, bool answer)
{
    if (expected != ANY)
        assert_int_equal(answer, expected == YES || (expected == IF_NULL && platform.is_null));
}

TEST_OF_ROWS(test_version, cases, const struct version_case *version, unit_test_nothing)
{
    assert_answer(version->has_extension, run(&version->application));
    assert_answer(version->limit_exceeded, limit_was_exceeded());
}

/* ---- limits = harsh: core commands and those of the extension */

static uint32_t scratch_alignment(VkPhysicalDevice physical_device,
                                  PFN_vkGetPhysicalDeviceProperties2 get)
{
    STRUCT(VkPhysicalDeviceAccelerationStructurePropertiesKHR, limits);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &limits);
    get(physical_device, &properties);
    return limits.minAccelerationStructureScratchOffsetAlignment;
}

static bool is_tool_that_modifies(VkInstance instance, VkPhysicalDevice physical_device)
{
    STRUCT(VkPhysicalDeviceToolProperties, tool);
    uint32_t count = 1;
    COMMAND_OF(instance, GetPhysicalDeviceToolProperties)(physical_device, &count, &tool);
    return tool.purposes & VK_TOOL_PURPOSE_MODIFYING_FEATURES_BIT;
}

static void check_harsh(uint32_t api_version, const char *command, bool is_harsh)
{
    const struct application application = {.api_version = api_version, .has_properties2 = true};
    VkPhysicalDevice physical_device;
    uint32_t count = 1;
    const VkInstance instance = create_instance(&application);
    COMMAND_OF(instance, EnumeratePhysicalDevices)(instance, &count, &physical_device);
    const PFN_vkGetPhysicalDeviceProperties2 get =
        (PFN_vkGetPhysicalDeviceProperties2)platform.get_instance_proc_addr(instance, command);
    assert_non_null(get);
    const uint32_t alignment = scratch_alignment(physical_device, get);
    if (is_harsh)
        assert_int_equal(alignment, 256);
    else if (!platform.is_null)
        assert_in_range(alignment, 1, 128); /* lavapipe's */
    if (api_version >= VK_API_VERSION_1_3)
        assert_int_equal(is_tool_that_modifies(instance, physical_device), is_harsh);
    COMMAND_OF(instance, DestroyInstance)(instance, NULL);
}

TEST(test_harsh_limits)
{
    setenv("VK_ASSAY_VALIDATION_LIMITS", "harsh", 1);
    check_harsh(VK_API_VERSION_1_3, "vkGetPhysicalDeviceProperties2", true);
    check_harsh(VK_API_VERSION_1_3, "vkGetPhysicalDeviceProperties2KHR", true);
    check_harsh(VK_API_VERSION_1_0, "vkGetPhysicalDeviceProperties2KHR", true);
    unsetenv("VK_ASSAY_VALIDATION_LIMITS");
    check_harsh(VK_API_VERSION_1_3, "vkGetPhysicalDeviceProperties2", false);
    assert_int_equal(violations(), 0);
}

/* ---- commands of devices */

TEST(test_addresses_of_the_extension)
{
    static struct fixture fixture;
    const struct setup setup = {.level = "content", .route = ROUTE_KHR, .by_environment = true};
    setenv("VK_INSTANCE_LAYERS", LAYER_NAME ":" STRICT_LAYER_NAME, 1);
    assert_null(fixture_open(&fixture, &platform, &setup));
    unsetenv("VK_INSTANCE_LAYERS");
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    scene_call(scene);
    assert_int_equal(fixture.instance.messages.count, 0);
    scene_close(scene);
    fixture_close(&fixture);
    assert_int_equal(violations(), 0);
}
