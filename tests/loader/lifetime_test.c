/* SPDX-License-Identifier: Apache-2.0 */
/* Several instances and devices at once; unloading and loading again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene.h"

enum { INSTANCES = 4, ROUNDS = 100 };

static struct platform platform;
static struct world worlds[INSTANCES];
static const struct setup plain;

static void open_world(struct world *world)
{
    assert_null(world_open(world, &platform, &plain));
}

/* One valid call and one with a mistake; only this world's messenger may hear of the latter. */
static void use_world(struct world *world)
{
    uint32_t heard[INSTANCES];
    struct scene *scene = scene_open(world, COMMAND_DEVICE);

    for (int i = 0; i < INSTANCES; i++)
        heard[i] = worlds[i].messages.count;
    scene_call(scene);
    assert_int_equal(world->messages.count, heard[world - worlds]);
    scene->info_count = 0;
    world->messages.answer = VK_TRUE;
    scene_call(scene);
    world->messages.answer = VK_FALSE;
    for (int i = 0; i < INSTANCES; i++)
        assert_int_equal(worlds[i].messages.count, heard[i] + (i == world - worlds ? 1u : 0u));
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

static void test_several_instances(void **state)
{
    (void)state;
    for (int i = 0; i < INSTANCES; i++)
        open_world(&worlds[i]);
    for (int i = 0; i < INSTANCES; i++)
        use_world(&worlds[i]);
    world_close(&worlds[1]);
    use_world(&worlds[0]);
    use_world(&worlds[3]);
    open_world(&worlds[1]);
    for (int i = INSTANCES; i-- > 0;)
        use_world(&worlds[i]);
    for (int i = 0; i < INSTANCES; i++)
        world_close(&worlds[i]);
}

/* A device's structures are its own: those of a second device, made and destroyed meanwhile, leave
 * the first one's as they are. */
static void test_several_devices(void **state)
{
    (void)state;
    struct world *world = &worlds[0];
    open_world(world);
    struct scene *first = scene_open(world, COMMAND_DEVICE);

    const VkDevice device = world->device;
    const VkuDeviceDispatchTable vk = world->vk;
    world->device = world_create_device(world);
    vkuInitDeviceDispatchTable(world->device, &world->vk, world->get_device_proc_addr);
    struct scene *second = scene_open(world, COMMAND_DEVICE);
    scene_call(second);
    scene_close(second);
    world->vk.DestroyDevice(world->device, NULL);
    world->device = device;
    world->vk = vk;

    scene_call(first);
    assert_int_equal(world->messages.count, 0);
    scene_close(first);
    world_close(world);
}

static void test_unload_and_load_again(void **state)
{
    (void)state;
    assert_false(layer_is_loaded());
    for (int round = 0; round < ROUNDS; round++) {
        open_world(&worlds[0]);
        assert_true(layer_is_loaded());
        use_world(&worlds[0]);
        world_close(&worlds[0]);
        assert_false(layer_is_loaded());
    }
}

/* Destroying an instance whose device lives on in another one. */
static void test_interleaved_loading(void **state)
{
    (void)state;
    for (int round = 0; round < ROUNDS / 10; round++) {
        open_world(&worlds[0]);
        open_world(&worlds[1]);
        world_close(&worlds[0]);
        use_world(&worlds[1]);
        assert_true(layer_is_loaded());
        world_close(&worlds[1]);
        assert_false(layer_is_loaded());
    }
}

/* The layer stays loaded after a warning about a setting, so that the next instance brings none. */
static void test_one_warning_of_a_setting(void **state)
{
    (void)state;
    setenv("VK_ASSAY_VALIDATION_VUID_NAMES", "bogus", 1);
    for (int round = 0; round < 3; round++) {
        assert_null(world_open(&worlds[0], &platform, &plain));
        assert_int_equal(worlds[0].messages.count, round == 0);
        world_close(&worlds[0]);
    }
    setenv("VK_ASSAY_VALIDATION_VUID_NAMES", "another", 1);
    assert_null(world_open(&worlds[0], &platform, &plain));
    assert_int_equal(worlds[0].messages.count, 1);
    world_close(&worlds[0]);
    unsetenv("VK_ASSAY_VALIDATION_VUID_NAMES");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_several_instances),
        cmocka_unit_test(test_several_devices),
        cmocka_unit_test(test_unload_and_load_again),
        cmocka_unit_test(test_interleaved_loading),
        /* Last: the layer stays loaded. */
        cmocka_unit_test(test_one_warning_of_a_setting),
    };
    const char *missing = platform_open(&platform, "null");
    if (missing != NULL) {
        print_error("%s\n", missing);
        return 1;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
