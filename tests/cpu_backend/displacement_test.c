/* SPDX-License-Identifier: Apache-2.0 */
/* Displacement micromaps on backend cpu, through the loader: built by the host and by command
 * buffers, and triangles displaced by them: built likewise, and updated. */
#include <string.h>

#include "input_scene.h"

enum { TRIANGLES = 2, MICROMAP_SIZE = 4096, DATA = 256, BLOCK = 64 };

/* ---- a micromap: of triangle 0, of level 1, the middles of its edges rise; triangle 1 is whole
 * and rises */

static const VkMicromapUsageEXT usages[2] = {
    {1, 1, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV},
    {1, 0, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV}};

struct micromap {
    VkMicromapEXT handle;
    struct device_buffer storage, input;
};

static void write_value(unsigned char *block, uint32_t vertex, uint32_t value)
{
    for (uint32_t bit = 0; bit < 11; bit++)
        if (value >> bit & 1)
            block[(11 * vertex + bit) / 8] |= (unsigned char)(1u << (11 * vertex + bit) % 8);
}

static void fill_micromap(const struct micromap *micromap, uint32_t middle)
{
    const VkMicromapTriangleEXT triangles[TRIANGLES] = {
        {0, 1, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV},
        {BLOCK, 0, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV}};
    unsigned char *bytes = micromap->input.bytes;
    memset(bytes, 0, MICROMAP_SIZE);
    memcpy(bytes, triangles, sizeof(triangles));
    for (uint32_t i = 0; i < 3; i++) {
        write_value(bytes + DATA, 3 + i, middle);
        write_value(bytes + DATA + BLOCK, i, middle);
    }
}

static void open_micromap(struct micromap *micromap)
{
    *micromap = (struct micromap){.storage = device_buffer_create(&device, MICROMAP_SIZE),
                                  .input = device_buffer_create(&device, MICROMAP_SIZE)};
    const VkMicromapCreateInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_MICROMAP_CREATE_INFO_EXT,
        .buffer = micromap->storage.handle,
        .size = MICROMAP_SIZE,
        .type = VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV,
    };
    assert_int_equal(
        device.stage.vk.CreateMicromapEXT(device.stage.device, &info, NULL, &micromap->handle),
        VK_SUCCESS);
}

static void close_micromap(struct micromap *micromap)
{
    device.stage.vk.DestroyMicromapEXT(device.stage.device, micromap->handle, NULL);
    device_buffer_destroy(&device, &micromap->storage);
    device_buffer_destroy(&device, &micromap->input);
}

static VkMicromapBuildInfoEXT info_of(const struct micromap *micromap, uint64_t base)
{
    return (VkMicromapBuildInfoEXT){
        .sType = VK_STRUCTURE_TYPE_MICROMAP_BUILD_INFO_EXT,
        .type = VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV,
        .mode = VK_BUILD_MICROMAP_MODE_BUILD_EXT,
        .dstMicromap = micromap->handle,
        .usageCountsCount = 2,
        .pUsageCounts = usages,
        .data.deviceAddress = base + DATA,
        .triangleArray.deviceAddress = base,
        .triangleArrayStride = sizeof(VkMicromapTriangleEXT),
    };
}

static void build_micromap(const struct micromap *micromap, uint32_t middle, bool by_host)
{
    const VkMicromapBuildInfoEXT host = info_of(micromap, (uintptr_t)micromap->input.bytes);
    const VkMicromapBuildInfoEXT info = info_of(micromap, micromap->input.address);
    fill_micromap(micromap, middle);
    if (by_host) {
        assert_int_equal(
            device.stage.vk.BuildMicromapsEXT(device.stage.device, VK_NULL_HANDLE, 1, &host),
            VK_SUCCESS);
    } else {
        VkCommandBuffer commands = device_begin(&device, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
        device.stage.vk.CmdBuildMicromapsEXT(commands, 1, &info);
        device_finish(&device, commands);
    }
    memset(micromap->input.bytes, 0xff, MICROMAP_SIZE);
}

/* ---- triangles in the planes x = 0 and 10; vectors are (1, 0, 0), scales 2, the bias of plane 10
 * is 1. Triangle 0 uses triangle 1 of the micromap, and 1 uses 0; of 1 the edge of vertices 2 and 0
 * is decimated. Vertices that the range leaves out are zeros. */

enum { FLAGS = 64, BIASES = 1024, VECTORS = 2048, FIRST_VERTEX = 2 };

struct user {
    struct input_scene scene;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
};

static void fill_triangles(struct user *user)
{
    const uint16_t indices[TRIANGLES] = {1, 0};
    const uint8_t flags[TRIANGLES] = {0, 4};
    unsigned char *other = user->scene.radii.bytes;
    float *to = (float *)user->scene.vertices.bytes + 3 * FIRST_VERTEX;
    float *biases = (float *)(void *)(other + BIASES) + 2 * FIRST_VERTEX;
    float *vectors = (float *)(void *)(other + VECTORS) + 3 * FIRST_VERTEX;
    for (int i = 0; i < TRIANGLES; i++) {
        const float x = (float)(10 * i), corners[9] = {x, 0, 0, x, 1, 0, x, 0, 1};
        memcpy(to + 9 * i, corners, sizeof(corners));
    }
    for (int i = 0; i < 3 * TRIANGLES; i++) {
        const float vector[3] = {1, 0, 0};
        memcpy(vectors + 3 * i, vector, sizeof(vector));
        biases[2 * i] = i < 3 ? 0 : 1;
        biases[2 * i + 1] = 2;
    }
    memcpy(user->scene.indices.bytes, indices, sizeof(indices));
    memcpy(other + FLAGS, flags, sizeof(flags));
}

static uint64_t address_of(const struct device_buffer *buffer, bool by_host)
{
    return by_host ? (uintptr_t)buffer->bytes : buffer->address;
}

static void describe(struct user *user, const struct micromap *micromap, bool by_host)
{
    struct input_scene *scene = &user->scene;
    const uint64_t other = address_of(&scene->radii, by_host);
    user->displacement = (VkAccelerationStructureTrianglesDisplacementMicromapNV){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV,
        .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
        .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .displacementBiasAndScaleBuffer.deviceAddress = other + BIASES,
        .displacementBiasAndScaleStride = 8,
        .displacementVectorBuffer.deviceAddress = other + VECTORS,
        .displacementVectorStride = 12,
        .displacedMicromapPrimitiveFlags.deviceAddress = other + FLAGS,
        .displacedMicromapPrimitiveFlagsStride = 1,
        .indexType = VK_INDEX_TYPE_UINT16,
        .indexBuffer.deviceAddress = address_of(&scene->indices, by_host),
        .indexStride = 2,
        .usageCountsCount = 2,
        .pUsageCounts = usages,
        .micromap = micromap->handle,
    };
    scene->build.geometry.geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
        .pNext = &user->displacement,
        .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.deviceAddress = address_of(&scene->vertices, by_host),
        .vertexStride = 12,
        .maxVertex = FIRST_VERTEX + 3 * TRIANGLES - 1,
        .indexType = VK_INDEX_TYPE_NONE_KHR,
    };
    scene->build.range.primitiveCount = TRIANGLES;
    scene->build.range.firstVertex = FIRST_VERTEX;
}

static void open_user(struct user *user, const struct micromap *micromap)
{
    input_scene_open(&user->scene, VK_GEOMETRY_TYPE_TRIANGLES_KHR, NULL);
    user->scene.build.info.flags =
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISPLACEMENT_MICROMAP_UPDATE_BIT_NV;
    describe(user, micromap, false);
    fill_triangles(user);
    input_scene_create(&user->scene);
}

/* `rise`: what 2 * middle / 2047 is. Behind triangle 0, which is whole, lies 1. */
static void expect_surface(const struct user *user, float rise)
{
    const uint64_t blas = (uint64_t)user->scene.blas.handle;
    input_scene_expect_hit(&user->scene, 0.2f, 0.3f, 1 + rise, 0);
    const AssayRay behind = {.origin = {5, 0.3f, 0.3f}, .direction = {1, 0, 0}, .tMax = 100};
    AssayRay ray = behind;
    AssayHit hit;
    const AssayTraceInfo info = {.accelerationStructure = blas,
                                 .accuracy = ASSAY_ACCURACY_EXACT,
                                 .rayCount = 1,
                                 .raySize = sizeof(ray),
                                 .hitSize = sizeof(hit),
                                 .rays = &ray,
                                 .hits = &hit};
    /* in the middle: the plane through the middles, of which that of edge 2-0 went to vertex 2 */
    const float places[2][3] = {{0.45f, 0.45f, 0.9f}, {0.6f, 0.1f, 0.8f}};
    for (int i = 0; i < 2; i++) {
        ray.origin[1] = places[i][0];
        ray.origin[2] = places[i][1];
        assert_int_equal(device.stage.trace_rays(device.stage.device, &info), VK_SUCCESS);
        assert_true(hit.isHit);
        assert_int_equal(hit.primitive, 1);
        assert_float_equal(hit.t, 6 + rise * places[i][2], 1e-4);
        assert_float_equal(hit.u, places[i][0], 1e-5);
        assert_float_equal(hit.v, places[i][1], 1e-5);
    }
}

/* ---- tests */

/* By the host or a command buffer, each; the micromap's input is gone, then the triangles'. */
static void test_builds(void **state)
{
    (void)state;
    for (int way = 0; way < 6; way++) {
        struct micromap micromap;
        struct user user;
        open_micromap(&micromap);
        open_user(&user, &micromap);
        build_micromap(&micromap, 2047, way % 2);
        if (way < 2) {
            describe(&user, &micromap, true);
            assert_int_equal(stage_build(&device.stage, VK_NULL_HANDLE, &user.scene.build,
                                         user.scene.blas.handle, VK_NULL_HANDLE),
                             VK_SUCCESS);
        } else {
            input_scene_build(&user.scene, &user.scene.build.range, way >= 4);
        }
        expect_surface(&user, 2);
        input_scene_close(&user.scene);
        close_micromap(&micromap);
    }
}

/* Triangles are where the micromap put them when they were built, however late that shows. */
static void test_micromap_that_changes(void **state)
{
    (void)state;
    struct micromap micromap;
    struct user user;
    open_micromap(&micromap);
    open_user(&user, &micromap);
    build_micromap(&micromap, 2047, false);
    input_scene_build(&user.scene, &user.scene.build.range, false);
    build_micromap(&micromap, 0, false);
    expect_surface(&user, 2);
    fill_triangles(&user);
    input_scene_build(&user.scene, &user.scene.build.range, false);
    device.stage.vk.DestroyMicromapEXT(device.stage.device, micromap.handle, NULL);
    micromap.handle = VK_NULL_HANDLE;
    expect_surface(&user, 0);
    input_scene_close(&user.scene);
    close_micromap(&micromap);
}

/* Two in one command buffer, of which the second starts from what the first hasn't made yet. */
static void test_updates(void **state)
{
    (void)state;
    struct micromap micromap, other;
    struct user user;
    open_micromap(&micromap);
    open_micromap(&other);
    open_user(&user, &micromap);
    build_micromap(&micromap, 2047, false);
    build_micromap(&other, 0, true);
    input_scene_build(&user.scene, &user.scene.build.range, false);
    user.scene.build.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    user.scene.build.info.srcAccelerationStructure = user.scene.blas.handle;
    user.displacement.micromap = other.handle;
    fill_triangles(&user);
    const AssayCounters before = stage_counters(&device.stage);
    input_scene_build(&user.scene, &user.scene.build.range, false);
    expect_surface(&user, 0);
    assert_int_equal(stage_counters(&device.stage).updates, before.updates + 1);
    input_scene_close(&user.scene);
    close_micromap(&micromap);
    close_micromap(&other);
}

/* A micromap that isn't built, and arrays that can't be read: there is no structure then. */
static void test_mistakes(void **state)
{
    (void)state;
    struct micromap micromap;
    struct user user;
    open_micromap(&micromap);
    open_user(&user, &micromap);
    for (int i = 0; i < 5; i++) {
        describe(&user, &micromap, true);
        if (i == 1)
            build_micromap(&micromap, 2047, true);
        if (i == 1)
            user.displacement.displacementVectorBuffer.deviceAddress = 0x1000;
        if (i == 2)
            user.displacement.displacementBiasAndScaleBuffer.deviceAddress = 0x1000;
        if (i == 3)
            user.displacement.displacedMicromapPrimitiveFlags.deviceAddress = 0x1000;
        if (i == 4)
            user.displacement.pUsageCounts = (void *)(uintptr_t)0x1000;
        assert_int_equal(stage_build(&device.stage, VK_NULL_HANDLE, &user.scene.build,
                                     user.scene.blas.handle, VK_NULL_HANDLE),
                         VK_ERROR_VALIDATION_FAILED);
    }
    messages_clear(&device.stage.kit.messages);
    input_scene_close(&user.scene);
    close_micromap(&micromap);
}

static int run_all(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_builds),
        cmocka_unit_test(test_micromap_that_changes),
        cmocka_unit_test(test_updates),
        cmocka_unit_test(test_mistakes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

int main(int argc, char **argv)
{
    return device_stage_main(&device, argc, argv, run_all);
}
