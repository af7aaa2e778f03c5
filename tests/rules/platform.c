/* SPDX-License-Identifier: Apache-2.0 */
/* Opening the loader and pointing it to the layer and one driver. */
#include "platform.h"
#include "tests/fixture/make.h"

#include <dlfcn.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *null_driver_open(struct platform *platform)
{
    platform->is_null = true;
    if (null_driver_load(NULL_DRIVER_LIBRARY, &platform->null_driver) == NULL)
        return "the null driver cannot be loaded";
    setenv("VK_DRIVER_FILES", NULL_DRIVER_MANIFEST, 1);
    return NULL;
}

static const char *lavapipe_find(void)
{
    const char *reason = "lavapipe is not installed";
    glob_t found = {0};

    if (glob("/usr/share/vulkan/icd.d/lvp_icd*.json", 0, NULL, &found) == 0) {
        setenv("VK_DRIVER_FILES", found.gl_pathv[0], 1);
        reason = NULL;
    }
    globfree(&found);
    return reason;
}

/* A driver may not bear to be loaded and unloaded as often as fixtures open and close (NVIDIA's
 * fails after some twenty times), so one instance holds it for as long as the program lives. */
static void hold_driver(const struct platform *platform)
{
    static VkInstance instance;
    const STRUCT(VkInstanceCreateInfo, info);
    const PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)platform->get_instance_proc_addr(NULL, "vkCreateInstance");
    if (create != NULL)
        create(&info, NULL, &instance);
}

const char *platform_open_loader(struct platform *platform)
{
    void *loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (loader == NULL)
        return "there is no libvulkan.so.1";
    platform->get_instance_proc_addr =
        (PFN_vkGetInstanceProcAddr)dlsym(loader, "vkGetInstanceProcAddr");
    return platform->get_instance_proc_addr != NULL ? NULL
                                                    : "libvulkan.so.1 lacks vkGetInstanceProcAddr";
}

const char *platform_open(struct platform *platform, const char *name)
{
    const char *reason;

    *platform = (struct platform){.name = name,
                                  .is_cpu = strncmp(name, "cpu_", 4) == 0,
                                  .is_guarded = strncmp(name, "guard_", 6) == 0};
    const char *driver = platform->is_cpu ? name + 4 : platform->is_guarded ? name + 6 : name;
    platform->is_named = strcmp(driver, "environment") == 0;
    if (strcmp(driver, "null") == 0) {
        reason = null_driver_open(platform);
    } else if (strcmp(driver, "lavapipe") == 0) {
        reason = lavapipe_find();
    } else if (platform->is_named) {
        reason = getenv("VK_DRIVER_FILES") != NULL ? NULL : "VK_DRIVER_FILES is not set";
    } else {
        fprintf(stderr, "platform '%s' is none of " PLATFORM_NAMES "\n", name);
        exit(2);
    }
    if (reason != NULL)
        return reason;
    if (platform->is_cpu)
        setenv("VK_ASSAY_VALIDATION_BACKEND", "cpu", 1);
    if (platform->is_guarded)
        setenv("VK_ASSAY_VALIDATION_GUARD", "references", 1);

    /* scripts/bench findings plays another layer by the name of this one. */
    const char *folder = getenv("ASSAY_TEST_LAYERS");
    setenv("VK_LAYER_PATH", folder != NULL ? folder : LAYER_FOLDER, !platform->is_named);
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    /* Other layers beside the layer, above it or below. */
    const char *layers = getenv("ASSAY_TEST_INSTANCE_LAYERS");
    if (layers)
        setenv("VK_INSTANCE_LAYERS", layers, 1);
    else
        unsetenv("VK_INSTANCE_LAYERS");
    unsetenv("VK_LOADER_LAYERS_ENABLE");

    reason = platform_open_loader(platform);
    if (reason == NULL && platform->is_named)
        hold_driver(platform);
    return reason;
}
