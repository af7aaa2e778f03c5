/* SPDX-License-Identifier: Apache-2.0 */
/* threads_test [null THREADS SECONDS]: builds recorded on some threads while others make and
 * destroy what builds use; run under the thread sanitizer, too. */
#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#include "loader_test.h"
#include "tests/player/scene/placing.h"

enum {
    RECORDERS = 4, /* unless the arguments say otherwise */
    RECORDERS_MAX = 256,
    MAKERS = 2,
    SCENES = 30,   /* that a recorder opens, one after the other, unless it records for a time */
    CALLS = 60,    /* that it makes in each */
    MISTAKES = 20, /* one in so many calls */
    MAKER_OBJECTS = 16,
};

static struct fixture fixture;
static atomic_bool recording;
static unsigned recorder_count = RECORDERS, seconds;
static struct timespec began;
static atomic_uint calls, mistakes;

static bool is_over(int scenes)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return seconds ? now.tv_sec - began.tv_sec >= (time_t)seconds : scenes == SCENES;
}

static void *record(void *context)
{
    const enum build_command command = *(const enum build_command *)context;
    for (int i = 0; !is_over(i); i++) {
        struct scene *scene = scene_open(&fixture, command);
        for (int call = 0; call < CALLS; call++) {
            const uint32_t count = scene->info_count;
            const bool is_mistake = call % MISTAKES == MISTAKES - 1;
            scene->info_count = is_mistake ? 0 : count;
            atomic_fetch_add(&mistakes, is_mistake);
            atomic_fetch_add(&calls, 1);
            scene_call(scene);
            scene->info_count = count;
        }
        scene_close(scene);
    }
    return NULL;
}

/* Buffers come and go, with their addresses and structures in them. */
static void *make(void *context)
{
    while (atomic_load(&recording)) {
        struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
        for (int i = 0; i < MAKER_OBJECTS; i++) {
            const struct device_buffer buffer = scene_buffer(scene, 65536, PLACE_USAGE);
            const VkAccelerationStructureKHR accel = scene_accel_in(
                scene, &buffer, 0, 4096, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
            scene_destroy(scene, (uint64_t)accel);
            scene_destroy(scene, (uint64_t)buffer.handle);
            scene_destroy(scene, (uint64_t)buffer.memory);
        }
        scene_close(scene);
    }
    return NULL;
}

static void *rename_objects(void *context)
{
    struct scene *scene = context;
    STRUCT(VkDebugUtilsObjectNameInfoEXT, info, .objectType = VK_OBJECT_TYPE_BUFFER,
           .objectHandle = (uint64_t)scene->vertices.handle);
    for (unsigned i = 0; atomic_load(&recording); i++) {
        info.pObjectName = i % 2 == 0 ? "vertices of the bunny" : "vertices of the teapot";
        scene->vk->SetDebugUtilsObjectNameEXT(fixture.device, &info);
    }
    return NULL;
}

/* Messengers that come and go while messages go out. */
static void *listen_now_and_then(void *context)
{
    const VkDebugUtilsMessengerCreateInfoEXT create_info = messages_messenger(context);
    while (atomic_load(&recording)) {
        VkDebugUtilsMessengerEXT messenger;
        GET(fixture.instance.vk.CreateDebugUtilsMessengerEXT(fixture.instance.instance,
                                                             &create_info, NULL, &messenger));
        fixture.instance.vk.DestroyDebugUtilsMessengerEXT(fixture.instance.instance, messenger,
                                                          NULL);
    }
    return NULL;
}

static pthread_t start(void *(*run)(void *context), void *context)
{
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, run, context), 0);
    return thread;
}

/* Every message is about a planted mistake, and every planted mistake brought one. */
static void check_messages(void)
{
    const char *const ids[] = {
        "VUID-vkCmdBuildAccelerationStructuresKHR-infoCount-arraylength",
        "VUID-vkCmdBuildAccelerationStructuresIndirectKHR-infoCount-arraylength",
        "VUID-vkBuildAccelerationStructuresKHR-infoCount-arraylength",
    };
    uint32_t expected = 0;
    for (size_t i = 0; i < sizeof(ids) / sizeof(ids[0]); i++)
        expected += messages_count(&fixture.instance.messages, ids[i], NULL);
    assert_true(fixture.instance.messages.count > 0);
    assert_int_equal(fixture.instance.messages.count, atomic_load(&mistakes));
    assert_int_equal(expected, messages_kept(&fixture.instance.messages));
    print_message("%u threads, %u calls, %u mistakes, all of them found\n", recorder_count,
                  atomic_load(&calls), atomic_load(&mistakes));
}

const char *loader_test_open(void)
{
    if (unit_test_arguments[0] && unit_test_arguments[1] && unit_test_arguments[2]) {
        recorder_count = (unsigned)atoi(unit_test_arguments[1]);
        seconds = (unsigned)atoi(unit_test_arguments[2]);
    }
    if (recorder_count > RECORDERS_MAX)
        exit(2);
    return NULL;
}

TEST(test_record_while_objects_come_and_go)
{
    static const enum build_command commands[RECORDERS] = {COMMAND_DEVICE, COMMAND_DEVICE,
                                                           COMMAND_INDIRECT, COMMAND_HOST};
    static const struct setup plain;
    static struct messages of_others;
    pthread_t recorders[RECORDERS_MAX], others[MAKERS + 2];

    assert_null(fixture_open(&fixture, &platform, &plain));
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    clock_gettime(CLOCK_MONOTONIC, &began);
    atomic_store(&recording, true);
    for (int i = 0; i < MAKERS; i++)
        others[i] = start(make, NULL);
    others[MAKERS] = start(rename_objects, scene);
    others[MAKERS + 1] = start(listen_now_and_then, &of_others);
    for (unsigned i = 0; i < recorder_count; i++)
        recorders[i] = start(record, (void *)&commands[i % RECORDERS]);

    for (unsigned i = 0; i < recorder_count; i++)
        pthread_join(recorders[i], NULL);
    atomic_store(&recording, false);
    for (int i = 0; i < MAKERS + 2; i++)
        pthread_join(others[i], NULL);
    scene_close(scene);
    check_messages();
    fixture_close(&fixture);
}
