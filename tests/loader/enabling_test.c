/* SPDX-License-Identifier: Apache-2.0 */
/* The ways in which a user turns the layer on and off, against the installed loader. */
#include "loader_test.h"

static const char *const variables[] = {
    "VK_INSTANCE_LAYERS", "VK_LOADER_LAYERS_ENABLE", "VK_LOADER_LAYERS_DISABLE", "VK_ASSAY_ENABLE",
    "VK_ASSAY_DISABLE",   "VK_LAYER_PATH",           "VK_IMPLICIT_LAYER_PATH",
};

/* No other layer than ours can be found, and ours is off. */
static void clear_environment(void)
{
    for (size_t i = 0; i < LENGTH(variables); i++)
        unsetenv(variables[i]);
    setenv("XDG_DATA_HOME", EMPTY_FOLDER, 1);
    setenv("XDG_DATA_DIRS", EMPTY_FOLDER, 1);
    setenv("XDG_CONFIG_HOME", EMPTY_FOLDER, 1);
    setenv("XDG_CONFIG_DIRS", EMPTY_FOLDER, 1);
}

enum {
    FIND_EXPLICIT = 1, /* the manifests that the loader finds */
    FIND_IMPLICIT = 2,
    NAME_IT = 4,             /* in VkInstanceCreateInfo::ppEnabledLayerNames */
    NEED_LOADER_1_3_234 = 8, /* which knows the first variable */
};

#define BY_LAYERS "VK_INSTANCE_LAYERS=" LAYER_NAME
#define BY_ENABLE "VK_ASSAY_ENABLE=1"
static const struct way {
    const char *test;
    unsigned flags;
    uint32_t findings;
    const char *variables; /* that are set: NAME=VALUE, with a blank between two */
} ways[] = {
    {"test_found_but_not_enabled", FIND_EXPLICIT | FIND_IMPLICIT, 0, ""},
    {"test_named_by_the_instance", FIND_EXPLICIT | NAME_IT, 1, ""},
    {"test_vk_instance_layers", FIND_EXPLICIT, 1, BY_LAYERS},
    /* Twice enabled is loaded once. */
    {"test_vk_instance_layers_and_the_instance", FIND_EXPLICIT | NAME_IT, 1, BY_LAYERS},
    {"test_vk_instance_layers_names_it_twice", FIND_EXPLICIT, 1, BY_LAYERS ":" LAYER_NAME},
    {"test_vk_instance_layers_and_both_manifests", FIND_EXPLICIT | FIND_IMPLICIT | NAME_IT, 1,
     BY_LAYERS " " BY_ENABLE},
    {"test_vk_loader_layers_enable", FIND_EXPLICIT | NEED_LOADER_1_3_234, 1,
     "VK_LOADER_LAYERS_ENABLE=" LAYER_NAME},
    {"test_vk_loader_layers_enable_by_pattern", FIND_EXPLICIT | NEED_LOADER_1_3_234, 1,
     "VK_LOADER_LAYERS_ENABLE=*assay*"},
    {"test_implicit_enabled", FIND_IMPLICIT, 1, BY_ENABLE},
    {"test_implicit_not_enabled_by_another_value", FIND_IMPLICIT, 0, "VK_ASSAY_ENABLE=0"},
    /* The loader compares the value with the manifest's. */
    {"test_implicit_not_enabled_by_true", FIND_IMPLICIT, 0, "VK_ASSAY_ENABLE=true"},
    {"test_implicit_disable_wins", FIND_IMPLICIT, 0, BY_ENABLE " VK_ASSAY_DISABLE=1"},
    {"test_implicit_disabled_by_the_loader", FIND_IMPLICIT | NEED_LOADER_1_3_234, 0,
     "VK_LOADER_LAYERS_DISABLE=~implicit~ " BY_ENABLE},
    /* Both manifests are found, and both ways of enabling used. */
    {"test_explicit_and_implicit", FIND_EXPLICIT | FIND_IMPLICIT, 1, BY_LAYERS " " BY_ENABLE},
};

static uint32_t loader_version(void)
{
    const PFN_vkEnumerateInstanceVersion enumerate = GLOBAL(EnumerateInstanceVersion);
    uint32_t installed = VK_API_VERSION_1_0;
    if (enumerate != NULL)
        enumerate(&installed);
    return installed;
}

TEST_OF_ROWS(test_way, ways, const struct way *way, clear_environment)
{
    const struct setup setup = {.by_environment = !(way->flags & NAME_IT)};
    char name[64], value[128];
    int length;
    if (way->flags & NEED_LOADER_1_3_234 && loader_version() < VK_MAKE_API_VERSION(0, 1, 3, 234)) {
        print_message("the loader is too old for %s\n", way->variables);
        skip();
    }
    if (way->flags & FIND_EXPLICIT)
        setenv("VK_LAYER_PATH", EXPLICIT_FOLDER, 1);
    if (way->flags & FIND_IMPLICIT) {
        setenv("XDG_DATA_HOME", DATA_HOME, 1);
        setenv("VK_IMPLICIT_LAYER_PATH", IMPLICIT_FOLDER, 1);
    }
    for (const char *at = way->variables; sscanf(at, " %63[^=]=%127s%n", name, value, &length) == 2;
         at += length)
        setenv(name, value, 1);
    assert_int_equal(count_findings(&setup), way->findings);
}

/* ---- VK_EXT_layer_settings of the implicit layer */

static bool is_listed(const char *extension)
{
    static VkExtensionProperties list[128];
    uint32_t count = LENGTH(list);
    GET(GLOBAL(EnumerateInstanceExtensionProperties)(NULL, &count, list));
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(list[i].extensionName, extension) == 0)
            return true;
    return false;
}

/* What is listed can be enabled. Loaders before 1.3.272 can't enable it. */
TEST_OPENED(test_implicit_layer_settings, clear_environment)
{
    const char *extension = VK_EXT_LAYER_SETTINGS_EXTENSION_NAME;
    const STRUCT(VkInstanceCreateInfo, create_info, .enabledExtensionCount = 1,
                 .ppEnabledExtensionNames = &extension);
    setenv("XDG_DATA_HOME", DATA_HOME, 1);
    setenv("VK_IMPLICIT_LAYER_PATH", IMPLICIT_FOLDER, 1);
    setenv("VK_ASSAY_ENABLE", "1", 1);
    assert_int_equal(is_listed(extension), loader_version() >= VK_MAKE_API_VERSION(0, 1, 3, 272));
    if (!is_listed(extension))
        return;
    VkInstance instance;
    assert_int_equal(GLOBAL(CreateInstance)(&create_info, NULL, &instance), VK_SUCCESS);
    COMMAND_OF(instance, DestroyInstance)(instance, NULL);
}
