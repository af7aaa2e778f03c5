/* SPDX-License-Identifier: Apache-2.0 */
/* A device with or without the layer. */
#include "side.h"

#include <glob.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fixture/messenger.h"

PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char *pName); /* the loader's */

/* ---- the loader's environment */

static void select_lavapipe(void)
{
    glob_t found = {0};
    if (glob("/usr/share/vulkan/icd.d/lvp_icd*.json", 0, NULL, &found) != 0)
        tool_fail("lavapipe is not installed: run scripts/setup, or ask for --driver null");
    setenv("VK_DRIVER_FILES", found.gl_pathv[0], 1);
    globfree(&found);
}

void layers_select_all(const char *folder)
{
    char path[4096];
    snprintf(path, sizeof(path), "%s%s%s", BENCH_LAYER_FOLDER, folder ? ":" : "",
             folder ? folder : "");
    unsetenv("VK_LAYER_PATH");
    setenv("VK_ADD_LAYER_PATH", path, 1);
}

bool layer_find(const char *name, VkLayerProperties *found)
{
    PFN_vkEnumerateInstanceLayerProperties enumerate =
        (PFN_vkEnumerateInstanceLayerProperties)vkGetInstanceProcAddr(
            VK_NULL_HANDLE, "vkEnumerateInstanceLayerProperties");
    uint32_t count = 0;
    tool_check(enumerate(&count, NULL), "vkEnumerateInstanceLayerProperties");
    VkLayerProperties *layers = tool_alloc(count, sizeof(*layers));
    tool_check(enumerate(&count, layers), "vkEnumerateInstanceLayerProperties");
    bool is_found = false;
    for (uint32_t i = 0; i < count && !is_found; i++) {
        is_found = strcmp(layers[i].layerName, name) == 0;
        *found = layers[i];
    }
    free(layers);
    return is_found;
}

void driver_select(const char *name)
{
    if (strcmp(name, "lavapipe") == 0)
        select_lavapipe();
    else
        setenv("VK_DRIVER_FILES", BENCH_NULL_DRIVER_MANIFEST, 1);
    if (!getenv("VK_ADD_LAYER_PATH"))
        setenv("VK_LAYER_PATH", BENCH_LAYER_FOLDER, 0);
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    unsetenv("VK_INSTANCE_LAYERS");
    unsetenv("VK_LOADER_LAYERS_ENABLE");
}

/* ---- the instance and the device */

MESSENGER_CALLBACK(count_finding)
{
    struct side_findings *findings = user;
    if (findings->is_open && ++findings->count == 1)
        fprintf(stderr, "%s\n", data->pMessage);
    return VK_FALSE;
}

/* The figures mean nothing where a layer isn't on its side, or is on another. */
static void require_layer(const struct side *side, const char *layer)
{
    uint32_t count = 0;
    bool found = false, wanted = side->layer && strcmp(side->layer, layer) == 0;
    TOOL_CALL(side->gpu.instance_calls, EnumerateDeviceLayerProperties, side->gpu.physical, &count,
              NULL);
    VkLayerProperties *enabled = tool_alloc(count, sizeof(*enabled));
    TOOL_CALL(side->gpu.instance_calls, EnumerateDeviceLayerProperties, side->gpu.physical, &count,
              enabled);
    for (uint32_t i = 0; i < count; i++)
        found = found || strcmp(enabled[i].layerName, layer) == 0;
    free(enabled);
    if (found != wanted)
        tool_fail("%s is %s", layer, wanted ? "not enabled" : "enabled on a side without it");
}

void side_open(struct side *side, const char *layer, const char *level)
{
    const VkLayerSettingEXT settings[] = {
        {GPU_LAYER, "hazards", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1, &(const VkBool32){VK_FALSE}},
        {GPU_LAYER, "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &level},
    };
    side_open_with(side, layer, settings, layer ? 1 + (level != NULL) : 0);
}

void side_open_with(struct side *side, const char *layer, const VkLayerSettingEXT *settings,
                    uint32_t count)
{
    const STRUCT(VkLayerSettingsCreateInfoEXT, all, .settingCount = count, .pSettings = settings);
    *side = (struct side){.layer = layer, .findings = tool_alloc(1, sizeof(*side->findings))};
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, messenger, .pNext = count ? &all : NULL,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                    VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                 .pfnUserCallback = count_finding, .pUserData = side->findings);
    gpu_open(&side->gpu, layer, &messenger, false);
    require_layer(side, GPU_LAYER);
    require_layer(side, BENCH_PEER);
    side->findings->is_open = true; /* the tables ask for what there is not, and layers say so */
}

void side_close(struct side *side)
{
    gpu_close(&side->gpu);
    const bool are_expected = side->layer && side->findings->are_expected;
    if (are_expected && !side->findings->count)
        tool_fail("%s reports no finding: the recorded builds should have some", side->layer);
    if (!are_expected && side->findings->count)
        tool_fail("%s reports %u findings: the recorded builds should have none", side->layer,
                  side->findings->count);
    free(side->findings);
}
