/* SPDX-License-Identifier: Apache-2.0 */
/* khronos_test null|lavapipe: the layer above and below the Khronos validation layer. */
#include "loader_test.h"

#define KHRONOS_NAME "VK_LAYER_KHRONOS_validation"
#define PRIMITIVE_COUNT_ID "VUID-vkCmdBuildAccelerationStructuresKHR-primitiveCount-03769"
#define STRIDE_ID "VUID-VkAccelerationStructureGeometryTrianglesDataKHR-vertexStride-03735"
#define OWN_STRIDE_TEXT "pBuildInfo->pGeometries[0].geometry.triangles.vertexStride"
#define INFO_COUNT_ID "VUID-vkCmdBuildAccelerationStructuresKHR-infoCount-arraylength"

static struct fixture fixture;

const char *loader_test_open(void)
{
    return layer_is_installed(KHRONOS_NAME, SYSTEM_FOLDER) ? NULL
                                                           : KHRONOS_NAME " is not installed";
}

static void open_fixture(bool is_above)
{
    static const struct setup by_environment = {.by_environment = true};
    enable_beside(KHRONOS_NAME, SYSTEM_FOLDER, is_above);
    const char *missing = fixture_open(&fixture, &platform, &by_environment);
    unsetenv("VK_INSTANCE_LAYERS");
    if (missing)
        fail_msg("%s", missing);
    messages_clear(&fixture.instance.messages);
}

/* Khronos layers of 2023 wrongly require a feature of ray tracing to ask for sizes. */
static uint32_t count_messages(void)
{
    return fixture.instance.messages.count -
           messages_count(&fixture.instance.messages,
                          "VUID-vkGetAccelerationStructureBuildSizesKHR-rayTracingPipeline-03617",
                          NULL);
}

static void expect_silence(void)
{
    if (count_messages() != 0)
        for (uint32_t i = 0; i < messages_kept(&fixture.instance.messages); i++)
            print_error("%s: %s\n", fixture.instance.messages.items[i].id,
                        fixture.instance.messages.items[i].text);
    assert_int_equal(count_messages(), 0);
}

/* All messages have this id. One is of this layer, which alone has this text; the Khronos layer may
 * say the same more than once. */
static void expect_messages(const char *id, const char *own_text, bool both_know)
{
    const uint32_t count = messages_count(&fixture.instance.messages, id, NULL);
    assert_int_equal(count_messages(), count);
    assert_int_equal(messages_count(&fixture.instance.messages, id, own_text), 1);
    if (both_know)
        assert_true(count > 1);
    else
        assert_int_equal(count, 1);
    messages_clear(&fixture.instance.messages);
}

/* Messages with this id, or none, none of them of this layer. Some versions of the Khronos layer
 * compare an update with the last build that was recorded. */
static void expect_messages_of_khronos(const char *id, const char *own_text)
{
    assert_int_equal(count_messages(), messages_count(&fixture.instance.messages, id, NULL));
    assert_int_equal(messages_count(&fixture.instance.messages, id, own_text), 0);
    messages_clear(&fixture.instance.messages);
}

static void record_anew(struct scene *scene)
{
    scene_record_in_family(scene, fixture_find_family(&fixture, VK_QUEUE_COMPUTE_BIT, 0), 0);
}

/* The call is made: the messenger does not ask to skip it. So both layers get it. */
static void make_mistake_that_both_know(struct scene *scene)
{
    const uint32_t count = scene->info_count;
    record_anew(scene);
    scene->info_count = 0;
    scene_call(scene);
    scene->info_count = count;
}

/* An update of two triangles' structure with one triangle, in a command buffer of its own: what it
 * was built with is known when it is submitted. */
static void make_mistake_of_update(struct scene *scene)
{
    scene->ranges[REFIT][0].primitiveCount--;
    record_anew(scene);
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &scene->infos[REFIT],
                                                 &scene->ranges_argument[REFIT]);
}

/* A query that is repeated may be one of the Khronos layer for the same build. */
static void ask_for_wrong_sizes(const struct scene *scene)
{
    VkAccelerationStructureGeometryKHR geometry = scene->geometries[INDEXED][0];
    VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[INDEXED];
    const uint32_t counts[] = {1};
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    geometry.geometry.triangles.vertexStride++;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    info.ppGeometries = NULL;
    for (int i = 0; i < 3; i++)
        scene->vk->GetAccelerationStructureBuildSizesKHR(
            fixture.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, counts, &sizes);
}

static void validate(bool is_above)
{
    open_fixture(is_above);
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    scene_call(scene);
    assert_int_equal(scene_submit_call(scene), VK_SUCCESS);
    expect_silence();

    make_mistake_that_both_know(scene);
    expect_messages(INFO_COUNT_ID, "infoCount is 0", true);

    make_mistake_of_update(scene);
    expect_messages_of_khronos(PRIMITIVE_COUNT_ID, "as submitted to");
    fixture.instance.messages.answer = VK_TRUE;
    assert_int_equal(scene_submit_call(scene), VK_ERROR_VALIDATION_FAILED_EXT);
    expect_messages(PRIMITIVE_COUNT_ID, "as submitted to", false);
    fixture.instance.messages.answer = VK_FALSE;

    ask_for_wrong_sizes(scene);
    assert_int_equal(messages_count(&fixture.instance.messages, STRIDE_ID, OWN_STRIDE_TEXT),
                     is_above ? 3 : 1);
    messages_clear(&fixture.instance.messages);

    scene_close(scene);
    expect_silence();
    fixture_close(&fixture);
}

TEST(test_above_the_khronos_layer)
{
    validate(true);
}

TEST(test_below_the_khronos_layer)
{
    validate(false);
}
