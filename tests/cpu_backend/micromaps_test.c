/* SPDX-License-Identifier: Apache-2.0 */
/* Opacity micromaps of both extensions on backend cpu, through the loader: built and copied by the
 * host and by command buffers, used by triangles, and looked up by rays. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "input_scene.h"

enum { MICROMAP_TRIANGLES = 3, TRIANGLES = 3, DATA = 256, MICROMAP_SIZE = 4096 };

/* ---- a micromap: triangle 0 is transparent, 1 opaque, and of 2 the quarter at vertex 0 is
 * transparent, the middle opaque, that at vertex 1 unknown transparent, at vertex 2 unknown opaque
 */

static const VkMicromapUsageEXT usages[2] = {
    {.count = 2, .subdivisionLevel = 0, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
    {.count = 1, .subdivisionLevel = 1, .format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT}};

static void fill_micromap(unsigned char *bytes)
{
    const VkMicromapTriangleEXT triangles[MICROMAP_TRIANGLES] = {
        {.dataOffset = 1, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
        {.dataOffset = 2, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
        {.dataOffset = 7, .subdivisionLevel = 1, .format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT}};
    memcpy(bytes, triangles, sizeof(triangles));
    bytes[DATA + 2] = 1;
    bytes[DATA + 7] = 0 | 1 << 2 | 2 << 4 | 3 << 6;
}

struct micromap {
    VkMicromapEXT ext;
    VkAccelerationStructureKHR khr;
    struct device_buffer storage, input;
};

static void open_micromap(struct micromap *micromap, bool is_ext)
{
    *micromap = (struct micromap){.storage = device_buffer_create(&device, MICROMAP_SIZE),
                                  .input = device_buffer_create(&device, MICROMAP_SIZE)};
    const VkMicromapCreateInfoEXT ext = {
        .sType = VK_STRUCTURE_TYPE_MICROMAP_CREATE_INFO_EXT,
        .buffer = micromap->storage.handle,
        .size = MICROMAP_SIZE,
        .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
    };
    const VkAccelerationStructureCreateInfo2KHR khr = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_2_KHR,
        .addressRange = {micromap->storage.address, MICROMAP_SIZE},
        .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR,
    };
    const struct stage *stage = &device.stage;
    if (is_ext)
        assert_int_equal(stage->vk.CreateMicromapEXT(stage->device, &ext, NULL, &micromap->ext),
                         VK_SUCCESS);
    else
        assert_int_equal(
            stage->vk.CreateAccelerationStructure2KHR(stage->device, &khr, NULL, &micromap->khr),
            VK_SUCCESS);
    fill_micromap(micromap->input.bytes);
}

static void close_micromap(struct micromap *micromap)
{
    const struct stage *stage = &device.stage;
    stage->vk.DestroyMicromapEXT(stage->device, micromap->ext, NULL);
    stage->vk.DestroyAccelerationStructureKHR(stage->device, micromap->khr, NULL);
    device_buffer_destroy(&device, &micromap->storage);
    device_buffer_destroy(&device, &micromap->input);
}

static VkMicromapBuildInfoEXT info_of(const struct micromap *micromap, uint64_t base)
{
    return (VkMicromapBuildInfoEXT){
        .sType = VK_STRUCTURE_TYPE_MICROMAP_BUILD_INFO_EXT,
        .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
        .mode = VK_BUILD_MICROMAP_MODE_BUILD_EXT,
        .dstMicromap = micromap->ext,
        .usageCountsCount = 2,
        .pUsageCounts = usages,
        .data.deviceAddress = base + DATA,
        .triangleArray.deviceAddress = base,
        .triangleArrayStride = sizeof(VkMicromapTriangleEXT),
    };
}

static VkResult build_by_host(const struct micromap *micromap)
{
    const VkMicromapBuildInfoEXT info =
        info_of(micromap, (uint64_t)(uintptr_t)micromap->input.bytes);
    return device.stage.vk.BuildMicromapsEXT(device.stage.device, VK_NULL_HANDLE, 1, &info);
}

static void record_khr(const struct micromap *micromap, VkCommandBuffer commands)
{
    VkMicromapUsageKHR own[2];
    const VkMicromapUsageKHR *const pointers[2] = {&own[0], &own[1]};
    memcpy(own, usages, sizeof(own));
    const VkAccelerationStructureGeometryMicromapDataKHR data = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR,
        .usageCountsCount = 2,
        .ppUsageCounts = pointers,
        .data = micromap->input.address + DATA,
        .triangleArray = micromap->input.address,
        .triangleArrayStride = sizeof(VkMicromapTriangleKHR),
    };
    const VkAccelerationStructureGeometryKHR geometry = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .pNext = &data,
        .geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR,
    };
    const VkAccelerationStructureBuildGeometryInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR,
        .dstAccelerationStructure = micromap->khr,
        .geometryCount = 1,
        .pGeometries = &geometry,
        .scratchData.deviceAddress = micromap->storage.address,
    };
    const VkAccelerationStructureBuildRangeInfoKHR *const no_range = NULL;
    device.stage.vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &no_range);
}

/* Nothing is left of the input afterwards. */
static void build_by_device(const struct micromap *micromap)
{
    const VkMicromapBuildInfoEXT info = info_of(micromap, micromap->input.address);
    VkCommandBuffer commands = device_begin(&device, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    if (micromap->ext)
        device.stage.vk.CmdBuildMicromapsEXT(commands, 1, &info);
    else
        record_khr(micromap, commands);
    device_finish(&device, commands);
    memset(micromap->input.bytes, 0xff, MICROMAP_SIZE);
}

/* ---- triangles that use it: triangle 0 has its triangle 0, 1 its 2, 2 its 1 */

struct user {
    struct input_scene scene;
    VkAccelerationStructureTrianglesOpacityMicromapEXT ext;
    VkAccelerationStructureTrianglesOpacityMicromapKHR khr;
};

static void fill_triangles(struct user *user)
{
    const uint16_t indices[TRIANGLES] = {0, 2, 1};
    float *to = user->scene.vertices.bytes;
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
    user->ext = (VkAccelerationStructureTrianglesOpacityMicromapEXT){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT,
        .indexType = VK_INDEX_TYPE_UINT16,
        .indexBuffer.deviceAddress = scene->indices.address,
        .indexStride = 2,
        .usageCountsCount = 2,
        .pUsageCounts = usages,
        .micromap = micromap->ext,
    };
    user->khr = (VkAccelerationStructureTrianglesOpacityMicromapKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR,
        .indexType = VK_INDEX_TYPE_UINT16,
        .indexBuffer = scene->indices.address,
        .indexStride = 2,
        .micromap = micromap->khr,
    };
    scene->build.geometry.geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
        .pNext = micromap->khr ? (void *)&user->khr : (void *)&user->ext,
        .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.deviceAddress = scene->vertices.address,
        .vertexStride = 12,
        .maxVertex = 3 * TRIANGLES - 1,
        .indexType = VK_INDEX_TYPE_NONE_KHR,
    };
    scene->build.range.primitiveCount = TRIANGLES;
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
static void test_builds(void **state)
{
    (void)state;
    for (int way = 0; way < 4; way++) {
        struct micromap micromap;
        struct user user;
        open_micromap(&micromap, way != 3);
        open_user(&user, &micromap);
        if (way == 0)
            assert_int_equal(build_by_host(&micromap), VK_SUCCESS);
        else
            build_by_device(&micromap);
        input_scene_build(&user.scene, &user.scene.build.range, way == 2);
        expect_opacities(&user);
        messages_clear(
            &device.stage.kit.messages); /* of scratch, which KHR's build takes none of */
        input_scene_close(&user.scene);
        close_micromap(&micromap);
    }
}

/* Rays look up what the micromap has become; without it, triangles are what their geometry is. */
static void test_rebuilt_and_destroyed(void **state)
{
    (void)state;
    struct micromap micromap;
    struct user user;
    open_micromap(&micromap, true);
    open_user(&user, &micromap);
    assert_int_equal(build_by_host(&micromap), VK_SUCCESS);
    input_scene_build(&user.scene, &user.scene.build.range, false);
    const AssayCounters before = stage_counters(&device.stage);
    expect_opacity(&user, 0.1f, 0.1f, 3, 2, true);
    assert_true(stage_counters(&device.stage).micromapsRead > before.micromapsRead);
    ((unsigned char *)micromap.input.bytes)[DATA + 1] = 1;
    assert_int_equal(build_by_host(&micromap), VK_SUCCESS);
    expect_opacity(&user, 0.1f, 0.1f, 1, 0, true);
    device.stage.vk.DestroyMicromapEXT(device.stage.device, micromap.ext, NULL);
    micromap.ext = VK_NULL_HANDLE;
    expect_opacity(&user, 0.1f, 0.1f, 1, 0, false);
    messages_clear(&device.stage.kit.messages);
    input_scene_close(&user.scene);
    close_micromap(&micromap);
}

static uint64_t property(const struct micromap *micromap, VkQueryType type)
{
    uint64_t value = 0;
    assert_int_equal(device.stage.vk.WriteMicromapsPropertiesEXT(
                         device.stage.device, 1, &micromap->ext, type, sizeof(value), &value, 8),
                     VK_SUCCESS);
    return value;
}

static void *serialize(const struct micromap *micromap, size_t *size)
{
    *size = property(micromap, VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT);
    void *bytes = malloc(*size);
    const VkCopyMicromapToMemoryInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_COPY_MICROMAP_TO_MEMORY_INFO_EXT,
        .src = micromap->ext,
        .dst.hostAddress = bytes,
        .mode = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT,
    };
    assert_int_equal(
        device.stage.vk.CopyMicromapToMemoryEXT(device.stage.device, VK_NULL_HANDLE, &info),
        VK_SUCCESS);
    return bytes;
}

static void expect_copy(const struct micromap *copy, const void *bytes, size_t size)
{
    size_t copied_size;
    void *copied = serialize(copy, &copied_size);
    assert_int_equal(copied_size, size);
    assert_memory_equal(copied, bytes, size);
    free(copied);
}

static void test_copies_by_host(void **state)
{
    (void)state;
    struct micromap from, to;
    size_t size;
    open_micromap(&from, true);
    assert_int_equal(build_by_host(&from), VK_SUCCESS);
    void *bytes = serialize(&from, &size);
    assert_true(property(&from, VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT) <= MICROMAP_SIZE);
    const VkCopyMicromapModeEXT modes[] = {VK_COPY_MICROMAP_MODE_CLONE_EXT,
                                           VK_COPY_MICROMAP_MODE_COMPACT_EXT};
    for (int i = 0; i < 3; i++) {
        open_micromap(&to, true);
        const VkCopyMemoryToMicromapInfoEXT deserialize = {
            .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_MICROMAP_INFO_EXT,
            .src.hostAddress = bytes,
            .dst = to.ext,
            .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT,
        };
        const VkCopyMicromapInfoEXT copy = {.sType = VK_STRUCTURE_TYPE_COPY_MICROMAP_INFO_EXT,
                                            .src = from.ext,
                                            .dst = to.ext,
                                            .mode = modes[i % 2]};
        assert_int_equal(
            i == 2 ? device.stage.vk.CopyMemoryToMicromapEXT(device.stage.device, VK_NULL_HANDLE,
                                                             &deserialize)
                   : device.stage.vk.CopyMicromapEXT(device.stage.device, VK_NULL_HANDLE, &copy),
            VK_SUCCESS);
        expect_copy(&to, bytes, size);
        close_micromap(&to);
    }
    VkAccelerationStructureCompatibilityKHR compatibility;
    const VkMicromapVersionInfoEXT version = {.sType = VK_STRUCTURE_TYPE_MICROMAP_VERSION_INFO_EXT,
                                              .pVersionData = bytes};
    device.stage.vk.GetDeviceMicromapCompatibilityEXT(device.stage.device, &version,
                                                      &compatibility);
    assert_int_equal(compatibility, VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR);
    free(bytes);
    close_micromap(&from);
    device_expect_silence(&device);
}

/* Built, cloned, serialized and deserialized by one command buffer each, and queried. */
static void test_copies_by_device(void **state)
{
    (void)state;
    struct micromap from, clone, again;
    struct device_buffer bytes = device_buffer_create(&device, MICROMAP_SIZE);
    const VkQueryPoolCreateInfo pool_info = {
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT,
        .queryCount = 1,
    };
    const VkuDeviceDispatchTable *vk = &device.stage.vk;
    VkQueryPool pool;
    size_t size;
    assert_int_equal(vk->CreateQueryPool(device.stage.device, &pool_info, NULL, &pool), VK_SUCCESS);
    open_micromap(&from, true);
    open_micromap(&clone, true);
    open_micromap(&again, true);
    build_by_device(&from);
    const VkCopyMicromapInfoEXT copy = {.sType = VK_STRUCTURE_TYPE_COPY_MICROMAP_INFO_EXT,
                                        .src = from.ext,
                                        .dst = clone.ext,
                                        .mode = VK_COPY_MICROMAP_MODE_CLONE_EXT};
    const VkCopyMicromapToMemoryInfoEXT to_memory = {
        .sType = VK_STRUCTURE_TYPE_COPY_MICROMAP_TO_MEMORY_INFO_EXT,
        .src = clone.ext,
        .dst.deviceAddress = bytes.address,
        .mode = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT,
    };
    const VkCopyMemoryToMicromapInfoEXT from_memory = {
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_MICROMAP_INFO_EXT,
        .src.deviceAddress = bytes.address,
        .dst = again.ext,
        .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT,
    };
    VkCommandBuffer commands = device_begin(&device, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    vk->CmdResetQueryPool(commands, pool, 0, 1);
    vk->CmdCopyMicromapEXT(commands, &copy);
    vk->CmdWriteMicromapsPropertiesEXT(commands, 1, &clone.ext, pool_info.queryType, pool, 0);
    vk->CmdCopyMicromapToMemoryEXT(commands, &to_memory);
    device_finish(&device, commands);
    commands = device_begin(&device, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    vk->CmdCopyMemoryToMicromapEXT(commands, &from_memory);
    device_finish(&device, commands);
    uint64_t queried = 0;
    assert_int_equal(vk->GetQueryPoolResults(device.stage.device, pool, 0, 1, sizeof(queried),
                                             &queried, sizeof(queried), VK_QUERY_RESULT_64_BIT),
                     VK_SUCCESS);
    void *expected = serialize(&from, &size);
    assert_int_equal(queried, size);
    expect_copy(&again, expected, size);
    free(expected);
    vk->DestroyQueryPool(device.stage.device, pool, NULL);
    device_buffer_destroy(&device, &bytes);
    close_micromap(&from);
    close_micromap(&clone);
    close_micromap(&again);
    device_expect_silence(&device);
}

static void test_mistakes(void **state)
{
    (void)state;
    struct micromap micromap;
    open_micromap(&micromap, true);
    const struct stage *stage = &device.stage;
    VkMicromapBuildSizesInfoEXT sizes = {.sType = VK_STRUCTURE_TYPE_MICROMAP_BUILD_SIZES_INFO_EXT};
    VkMicromapBuildInfoEXT info = info_of(&micromap, (uint64_t)(uintptr_t)micromap.input.bytes);
    stage->vk.GetMicromapBuildSizesEXT(stage->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR,
                                       &info, &sizes);
    assert_true(sizes.micromapSize > 0 && sizes.micromapSize <= MICROMAP_SIZE);
    assert_false(sizes.discardable);
    info.pUsageCounts = (void *)(uintptr_t)0x1000;
    assert_int_equal(stage->vk.BuildMicromapsEXT(stage->device, VK_NULL_HANDLE, 1, &info),
                     VK_ERROR_VALIDATION_FAILED);
    stage->vk.GetMicromapBuildSizesEXT(stage->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR,
                                       &info, &sizes);
    assert_int_equal(sizes.micromapSize, 0);
    info.pUsageCounts = usages;
    info.data.deviceAddress = 0x1000;
    assert_int_equal(stage->vk.BuildMicromapsEXT(stage->device, VK_NULL_HANDLE, 1, &info),
                     VK_ERROR_VALIDATION_FAILED);
    assert_int_equal(build_by_host(&micromap), VK_SUCCESS);
    /* It is none that rays could be traced in. */
    const AssayTraceInfo trace = {.accelerationStructure = (uint64_t)micromap.ext,
                                  .raySize = sizeof(AssayRay),
                                  .hitSize = sizeof(AssayHit)};
    assert_int_equal(stage->trace_rays(stage->device, &trace), VK_ERROR_VALIDATION_FAILED);
    close_micromap(&micromap);
    messages_clear(&device.stage.kit.messages);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_builds),         cmocka_unit_test(test_rebuilt_and_destroyed),
        cmocka_unit_test(test_copies_by_host), cmocka_unit_test(test_copies_by_device),
        cmocka_unit_test(test_mistakes),
    };
    const char *reason = argc == 2 ? device_stage_open(&device, argv[1]) : "name a platform";
    if (reason) {
        printf("skipped: %s\n", reason);
        return 77;
    }
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    device_stage_close(&device);
    return failed;
}
