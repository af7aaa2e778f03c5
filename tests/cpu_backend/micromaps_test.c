/* SPDX-License-Identifier: Apache-2.0 */
/* Opacity micromaps of both extensions on backend cpu, through the loader: built by the host and by
 * command buffers, used by triangles, looked up by rays, copied and queried. */
#include <stdlib.h>
#include <string.h>

#include "input_scene.h"

enum { TRIANGLES = 3 };

/* ---- triangles that use it: triangle 0 has its triangle 0, 1 its 2, 2 its 1 */

struct user {
    struct input_scene scene;
    VkAccelerationStructureTrianglesOpacityMicromapEXT ext;
    VkAccelerationStructureTrianglesOpacityMicromapKHR khr;
};

static void fill_triangles(struct user *user)
{
    const uint16_t indices[TRIANGLES] = {0, 2, 1};
    float *to = (float *)user->scene.vertices.bytes;
    for (int i = 0; i < TRIANGLES; i++) {
        const float x = (float)i, corners[9] = {x, 0, 0, x, 1, 0, x, 0, 1};
        memcpy(to + 9 * (size_t)i, corners, sizeof(corners));
    }
    memcpy(user->scene.indices.bytes, indices, sizeof(indices));
}

static void open_user(struct user *user, const struct micromap *micromap)
{
    struct input_scene *scene = &user->scene;
    input_scene_open(scene, VK_GEOMETRY_TYPE_TRIANGLES_KHR, NULL);
    user->ext =
        MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT, .indexType = VK_INDEX_TYPE_UINT16,
             .indexBuffer.deviceAddress = scene->indices.address, .indexStride = 2,
             .usageCountsCount = 2, .pUsageCounts = micromap_usages, .micromap = micromap->ext);
    user->khr =
        MAKE(VkAccelerationStructureTrianglesOpacityMicromapKHR, .indexType = VK_INDEX_TYPE_UINT16,
             .indexBuffer = scene->indices.address, .indexStride = 2, .micromap = micromap->khr);
    input_scene_triangles(scene, micromap->khr ? (void *)&user->khr : (void *)&user->ext, TRIANGLES,
                          scene->vertices.address);
    fill_triangles(user);
    input_scene_create(scene);
}

static void expect_opacity(const struct user *user, float y, float z, float t, uint32_t primitive,
                           bool is_opaque)
{
    input_scene_expect_hit(&user->scene, y, z, t, primitive);
    assert_int_equal(input_scene_trace(&user->scene, y, z).isOpaque, is_opaque);
}

static void expect_opacities(const struct user *user)
{
    expect_opacity(user, 0.1f, 0.1f, 3, 2, true);
    expect_opacity(user, 0.3f, 0.3f, 2, 1, true);
    expect_opacity(user, 0.8f, 0.1f, 2, 1, false);
    expect_opacity(user, 0.1f, 0.8f, 2, 1, false);
}

/* ---- tests */

/* By the host, by command buffers, and -KHR's. */
NOISY_TEST(test_builds)
{
    for (int way = 0; way < 4; way++) {
        struct micromap micromap;
        struct user user;
        micromap_open(&micromap, way != 3);
        open_user(&user, &micromap);
        if (way == 0)
            GET(micromap_build_by_host(&micromap));
        else
            micromap_build_by_device(&micromap);
        input_scene_build(&user.scene, &user.scene.build.range, way == 2);
        expect_opacities(&user);
    }
}

/* Rays look up what the micromap has become; without it, triangles are what their geometry is. */
NOISY_TEST(test_rebuilt_and_destroyed)
{
    struct micromap micromap;
    struct user user;
    micromap_open(&micromap, true);
    open_user(&user, &micromap);
    GET(micromap_build_by_host(&micromap));
    input_scene_build(&user.scene, &user.scene.build.range, false);
    const AssayCounters before = fixture_counters();
    expect_opacity(&user, 0.1f, 0.1f, 3, 2, true);
    assert_true(fixture_counters().micromapsRead > before.micromapsRead);
    micromap.input.bytes[DATA + 1] = 1;
    GET(micromap_build_by_host(&micromap));
    expect_opacity(&user, 0.1f, 0.1f, 1, 0, true);
    destroy((uint64_t)micromap.ext);
    expect_opacity(&user, 0.1f, 0.1f, 1, 0, false);
}

NOISY_TEST(test_mistakes)
{
    struct micromap micromap;
    micromap_open(&micromap, true);
    STRUCT(VkMicromapBuildSizesInfoEXT, sizes);
    VkMicromapBuildInfoEXT info =
        micromap_info(&micromap, (uint64_t)(uintptr_t)micromap.input.bytes);
    vk.GetMicromapBuildSizesEXT(device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, &info,
                                &sizes);
    assert_true(sizes.micromapSize > 0 && sizes.micromapSize <= MICROMAP_SIZE);
    assert_false(sizes.discardable);
    info.pUsageCounts = (void *)(uintptr_t)0x1000;
    expect_mistake(vk.BuildMicromapsEXT(device, VK_NULL_HANDLE, 1, &info));
    sizes.micromapSize = 1;
    vk.GetMicromapBuildSizesEXT(device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR, &info,
                                &sizes);
    assert_int_equal(sizes.micromapSize, 1); /* the call is skipped */
    info.pUsageCounts = micromap_usages;
    info.data.deviceAddress = 0x1000;
    expect_mistake(vk.BuildMicromapsEXT(device, VK_NULL_HANDLE, 1, &info));
    GET(micromap_build_by_host(&micromap));
    /* It is none that rays could be traced in. */
    expect_mistake(fixture_trace_none((VkAccelerationStructureKHR)micromap.ext));
}

/* ---- copies */

static uint64_t property(const struct micromap *micromap, VkQueryType type)
{
    uint64_t value = 0;
    GET(vk.WriteMicromapsPropertiesEXT(device, 1, &micromap->ext, type, sizeof(value), &value, 8));
    return value;
}

static void *serialize(const struct micromap *micromap, size_t *size)
{
    *size = property(micromap, VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT);
    void *bytes = own_block(malloc(*size));
    GET(micromap_save_by_host(micromap, bytes));
    return bytes;
}

static void expect_copy(const struct micromap *copy, const void *bytes, size_t size)
{
    size_t copied_size;
    void *copied = serialize(copy, &copied_size);
    assert_int_equal(copied_size, size);
    assert_memory_equal(copied, bytes, size);
}

SILENT_TEST(test_copies_by_host)
{
    struct micromap from, to;
    size_t size;
    micromap_open(&from, true);
    GET(micromap_build_by_host(&from));
    void *bytes = serialize(&from, &size);
    assert_true(property(&from, VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT) <= MICROMAP_SIZE);
    const VkCopyMicromapModeEXT modes[] = {VK_COPY_MICROMAP_MODE_CLONE_EXT,
                                           VK_COPY_MICROMAP_MODE_COMPACT_EXT};
    for (int i = 0; i < 3; i++) {
        micromap_open(&to, true);
        GET(i == 2 ? micromap_load_by_host(bytes, &to)
                   : micromap_copy_by_host(&from, &to, modes[i]));
        expect_copy(&to, bytes, size);
    }
    VkAccelerationStructureCompatibilityKHR compatibility;
    const STRUCT(VkMicromapVersionInfoEXT, version, .pVersionData = bytes);
    vk.GetDeviceMicromapCompatibilityEXT(device, &version, &compatibility);
    assert_int_equal(compatibility, VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR);
}

/* Built, cloned, serialized and deserialized by one command buffer each, and queried. */
SILENT_TEST(test_copies_by_device)
{
    struct micromap from, clone, again;
    struct device_buffer bytes = device_buffer_create(MICROMAP_SIZE);
    const VkQueryType type = VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT;
    VkQueryPool pool = query_pool_create(&vk, device, type, 1);
    OWN(DestroyQueryPool, pool);
    size_t size;
    micromap_open(&from, true);
    micromap_open(&clone, true);
    micromap_open(&again, true);
    micromap_build_by_device(&from);
    const STRUCT(VkCopyMicromapToMemoryInfoEXT, to_memory, .src = clone.ext,
                 .dst.deviceAddress = bytes.address, .mode = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT);
    const STRUCT(VkCopyMemoryToMicromapInfoEXT, from_memory, .src.deviceAddress = bytes.address,
                 .dst = again.ext, .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT);
    VkCommandBuffer commands = device_begin(PRIMARY);
    vk.CmdResetQueryPool(commands, pool, 0, 1);
    micromap_clone_by_device(commands, &from, &clone);
    vk.CmdWriteMicromapsPropertiesEXT(commands, 1, &clone.ext, type, pool, 0);
    vk.CmdCopyMicromapToMemoryEXT(commands, &to_memory);
    device_finish(commands);
    commands = device_begin(PRIMARY);
    vk.CmdCopyMemoryToMicromapEXT(commands, &from_memory);
    device_finish(commands);
    const uint64_t queried = device_query(pool, 0);
    void *expected = serialize(&from, &size);
    assert_int_equal(queried, size);
    expect_copy(&again, expected, size);
}
