/* SPDX-License-Identifier: Apache-2.0 */
/* other_layers_test null|lavapipe: the layer above and below others. Some of those ask the next
 * layer for vkCreateDevice without an instance, which the Khronos layer answers, too. */
#include <dlfcn.h>

#include "intercepted.h"
#include "loader_test.h"
#include "strict_layer.h"

#define OVERLAY_NAME "VK_LAYER_MESA_overlay"
#define CAPTURE_NAME "VK_LAYER_LUNARG_gfxreconstruct"
#define SELECT_NAME "VK_LAYER_MESA_device_select"

/* One valid call, and one with a mistake. */
static void find_mistake(bool is_above, const char *other, const char *folder)
{
    const struct setup setup = {.by_environment = true};
    enable_beside(other, folder, is_above);
    assert_int_equal(count_findings(&setup), 1);
    unsetenv("VK_INSTANCE_LAYERS");
}

/* Mesa's overlay leaves memory behind that only its own library refers to: while that stays loaded,
 * the sanitizer counts no leak. */
static void need_layer(const char *name)
{
    if (!layer_is_installed(name, SYSTEM_FOLDER)) {
        print_message("%s is not installed\n", name);
        skip();
    }
    dlopen("libVkLayer_MESA_overlay.so", RTLD_NOW | RTLD_LOCAL);
}

/* The capture of gfxreconstruct copies what calls point to. */
static void prepare_capture(void)
{
    setenv("GFXRECON_CAPTURE_FILE", "/dev/null", 1);
    setenv("GFXRECON_CAPTURE_FILE_TIMESTAMP", "false", 1);
    setenv("GFXRECON_LOG_LEVEL", "fatal", 1);
}

static const struct neighbour {
    const char *test, *name;
    bool is_above; /* this layer */
} neighbours[] = {
    {"test_below_the_strict_layer", STRICT_LAYER_NAME, false},
    {"test_above_the_strict_layer", STRICT_LAYER_NAME, true},
    {"test_below_the_overlay", OVERLAY_NAME, false},
    {"test_above_the_overlay", OVERLAY_NAME, true},
    {"test_below_the_capture", CAPTURE_NAME, false},
    {"test_above_the_capture", CAPTURE_NAME, true},
};

TEST_OF_ROWS(test_neighbour, neighbours, const struct neighbour *row, prepare_capture)
{
    const bool is_strict = strcmp(row->name, STRICT_LAYER_NAME) == 0;
    if (!is_strict)
        need_layer(row->name);
    find_mistake(row->is_above, row->name, is_strict ? STRICT_FOLDER : SYSTEM_FOLDER);
}

/* An implicit layer, which loaders put above explicit ones. */
TEST(test_below_device_select)
{
    unsetenv("VK_LOADER_LAYERS_DISABLE");
    need_layer(SELECT_NAME);
    find_mistake(false, STRICT_LAYER_NAME, STRICT_FOLDER);
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
}

/* The driver refuses what compare_rays adds. */
TEST_IF(test_second_attempt_above_the_strict_layer, platform.is_null)
{
    struct fixture fixture;
    setenv("VK_ASSAY_VALIDATION_COMPARE_RAYS", "16", 1);
    enable_beside(STRICT_LAYER_NAME, STRICT_FOLDER, true);
    platform.null_driver.reset();
    platform.null_driver.fail_at("vkCreateDevice", 1, VK_ERROR_INITIALIZATION_FAILED);
    assert_null(fixture_open(&fixture, &platform,
                             &(struct setup){.by_environment = true, .level = "content"}));
    assert_int_equal(platform.null_driver.calls("vkCreateDevice"), 2);
    fixture_close(&fixture);
    unsetenv("VK_INSTANCE_LAYERS");
    unsetenv("VK_ASSAY_VALIDATION_COMPARE_RAYS");
}

/* ---- the layer without a loader */

static VkNegotiateLayerInterface interface;

static void negotiate_with_layer(void)
{
    assert_non_null(platform.layer);
    const PFN_vkNegotiateLoaderLayerInterfaceVersion negotiate =
        (PFN_vkNegotiateLoaderLayerInterfaceVersion)dlsym(platform.layer,
                                                          "vkNegotiateLoaderLayerInterfaceVersion");
    interface = (VkNegotiateLayerInterface){.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT,
                                            .loaderLayerInterfaceVersion = 2};
    assert_non_null(negotiate);
    assert_int_equal(negotiate(&interface), VK_SUCCESS);
}

/* All that is intercepted is answered without an instance, and nothing else. */
TEST_OPENED(test_names_without_an_instance, negotiate_with_layer)
{
#define NAME(name) "vk" #name,
    static const char *const names[] = {ALWAYS_INTERCEPTED_COMMANDS(NAME)};
#undef NAME
    static const char *const others[] = {"vkEnumeratePhysicalDevices", "vkCmdDraw", "vkNone", ""};
    for (size_t i = 0; i < LENGTH(names); i++)
        if (!interface.pfnGetInstanceProcAddr(NULL, names[i]))
            fail_msg("%s is not answered", names[i]);
    for (size_t i = 0; i < LENGTH(others); i++)
        assert_null(interface.pfnGetInstanceProcAddr(NULL, others[i]));
    assert_null(interface.pfnGetDeviceProcAddr(NULL, "vkDestroyDevice"));
}

#define OF_LAYER(name) ((PFN_vk##name)interface.pfnGetInstanceProcAddr(NULL, "vk" #name))

/* Also of a device, whose handle the layer does not look at. */
TEST_OPENED(test_layers_that_the_layer_names, negotiate_with_layer)
{
    for (uint32_t room = 0; room < 3; room++) {
        VkLayerProperties layers[2][3] = {0};
        uint32_t counts[2] = {room, room};
        const VkResult results[2] = {
            OF_LAYER(EnumerateInstanceLayerProperties)(&counts[0], layers[0]),
            OF_LAYER(EnumerateDeviceLayerProperties)(VK_NULL_HANDLE, &counts[1], layers[1])};
        for (int i = 0; i < 2; i++) {
            assert_int_equal(results[i], room ? VK_SUCCESS : VK_INCOMPLETE);
            assert_int_equal(counts[i], room ? 1 : 0);
            assert_string_equal(layers[i][0].layerName, room ? LAYER_NAME : "");
            assert_string_equal(layers[i][1].layerName, "");
        }
    }
    uint32_t count = 0;
    assert_int_equal(OF_LAYER(EnumerateInstanceLayerProperties)(&count, NULL), VK_SUCCESS);
    assert_int_equal(count, 1);
}

TEST_OPENED(test_extensions_that_the_layer_names, negotiate_with_layer)
{
    const PFN_vkEnumerateInstanceExtensionProperties of_instance =
        OF_LAYER(EnumerateInstanceExtensionProperties);
    const PFN_vkEnumerateDeviceExtensionProperties of_device =
        OF_LAYER(EnumerateDeviceExtensionProperties);
    VkExtensionProperties extensions[8];
    uint32_t all = 0;
    assert_int_equal(of_instance(LAYER_NAME, &all, NULL), VK_SUCCESS);
    assert_in_range(all, 1, LENGTH(extensions) - 1);
    for (uint32_t room = 0; room <= all + 1; room++) {
        uint32_t count = room;
        memset(extensions, 0, sizeof(extensions));
        assert_int_equal(of_instance(LAYER_NAME, &count, extensions),
                         room < all ? VK_INCOMPLETE : VK_SUCCESS);
        assert_int_equal(count, room < all ? room : all);
        for (uint32_t i = 0; i < LENGTH(extensions); i++)
            assert_int_equal(extensions[i].extensionName[0] != '\0', i < count);
    }
    assert_int_equal(of_instance("VK_LAYER_other", &all, NULL), VK_ERROR_LAYER_NOT_PRESENT);
    assert_int_equal(of_instance(NULL, &all, NULL), VK_ERROR_LAYER_NOT_PRESENT);
    all = 1;
    assert_int_equal(of_device(VK_NULL_HANDLE, LAYER_NAME, &all, NULL), VK_SUCCESS);
    assert_int_equal(all, 0);
}
