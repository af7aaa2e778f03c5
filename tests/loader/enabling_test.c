/* SPDX-License-Identifier: Apache-2.0 */
/* The ways in which a user turns the layer on and off, against the installed loader. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene.h"

static struct platform platform;

static const char *const variables[] = {
    "VK_INSTANCE_LAYERS", "VK_LOADER_LAYERS_ENABLE", "VK_LOADER_LAYERS_DISABLE", "VK_ASSAY_ENABLE",
    "VK_ASSAY_DISABLE",   "VK_LAYER_PATH",           "VK_IMPLICIT_LAYER_PATH",
};

/* No other layer than ours can be found, and ours is off. */
static int clear_environment(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof(variables) / sizeof(variables[0]); i++)
        unsetenv(variables[i]);
    setenv("XDG_DATA_HOME", EMPTY_FOLDER, 1);
    setenv("XDG_DATA_DIRS", EMPTY_FOLDER, 1);
    setenv("XDG_CONFIG_HOME", EMPTY_FOLDER, 1);
    setenv("XDG_CONFIG_DIRS", EMPTY_FOLDER, 1);
    return 0;
}

static void find_explicit(void)
{
    setenv("VK_LAYER_PATH", EXPLICIT_FOLDER, 1);
}

static void find_implicit(void)
{
    setenv("XDG_DATA_HOME", DATA_HOME, 1);
    setenv("VK_IMPLICIT_LAYER_PATH", IMPLICIT_FOLDER, 1);
}

/* How many messages a call with one mistake brings. */
static uint32_t count_findings(bool named_by_the_instance)
{
    static struct fixture fixture;
    const struct setup setup = {.by_environment = !named_by_the_instance};

    assert_null(fixture_open(&fixture, &platform, &setup));
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    assert_int_equal(fixture.messages.count, 0);
    scene->info_count = 0;
    fixture.messages.answer = VK_TRUE;
    scene_call(scene);
    const uint32_t count = fixture.messages.count;
    if (count == 1)
        assert_string_equal(fixture.messages.items[0].id,
                            "VUID-vkCmdBuildAccelerationStructuresKHR-infoCount-arraylength");
    scene_close(scene);
    fixture_close(&fixture);
    return count;
}

static void need_loader(uint32_t version, const char *what)
{
    const PFN_vkEnumerateInstanceVersion enumerate =
        (PFN_vkEnumerateInstanceVersion)platform.get_instance_proc_addr(
            NULL, "vkEnumerateInstanceVersion");
    uint32_t installed = VK_API_VERSION_1_0;
    if (enumerate != NULL)
        enumerate(&installed);
    if (installed < version) {
        print_message("the loader is too old for %s\n", what);
        skip();
    }
}

static void test_found_but_not_enabled(void **state)
{
    (void)state;
    find_explicit();
    find_implicit();
    assert_int_equal(count_findings(false), 0);
}

static void test_named_by_the_instance(void **state)
{
    (void)state;
    find_explicit();
    assert_int_equal(count_findings(true), 1);
}

static void test_vk_instance_layers(void **state)
{
    (void)state;
    find_explicit();
    setenv("VK_INSTANCE_LAYERS", LAYER_NAME, 1);
    assert_int_equal(count_findings(false), 1);
}

/* Twice enabled is loaded once. */
static void test_vk_instance_layers_and_the_instance(void **state)
{
    (void)state;
    find_explicit();
    setenv("VK_INSTANCE_LAYERS", LAYER_NAME, 1);
    assert_int_equal(count_findings(true), 1);
}

static void test_vk_loader_layers_enable(void **state)
{
    (void)state;
    need_loader(VK_MAKE_API_VERSION(0, 1, 3, 234), "VK_LOADER_LAYERS_ENABLE");
    find_explicit();
    setenv("VK_LOADER_LAYERS_ENABLE", LAYER_NAME, 1);
    assert_int_equal(count_findings(false), 1);
}

static void test_vk_loader_layers_enable_by_pattern(void **state)
{
    (void)state;
    need_loader(VK_MAKE_API_VERSION(0, 1, 3, 234), "VK_LOADER_LAYERS_ENABLE");
    find_explicit();
    setenv("VK_LOADER_LAYERS_ENABLE", "*assay*", 1);
    assert_int_equal(count_findings(false), 1);
}

static void test_implicit_enabled(void **state)
{
    (void)state;
    find_implicit();
    setenv("VK_ASSAY_ENABLE", "1", 1);
    assert_int_equal(count_findings(false), 1);
}

static void test_implicit_not_enabled_by_another_value(void **state)
{
    (void)state;
    find_implicit();
    setenv("VK_ASSAY_ENABLE", "0", 1);
    assert_int_equal(count_findings(false), 0);
}

static void test_implicit_disable_wins(void **state)
{
    (void)state;
    find_implicit();
    setenv("VK_ASSAY_ENABLE", "1", 1);
    setenv("VK_ASSAY_DISABLE", "1", 1);
    assert_int_equal(count_findings(false), 0);
}

static void test_implicit_disabled_by_the_loader(void **state)
{
    (void)state;
    need_loader(VK_MAKE_API_VERSION(0, 1, 3, 234), "VK_LOADER_LAYERS_DISABLE");
    find_implicit();
    setenv("VK_ASSAY_ENABLE", "1", 1);
    setenv("VK_LOADER_LAYERS_DISABLE", "~implicit~", 1);
    assert_int_equal(count_findings(false), 0);
}

/* Both manifests are found, and both ways of enabling used. */
static void test_explicit_and_implicit(void **state)
{
    (void)state;
    find_explicit();
    find_implicit();
    setenv("VK_INSTANCE_LAYERS", LAYER_NAME, 1);
    setenv("VK_ASSAY_ENABLE", "1", 1);
    assert_int_equal(count_findings(false), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_found_but_not_enabled, clear_environment),
        cmocka_unit_test_setup(test_named_by_the_instance, clear_environment),
        cmocka_unit_test_setup(test_vk_instance_layers, clear_environment),
        cmocka_unit_test_setup(test_vk_instance_layers_and_the_instance, clear_environment),
        cmocka_unit_test_setup(test_vk_loader_layers_enable, clear_environment),
        cmocka_unit_test_setup(test_vk_loader_layers_enable_by_pattern, clear_environment),
        cmocka_unit_test_setup(test_implicit_enabled, clear_environment),
        cmocka_unit_test_setup(test_implicit_not_enabled_by_another_value, clear_environment),
        cmocka_unit_test_setup(test_implicit_disable_wins, clear_environment),
        cmocka_unit_test_setup(test_implicit_disabled_by_the_loader, clear_environment),
        cmocka_unit_test_setup(test_explicit_and_implicit, clear_environment),
    };
    const char *missing = platform_open(&platform, "null");
    if (missing != NULL) {
        print_error("%s\n", missing);
        return 1;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
