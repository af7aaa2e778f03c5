/* SPDX-License-Identifier: Apache-2.0 */
/* Debug callbacks that call Vulkan: the layer holds no lock while one runs. */
#include "tests/loader/loader_test.h"
#include "tests/rules/placing.h"

struct callback {
    void (*deed)(void);
    unsigned depth, count, in_deed;
};

static struct callback callback;
static struct fixture fixture;
static struct scene *scene;
static VkDebugUtilsMessengerEXT messenger;

MESSENGER_CALLBACK(hear)
{
    if (callback.depth++ == 0) {
        if (callback.count++ == 0)
            callback.deed();
    } else {
        callback.in_deed++;
    }
    callback.depth--;
    return VK_FALSE;
}

static void open_scene(void)
{
    static const struct setup plain;
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, info,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                 .pfnUserCallback = hear);
    callback = (struct callback){0};
    assert_null(fixture_open(&fixture, &platform, &plain));
    scene = scene_open(&fixture, COMMAND_DEVICE);
    expect_success(
        fixture.vki.CreateDebugUtilsMessengerEXT(fixture.instance, &info, NULL, &messenger),
        "vkCreateDebugUtilsMessengerEXT");
}

static void close_scene(void)
{
    fixture.vki.DestroyDebugUtilsMessengerEXT(fixture.instance, messenger, NULL);
    scene_close(scene);
    fixture_close(&fixture);
}

static void make_mistake(void)
{
    const uint32_t count = scene->info_count;
    scene->info_count = 0;
    scene_call(scene);
    scene->info_count = count;
}

/* An update of what was never built: found when it is submitted. */
static void submit_mistake(void)
{
    scene_record_in_family(scene, fixture_find_family(&fixture, VK_QUEUE_COMPUTE_BIT, 0), 0);
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &scene->infos[REFIT],
                                                 &scene->ranges_argument[REFIT]);
    assert_int_equal(callback.count, 0);
    assert_int_equal(scene_submit_call(scene), VK_SUCCESS);
}

static void destroy_messenger(void)
{
    fixture.vki.DestroyDebugUtilsMessengerEXT(fixture.instance, messenger, NULL);
    messenger = VK_NULL_HANDLE;
}

static void record_with_mistakes(void)
{
    for (int i = 0; i < 3; i++)
        make_mistake();
}

static void create_and_destroy(void)
{
    const struct test_buffer buffer = scene_buffer(scene, 65536, PLACE_USAGE);
    const VkAccelerationStructureKHR accel =
        scene_accel_in(scene, &buffer, 0, 4096, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    scene_destroy(scene, (uint64_t)accel);
    scene_destroy(scene, (uint64_t)buffer.handle);
    scene_destroy(scene, (uint64_t)buffer.memory);
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, name, .objectType = VK_OBJECT_TYPE_COMMAND_BUFFER,
                 .objectHandle = (uint64_t)(uintptr_t)scene->command_buffer,
                 .pObjectName = "named in a callback");
    scene->vk->SetDebugUtilsObjectNameEXT(fixture.device, &name);
}

/* Another submission, which completes, and then the structure that it has built goes. The layer is
 * still in the submission that the message is about, and looks at this one only later. */
static void submit_and_destroy(void)
{
    struct scene *other = scene_open(&fixture, COMMAND_DEVICE);
    const uint32_t family =
        fixture_find_family(&fixture, VK_QUEUE_COMPUTE_BIT, VK_QUEUE_GRAPHICS_BIT);
    scene_record_in_family(other, family, 0);
    other->vk->CmdBuildAccelerationStructuresKHR(other->command_buffer, 1, &other->infos[INDEXED],
                                                 &other->ranges_argument[INDEXED]);
    scene_end(other, other->command_buffer);
    scene_submit(other, family, other->command_buffer);
    scene_close(other);
}

static void create_instance(void)
{
    static struct fixture other;
    static const struct setup plain;
    assert_null(fixture_open(&other, &platform, &plain));
    fixture_close(&other);
}

/* ---- tests: a deed, in a callback of a call and of a submission */

static const struct row {
    const char *test;
    void (*deed)(void);
    void (*mistakes[2])(void); /* each makes a message, of which the first calls the deed */
    unsigned in_deed;          /* messages while the deed is done */
} rows[] = {
    {"test_callback_records", record_with_mistakes, {make_mistake}, 3},
    {"test_callback_creates_and_destroys_objects",
     create_and_destroy,
     {make_mistake, submit_mistake},
     0},
    {"test_callback_submits_and_destroys", submit_and_destroy, {submit_mistake}, 0},
    {"test_callback_creates_an_instance", create_instance, {make_mistake, submit_mistake}, 0},
};

TEST_OF_ROWS_BETWEEN(test_deeds, rows, const struct row *row, open_scene, close_scene)
{
    callback.deed = row->deed;
    for (int i = 0; i < 2 && row->mistakes[i]; i++) {
        callback.count = 0;
        row->mistakes[i]();
        assert_int_equal(callback.count, 1);
        assert_int_equal(callback.in_deed, row->in_deed);
    }
}

TEST_BETWEEN(test_callback_destroys_its_messenger, open_scene, close_scene)
{
    callback.deed = destroy_messenger;
    make_mistake();
    make_mistake();
    assert_int_equal(callback.count, 1);
    assert_int_equal(callback.in_deed, 0);
}
