/* SPDX-License-Identifier: Apache-2.0 */
#include "loader_test.h"

struct platform platform;

const char *unit_test_open(const char *argument)
{
    const char *missing = platform_open(&platform, argument ? argument : "null");
    return missing || !loader_test_open ? missing : loader_test_open();
}

bool layer_is_installed(const char *name, const char *folder)
{
    static VkLayerProperties layers[64];
    uint32_t count = LENGTH(layers);
    setenv("VK_LAYER_PATH", folder, 1);
    GLOBAL(EnumerateInstanceLayerProperties)(&count, layers);
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(layers[i].layerName, name) == 0)
            return true;
    return false;
}

void enable_beside(const char *other, const char *folder, bool is_above)
{
    char layers[256], folders[1024];
    snprintf(layers, sizeof(layers), "%s:%s", is_above ? LAYER_NAME : other,
             is_above ? other : LAYER_NAME);
    snprintf(folders, sizeof(folders), "%s:%s", is_above ? EXPLICIT_FOLDER : folder,
             is_above ? folder : EXPLICIT_FOLDER);
    setenv("VK_INSTANCE_LAYERS", layers, 1);
    setenv("VK_LAYER_PATH", folders, 1);
}

uint32_t count_findings(const struct setup *setup)
{
    static struct fixture fixture;
    assert_null(fixture_open(&fixture, &platform, setup));
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    scene_call(scene);
    assert_int_equal(fixture.instance.messages.count, 0);
    scene->info_count = 0;
    fixture.instance.messages.answer = VK_TRUE;
    scene_call(scene);
    const uint32_t count = fixture.instance.messages.count;
    if (count == 1)
        assert_string_equal(fixture.instance.messages.items[0].id,
                            "VUID-vkCmdBuildAccelerationStructuresKHR-infoCount-arraylength");
    scene_close(scene);
    fixture_close(&fixture);
    return count;
}
