/* SPDX-License-Identifier: Apache-2.0 */
/* other_layers_test null|lavapipe: the layer above and below others. Some of those ask the next
 * layer for vkCreateDevice without an instance, which the Khronos layer answers, too. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "layer/intercepts/intercepts.h"
#include "loader_test.h"
#include "strict_layer.h"

#define OVERLAY_NAME "VK_LAYER_MESA_overlay"

/* One valid call, and one with a mistake. Loaders order layers by the variable that enables them,
 * or by the folders in which they find them: the nearest to the application is first. */
static void find_mistake(bool is_below, const char *other, const char *folder)
{
    const struct setup setup = {.by_environment = true};
    char layers[256], path[1024];

    snprintf(layers, sizeof(layers), "%s:%s", is_below ? other : LAYER_NAME,
             is_below ? LAYER_NAME : other);
    snprintf(path, sizeof(path), "%s:%s", is_below ? folder : EXPLICIT_FOLDER,
             is_below ? EXPLICIT_FOLDER : folder);
    setenv("VK_INSTANCE_LAYERS", layers, 1);
    setenv("VK_LAYER_PATH", path, 1);
    assert_int_equal(count_findings(&setup), 1);
    unsetenv("VK_INSTANCE_LAYERS");
}

TEST(test_below_the_strict_layer)
{
    find_mistake(true, STRICT_LAYER_NAME, STRICT_FOLDER);
}

TEST(test_above_the_strict_layer)
{
    find_mistake(false, STRICT_LAYER_NAME, STRICT_FOLDER);
}

/* Mesa's overlay leaves memory behind that only its own library refers to: while that stays loaded,
 * the sanitizer counts no leak. */
static void need_overlay(void)
{
    if (!layer_is_installed(OVERLAY_NAME, SYSTEM_FOLDER)) {
        print_message("%s is not installed\n", OVERLAY_NAME);
        skip();
    }
    dlopen("libVkLayer_MESA_overlay.so", RTLD_NOW | RTLD_LOCAL);
}

TEST(test_below_the_overlay)
{
    need_overlay();
    find_mistake(true, OVERLAY_NAME, SYSTEM_FOLDER);
}

TEST(test_above_the_overlay)
{
    need_overlay();
    find_mistake(false, OVERLAY_NAME, SYSTEM_FOLDER);
}

/* All that is intercepted is answered without an instance, and nothing else. */
TEST(test_names_without_an_instance)
{
#define NAME(name) "vk" #name,
    static const char *const names[] = {ASSAY_GLOBAL_INTERCEPTS(NAME) ASSAY_INSTANCE_INTERCEPTS(
        NAME) ASSAY_DEVICE_INTERCEPTS(NAME)};
#undef NAME
    static const char *const others[] = {"vkEnumeratePhysicalDevices", "vkCmdDraw", "vkNone", ""};
    void *library = dlopen(LAYER_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(library);
    const PFN_vkNegotiateLoaderLayerInterfaceVersion negotiate =
        (PFN_vkNegotiateLoaderLayerInterfaceVersion)dlsym(library,
                                                          "vkNegotiateLoaderLayerInterfaceVersion");
    VkNegotiateLayerInterface interface = {.sType = LAYER_NEGOTIATE_INTERFACE_STRUCT,
                                           .loaderLayerInterfaceVersion = 2};
    assert_non_null(negotiate);
    assert_int_equal(negotiate(&interface), VK_SUCCESS);
    for (size_t i = 0; i < LENGTH(names); i++)
        if (!interface.pfnGetInstanceProcAddr(NULL, names[i]))
            fail_msg("%s is not answered", names[i]);
    for (size_t i = 0; i < LENGTH(others); i++)
        assert_null(interface.pfnGetInstanceProcAddr(NULL, others[i]));
    assert_null(interface.pfnGetDeviceProcAddr(NULL, "vkDestroyDevice"));
    dlclose(library);
}
