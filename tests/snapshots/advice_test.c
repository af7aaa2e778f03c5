/* SPDX-License-Identifier: Apache-2.0 */
/* Setting advice beside inputs of real size: a terrain, a soup of triangles, a figure that moves
 * for 200 frames, 10,000 instances. Each is valid, and has a neighbour that deserves advice. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/snapshots/scene.h"

#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

enum {
    SIDE = 250,
    TRIANGLES = 2 * SIDE * SIDE,
    INSTANCES = 10000,
    FRAMES = 200,
    INPUT_SIZE = TRIANGLES * 9 * sizeof(float)
};

static struct device_buffer indices;
static const char *advice_at_end; /* the text of the only message of the list; NULL: it is empty */

static void open_with(const char *limits)
{
    advice_at_end = NULL;
    struct null_driver_config config = platform.null_driver.default_config();
    config.as_properties.maxInstanceCount = INSTANCES;
    platform.null_driver.configure(&config);
    setenv("VK_ASSAY_VALIDATION_ADVICE", "true", 1);
    setenv("VK_ASSAY_VALIDATION_ADVICE_LIMITS", limits, 1);
    SCENE_OPEN(.boxes_size = INPUT_SIZE, .structure_size = 1 << 26, .has_tlas = true);
    indices = scene_input(TRIANGLES * sizeof(uint32_t[3]));
}

/* No structure is kept so long, and the thread that compares trees pauses for long. */
static void open_scene(void)
{
    open_with("submissions=1000,refit_percent=1");
}

/* The structures are destroyed before the device. */
static void destroy_scene(void)
{
    scene_close();
    unsetenv("VK_ASSAY_VALIDATION_ADVICE");
    unsetenv("VK_ASSAY_VALIDATION_ADVICE_LIMITS");
    platform.null_driver.configure(NULL);
}

static void close_scene(void)
{
    destroy_scene();
    expect_messages(advice_at_end ? 1 : 0, advice_at_end);
}

#define ADVICE_TEST(name) TEST_BETWEEN_IF(name, open_scene, close_scene, true)

static float (*vertices(void))[3]
{
    return (float(*)[3])(void *)scene.boxes.bytes;
}

/* ---- meshes */

static void write_terrain(float x)
{
    uint32_t(*triangles)[3] = (uint32_t(*)[3])(void *)indices.bytes;
    for (uint32_t i = 0; i < (SIDE + 1) * (SIDE + 1); i++) {
        float *vertex = vertices()[i];
        vertex[0] = (float)(i % (SIDE + 1));
        vertex[1] = (float)(i / (SIDE + 1));
        vertex[2] = 4 * sinf(vertex[0] / 9) * cosf(vertex[1] / 7);
        vertex[0] += x;
    }
    for (uint32_t i = 0; i < TRIANGLES; i++) {
        const uint32_t first = i / 2 / SIDE * (SIDE + 1) + i / 2 % SIDE, odd = i % 2;
        triangles[i][0] = first + odd;
        triangles[i][1] = first + (odd ? SIDE + 2 : 1);
        triangles[i][2] = first + SIDE + 1;
    }
}

static void run_build(const struct fixture_build *build)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build(&fixture, commands, build);
    fixture_barrier(&fixture, commands);
    fixture_finish(&fixture, commands);
}

static void build_mesh(bool has_indices, uint32_t count, VkBuildAccelerationStructureFlagsKHR flags,
                       bool is_update)
{
    const struct fixture_build build = {
        .geometry = triangles_geometry(scene.boxes.address,
                                       has_indices ? (SIDE + 1) * (SIDE + 1) - 1 : 3 * count - 1,
                                       has_indices ? VK_INDEX_TYPE_UINT32 : VK_INDEX_TYPE_NONE_KHR,
                                       has_indices ? indices.address : 0),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = flags,
                 .mode = is_update ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                   : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                 .srcAccelerationStructure = is_update ? scene.blas : VK_NULL_HANDLE,
                 .dstAccelerationStructure = scene.blas,
                 .scratchData.deviceAddress = scene.scratch_address},
        .range.primitiveCount = count,
    };
    run_build(&build);
}

ADVICE_TEST(test_terrain)
{
    write_terrain(0);
    build_mesh(true, TRIANGLES, 0, false);
    fixture_expect_silence(&fixture);
}

ADVICE_TEST(test_terrain_far_from_the_origin)
{
    write_terrain(1e6F);
    build_mesh(true, TRIANGLES, 0, false);
    expect_messages(1, "That is too coarse for 125000 triangles");
}

static float next_number(void)
{
    static uint32_t state = 1;
    state = state * 1664525 + 1013904223;
    return (float)(state >> 8) / (float)(1 << 24);
}

static void write_soup(uint32_t count)
{
    for (uint32_t i = 0; i < 3 * count; i++)
        for (int j = 0; j < 3; j++)
            vertices()[i][j] =
                i % 3 ? vertices()[i - i % 3][j] + next_number() / 50 : next_number();
}

ADVICE_TEST(test_soup)
{
    write_soup(TRIANGLES);
    build_mesh(false, TRIANGLES, 0, false);
    fixture_expect_silence(&fixture);
}

ADVICE_TEST(test_soup_with_a_stray_vertex)
{
    write_soup(TRIANGLES);
    vertices()[4711][1] = 1e9F;
    build_mesh(false, TRIANGLES, 0, false);
    expect_messages(1, "whose extent is 1e+09 with one vertex");
}

/* ---- figures that move */

enum { FIGURE = 5000 };

/* A column that bends more and more. */
static void bend(uint32_t frame, const float (*rest)[3])
{
    for (uint32_t i = 0; i < 3 * FIGURE; i++) {
        const float angle = sinf((float)frame / 20) * rest[i][2];
        vertices()[i][0] = cosf(angle) * rest[i][0] + sinf(angle) * rest[i][2];
        vertices()[i][1] = rest[i][1];
        vertices()[i][2] = cosf(angle) * rest[i][2] - sinf(angle) * rest[i][0];
    }
}

/* Each triangle goes its own way. */
static void scatter(const float (*away)[3])
{
    for (uint32_t i = 0; i < 3 * FIGURE; i++)
        for (int j = 0; j < 3; j++)
            vertices()[i][j] += away[i / 3][j] / 20;
}

static void write_ways(float (*away)[3])
{
    for (uint32_t i = 0; i < FIGURE; i++)
        for (int j = 0; j < 3; j++)
            away[i][j] = next_number() - 0.5F;
}

ADVICE_TEST(test_figure_that_bends)
{
    static float rest[3 * FIGURE][3];
    write_soup(FIGURE);
    memcpy(rest, vertices(), sizeof(rest));
    for (uint32_t i = 0; i < FRAMES; i++) {
        bend(i, (const float(*)[3])rest);
        build_mesh(false, FIGURE, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR, i > 0);
    }
    fixture_expect_silence(&fixture);
}

/* 200 updates, of which the 64th is judged. */
ADVICE_TEST(test_figure_that_scatters)
{
    static float away[FIGURE][3];
    write_soup(FIGURE);
    write_ways(away);
    for (uint32_t i = 0; i < FRAMES; i++) {
        scatter((const float(*)[3])away);
        build_mesh(false, FIGURE, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR, i > 0);
    }
    fixture_expect_silence(&fixture);
    advice_at_end = "have moved so far since the last build";
}

#ifndef _WIN32
/* The loader unloads the layer with the instance. A thread of the layer would crash then. */
static void leave_device_behind(void)
{
    static float away[FIGURE][3];
    open_scene();
    write_soup(FIGURE);
    write_ways(away);
    for (uint32_t i = 0; i < 64; i++) {
        scatter((const float(*)[3])away);
        build_mesh(false, FIGURE, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR, i > 0);
    }
    instance_fixture_close(&fixture.instance);
    usleep(500000);
    _exit(0);
}

TEST(test_device_that_is_left_behind)
{
    int status = -1;
    const pid_t child = fork();
    if (!child)
        leave_device_behind();
    assert_true(child > 0 && waitpid(child, &status, 0) == child);
    assert_int_equal(status, 0);
}
#endif

/* ---- builds from the same input, beside memcmp(): some change a bit before the end of what they
 * read, or behind it */

enum {
    STRUCTURES = 24,
    REPEATED = 3,
    SMALL = 20,
    STRIDE = 16,
    READ = (3 * SMALL - 1) * STRIDE + 12
};

static VkAccelerationStructureKHR repeat_build(const struct device_buffer *memory, uint32_t place,
                                               bool *is_same)
{
    static uint8_t before[READ];
    uint8_t *input = scene.boxes.bytes;
    const VkDeviceSize size = 1 << 16;
    const VkAccelerationStructureKHR structure = fixture_structure(
        &fixture, memory, place * size, size, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    struct fixture_build build = {
        .geometry =
            triangles_geometry(scene.boxes.address, 3 * SMALL - 1, VK_INDEX_TYPE_NONE_KHR, 0),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .dstAccelerationStructure = structure,
                 .scratchData.deviceAddress = scene.scratch_address},
        .range.primitiveCount = SMALL,
    };
    build.geometry.geometry.triangles.vertexStride = STRIDE;
    *is_same = true;
    for (int i = 0; i < REPEATED; i++) {
        if (next_number() < 0.5F)
            input[(uint32_t)(next_number() * READ * 4)] ^= 1;
        *is_same &= !i || memcmp(before, input, READ) == 0;
        memcpy(before, input, READ);
        run_build(&build);
    }
    return structure;
}

static bool is_advised(VkAccelerationStructureKHR structure)
{
    const struct messages *messages = &fixture.instance.messages;
    char name[32];
    bool is_found = false;
    snprintf(name, sizeof(name), " %#" PRIx64 " ", (uint64_t)(uintptr_t)structure);
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        is_found |= strstr(messages->items[i].text, name) != NULL;
    return is_found;
}

TEST(test_same_input)
{
    VkAccelerationStructureKHR structures[STRUCTURES];
    bool is_same[STRUCTURES];
    uint32_t count = 0;
    open_with("submissions=1000,builds=3,lines=100");
    write_soup(SMALL * 2);
    const struct device_buffer memory = fixture_buffer(
        &fixture, STRUCTURES << 16, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    for (uint32_t i = 0; i < STRUCTURES; i++) {
        structures[i] = repeat_build(&memory, i, &is_same[i]);
        count += is_same[i];
    }
    destroy_scene();
    for (uint32_t i = 0; i < STRUCTURES; i++)
        assert_int_equal(is_advised(structures[i]), is_same[i]);
    assert_true(count > 2 && count < STRUCTURES - 2);
    expect_messages(count, "bytes and parameters were the same");
}

/* ---- instances */

/* On a plane, with distances of `step` and all turned and scaled. */
static void write_instances(struct device_buffer *buffer, float step)
{
    VkAccelerationStructureInstanceKHR *written = (void *)buffer->bytes;
    for (uint32_t i = 0; i < INSTANCES; i++) {
        const float angle = (float)i, scale = 1 + next_number(), c = scale * cosf(angle),
                    s = scale * sinf(angle);
        written[i] = (VkAccelerationStructureInstanceKHR){
            .transform = {{{c, -s, 0, step * (float)(i % 100)},
                           {s, c, 0, step * (float)(i / 100)},
                           {0, 0, scale, 0}}},
            .mask = 0xff,
            .accelerationStructureReference =
                structure_address(&fixture.vk, fixture.device, scene.blas),
        };
    }
}

static void build_instances(float step)
{
    struct device_buffer buffer =
        scene_input(INSTANCES * sizeof(VkAccelerationStructureInstanceKHR));
    const struct fixture_build build = scene_describe_instances(buffer.address, false, INSTANCES);
    write_soup(FIGURE);
    build_mesh(false, FIGURE, 0, false);
    write_instances(&buffer, step);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build(&fixture, commands, &build);
    fixture_finish(&fixture, commands);
}

ADVICE_TEST(test_instances)
{
    build_instances(1);
    fixture_expect_silence(&fixture);
}

ADVICE_TEST(test_instances_at_one_place)
{
    build_instances(0.1F);
    expect_messages(1, "10000 instances whose boxes overlap");
}
