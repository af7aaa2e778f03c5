/* SPDX-License-Identifier: Apache-2.0 */
/* Displacement micromaps on backend cpu, through the loader: built by the host and by command
 * buffers, and triangles displaced by them: built likewise, and updated. */
#include <string.h>

#include "input_scene.h"

enum { TRIANGLES = 2 };

static void build_micromap(const struct micromap *micromap, uint32_t rise, bool by_host)
{
    micromap_rise(micromap, rise);
    if (by_host)
        GET(micromap_build_by_host(micromap));
    else
        micromap_build_by_device(micromap);
    memset(micromap->input.bytes, 0xff, MICROMAP_SIZE);
}

/* ---- triangles in the planes x = 0 and 10, side by side; vectors are (1, 0, 0), scales 2, the
 * bias of plane 10 is 1. Triangle 0 uses triangle 1 of the micromap, and 1 uses 0; of 1 the edge of
 * vertices 2 and 0 is decimated. Vertices that the range leaves out are zeros. */

enum { FLAGS = 64, BIASES = 1024, VECTORS = 2048, FIRST_VERTEX = 2 };

static struct {
    struct input_scene scene;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
} user;

static struct micromap micromaps[3];

static void fill_triangles(void)
{
    const uint16_t indices[TRIANGLES] = {1, 0};
    const uint8_t flags[TRIANGLES] = {0, 4};
    unsigned char *other = user.scene.radii.bytes;
    float *to = (float *)user.scene.vertices.bytes + 3 * FIRST_VERTEX;
    float *biases = (float *)(void *)(other + BIASES) + 2 * FIRST_VERTEX;
    float *vectors = (float *)(void *)(other + VECTORS) + 3 * FIRST_VERTEX;
    for (int i = 0; i < TRIANGLES; i++) {
        const float x = (float)(10 * i), y = (float)(2 * i);
        const float corners[9] = {x, y, 0, x, y + 1, 0, x, y, 1};
        memcpy(to + 9 * i, corners, sizeof(corners));
    }
    for (int i = 0; i < 3 * TRIANGLES; i++) {
        const float vector[3] = {1, 0, 0};
        memcpy(vectors + 3 * i, vector, sizeof(vector));
        biases[2 * i] = i < 3 ? 0 : 1;
        biases[2 * i + 1] = 2;
    }
    memcpy(user.scene.indices.bytes, indices, sizeof(indices));
    memcpy(other + FLAGS, flags, sizeof(flags));
}

static uint64_t address_of(const struct device_buffer *buffer, bool by_host)
{
    return by_host ? (uintptr_t)buffer->bytes : buffer->address;
}

static void describe(const struct micromap *micromap, bool by_host)
{
    struct input_scene *scene = &user.scene;
    const uint64_t other = address_of(&scene->radii, by_host);
    user.displacement = MAKE(
        VkAccelerationStructureTrianglesDisplacementMicromapNV,
        .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
        .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .displacementBiasAndScaleBuffer.deviceAddress = other + BIASES,
        .displacementBiasAndScaleStride = 8,
        .displacementVectorBuffer.deviceAddress = other + VECTORS, .displacementVectorStride = 12,
        .displacedMicromapPrimitiveFlags.deviceAddress = other + FLAGS,
        .displacedMicromapPrimitiveFlagsStride = 1, .indexType = VK_INDEX_TYPE_UINT16,
        .indexBuffer.deviceAddress = address_of(&scene->indices, by_host), .indexStride = 2,
        .usageCountsCount = 2, .pUsageCounts = micromap_displacement_usages,
        .micromap = micromap->ext);
    input_scene_triangles(scene, &user.displacement, TRIANGLES,
                          address_of(&scene->vertices, by_host));
    scene->build.geometry.geometry.triangles.maxVertex += FIRST_VERTEX;
    scene->build.range.firstVertex = FIRST_VERTEX;
}

/* Micromaps that are not built, and triangles that use the last one. */
static void open_scene(uint32_t micromap_count)
{
    for (uint32_t i = 0; i < micromap_count; i++)
        micromap_open_displacement(&micromaps[i]);
    input_scene_open(&user.scene, VK_GEOMETRY_TYPE_TRIANGLES_KHR, NULL);
    user.scene.build.info.flags =
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISPLACEMENT_MICROMAP_UPDATE_BIT_NV;
    describe(&micromaps[micromap_count - 1], false);
    fill_triangles();
    input_scene_create(&user.scene);
}

static void build_by_device(bool is_indirect)
{
    input_scene_build(&user.scene, &user.scene.build.range, is_indirect);
}

static VkResult build_by_host(void)
{
    return host_build(&user.scene.build, user.scene.blas.handle, VK_NULL_HANDLE);
}

/* By `rise`, twice what the micromap says. */
static void expect_surface(float rise)
{
    /* the plane through the middles, of which that of edge 2-0 has become vertex 2 */
    const float places[2][3] = {{0.45f, 0.45f, 0.9f}, {0.6f, 0.1f, 0.8f}};
    input_scene_expect_hit(&user.scene, 0.2f, 0.3f, 1 + rise, 0);
    for (int i = 0; i < 2; i++) {
        const AssayHit hit = input_scene_trace(&user.scene, 2 + places[i][0], places[i][1]);
        assert_true(hit.isHit && hit.primitive == 1);
        assert_float_equal(hit.t, 12 + rise * places[i][2], 1e-4);
        assert_float_equal(hit.u, places[i][0], 1e-5);
        assert_float_equal(hit.v, places[i][1], 1e-5);
    }
}

/* ---- tests */

/* By the host or a command buffer, each; the micromap's input is gone, then the triangles'. */
SILENT_TEST(test_builds)
{
    for (int way = 0; way < 6; way++) {
        open_scene(1);
        build_micromap(&micromaps[0], 2047, way % 2);
        if (way < 2) {
            describe(&micromaps[0], true);
            GET(build_by_host());
        } else {
            build_by_device(way >= 4);
        }
        expect_surface(2);
    }
}

/* Triangles are where the micromap put them when they were built, however late that shows. */
SILENT_TEST(test_micromap_that_changes)
{
    open_scene(1);
    build_micromap(&micromaps[0], 2047, false);
    build_by_device(false);
    build_micromap(&micromaps[0], 0, false);
    expect_surface(2);
    fill_triangles();
    build_by_device(false);
    destroy((uint64_t)micromaps[0].ext);
    expect_surface(0);
}

SILENT_TEST(test_copies)
{
    static _Alignas(16) unsigned char bytes[MICROMAP_SIZE];
    open_scene(3);
    build_micromap(&micromaps[0], 2047, false);
    VkCommandBuffer commands = device_begin(PRIMARY);
    micromap_clone_by_device(commands, &micromaps[0], &micromaps[1]);
    device_finish(commands);
    GET(micromap_save_by_host(&micromaps[1], bytes));
    GET(micromap_load_by_host(bytes, &micromaps[2]));
    build_by_device(false);
    expect_surface(2);
}

/* Of a structure that nobody has asked for yet, with another micromap. */
SILENT_TEST(test_updates)
{
    open_scene(2);
    build_micromap(&micromaps[1], 2047, false);
    build_micromap(&micromaps[0], 0, true);
    build_by_device(false);
    user.scene.build.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    user.scene.build.info.srcAccelerationStructure = user.scene.blas.handle;
    user.displacement.micromap = micromaps[0].ext;
    fill_triangles();
    const AssayCounters before = fixture_counters();
    build_by_device(false);
    expect_surface(0);
    assert_int_equal(fixture_counters().updates, before.updates + 1);
}

/* A micromap that isn't built, and arrays that can't be read: there is no structure then. */
NOISY_TEST(test_mistakes)
{
    open_scene(1);
    describe(&micromaps[0], true);
    expect_mistake(build_by_host());
    build_micromap(&micromaps[0], 2047, true);
    VkDeviceAddress *const addresses[] = {
        &user.displacement.displacementVectorBuffer.deviceAddress,
        &user.displacement.displacementBiasAndScaleBuffer.deviceAddress,
        &user.displacement.displacedMicromapPrimitiveFlags.deviceAddress,
        (VkDeviceAddress *)(void *)&user.displacement.pUsageCounts};
    for (size_t i = 0; i < ARRAY_COUNT(addresses); i++) {
        describe(&micromaps[0], true);
        *addresses[i] = 0x1000;
        expect_mistake(build_by_host());
    }
}
