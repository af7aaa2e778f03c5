/* SPDX-License-Identifier: Apache-2.0 */
/* Several instances and devices at once; unloading and loading again. */
#include "loader_test.h"

#include <dlfcn.h>

/* A sanitizer tells of the first leak. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { INSTANCES = 4, ROUNDS = 10 };
#else
enum { INSTANCES = 4, ROUNDS = 100 };
#endif

static struct fixture fixtures[INSTANCES];
static const struct setup plain;

static void open_fixture(struct fixture *fixture)
{
    assert_null(fixture_open(fixture, &platform, &plain));
}

/* One valid call and one with a mistake; only this world's messenger may hear of the latter. */
static void use_fixture(struct fixture *fixture)
{
    uint32_t heard[INSTANCES];
    struct scene *scene = scene_open(fixture, COMMAND_DEVICE);

    for (int i = 0; i < INSTANCES; i++)
        heard[i] = fixtures[i].instance.messages.count;
    scene_call(scene);
    assert_int_equal(fixture->instance.messages.count, heard[fixture - fixtures]);
    scene->info_count = 0;
    fixture->instance.messages.answer = VK_TRUE;
    scene_call(scene);
    fixture->instance.messages.answer = VK_FALSE;
    for (int i = 0; i < INSTANCES; i++)
        assert_int_equal(fixtures[i].instance.messages.count,
                         heard[i] + (i == fixture - fixtures ? 1u : 0u));
    scene_close(scene);
}

/* Whether the layer's library is mapped. */
static bool layer_is_loaded(void)
{
    FILE *maps = fopen("/proc/self/maps", "r");
    char line[4096];
    bool found = false;

    assert_non_null(maps);
    while (fgets(line, sizeof(line), maps) != NULL)
        found = found || strstr(line, "libVkLayer_assay") != NULL;
    fclose(maps);
    return found;
}

/* Only instances load the layer here. */
const char *loader_test_open(void)
{
    dlclose(platform.layer);
    return NULL;
}

TEST(test_several_instances)
{
    for (int i = 0; i < INSTANCES; i++)
        open_fixture(&fixtures[i]);
    for (int i = 0; i < INSTANCES; i++)
        use_fixture(&fixtures[i]);
    fixture_close(&fixtures[1]);
    use_fixture(&fixtures[0]);
    use_fixture(&fixtures[3]);
    open_fixture(&fixtures[1]);
    for (int i = INSTANCES; i-- > 0;)
        use_fixture(&fixtures[i]);
    for (int i = 0; i < INSTANCES; i++)
        fixture_close(&fixtures[i]);
}

/* A device's structures are its own: those of a second device, made and destroyed meanwhile, leave
 * the first one's as they are. */
TEST(test_several_devices)
{
    struct fixture *fixture = &fixtures[0];
    open_fixture(fixture);
    struct scene *first = scene_open(fixture, COMMAND_DEVICE);

    const VkDevice device = fixture->device;
    const VkuDeviceDispatchTable vk = fixture->vk;
    fixture->device = fixture_create_device(fixture);
    vkuInitDeviceDispatchTable(fixture->device, &fixture->vk,
                               fixture->instance.get_device_proc_addr);
    struct scene *second = scene_open(fixture, COMMAND_DEVICE);
    scene_call(second);
    scene_close(second);
    fixture->vk.DestroyDevice(fixture->device, NULL);
    fixture->device = device;
    fixture->vk = vk;

    scene_call(first);
    assert_int_equal(fixture->instance.messages.count, 0);
    scene_close(first);
    fixture_close(fixture);
}

TEST(test_unload_and_load_again)
{
    assert_false(layer_is_loaded());
    for (int round = 0; round < ROUNDS; round++) {
        open_fixture(&fixtures[0]);
        assert_true(layer_is_loaded());
        use_fixture(&fixtures[0]);
        fixture_close(&fixtures[0]);
        assert_false(layer_is_loaded());
    }
}

/* Destroying an instance whose device lives on in another one. */
TEST(test_interleaved_loading)
{
    for (int round = 0; round < ROUNDS / 10; round++) {
        open_fixture(&fixtures[0]);
        open_fixture(&fixtures[1]);
        fixture_close(&fixtures[0]);
        use_fixture(&fixtures[1]);
        assert_true(layer_is_loaded());
        fixture_close(&fixtures[1]);
        assert_false(layer_is_loaded());
    }
}

/* The layer stays loaded after a warning about a setting, so that the next instance brings none.
 * For the same reason this test is the last one. */
TEST(test_one_warning_of_a_setting)
{
    setenv("VK_ASSAY_VALIDATION_VUID_NAMES", "bogus", 1);
    for (int round = 0; round < 3; round++) {
        assert_null(fixture_open(&fixtures[0], &platform, &plain));
        assert_int_equal(fixtures[0].instance.messages.count, round == 0);
        fixture_close(&fixtures[0]);
    }
    setenv("VK_ASSAY_VALIDATION_VUID_NAMES", "another", 1);
    assert_null(fixture_open(&fixtures[0], &platform, &plain));
    assert_int_equal(fixtures[0].instance.messages.count, 1);
    fixture_close(&fixtures[0]);
    unsetenv("VK_ASSAY_VALIDATION_VUID_NAMES");
}
