/* SPDX-License-Identifier: Apache-2.0 */
/* The host commands of backend cpu through the loader: build, trace, update, compact, serialize,
 * relocate, and what mistakes lead to. The valid calls are silent. */
#include "host_stage.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static struct stage stage;

enum {
    UPDATABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
    COMPACTABLE = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR,
};

#define expect(call) assert_int_equal(call, VK_SUCCESS)
#define expect_mistake(call) assert_int_equal(call, VK_ERROR_VALIDATION_FAILED)

static void expect_silence(void)
{
    for (uint32_t i = 0; i < messages_kept(&stage.kit.messages); i++)
        print_error("%s: %s\n", stage.kit.messages.items[i].id, stage.kit.messages.items[i].text);
    assert_int_equal(stage.kit.messages.count, 0);
}

/* Mistakes may be told or not: that is other tests' business. */
static void forget_messages(void)
{
    messages_clear(&stage.kit.messages);
}

/* ---- scenes */

/* A BLAS of some triangles, and a TLAS with two instances of it. */
struct scene {
    struct stage_build triangles, instances;
    struct stage_structure blas, tlas;
};

static void open_scene(struct scene *scene, uint32_t triangles,
                       VkBuildAccelerationStructureFlagsKHR flags)
{
    stage_triangles(&scene->triangles, triangles, flags);
    scene->blas = stage_create_for(&stage, &scene->triangles);
    expect(
        stage_build(&stage, VK_NULL_HANDLE, &scene->triangles, scene->blas.handle, VK_NULL_HANDLE));
    const VkAccelerationStructureKHR blases[] = {scene->blas.handle, scene->blas.handle};
    stage_instances(&scene->instances, blases, 2, flags);
    scene->tlas = stage_create_for(&stage, &scene->instances);
    expect(
        stage_build(&stage, VK_NULL_HANDLE, &scene->instances, scene->tlas.handle, VK_NULL_HANDLE));
}

static void close_scene(struct scene *scene)
{
    stage_destroy(&stage, &scene->tlas);
    stage_destroy(&stage, &scene->blas);
    stage_free(&scene->instances);
    stage_free(&scene->triangles);
}

static void expect_hit(VkAccelerationStructureKHR structure, float y, float t, uint32_t instance)
{
    AssayHit hit = stage_trace(&stage, structure, y, 0.25f);
    assert_true(hit.isHit);
    assert_float_equal(hit.t, t, 0);
    assert_float_equal(hit.u, 0.25, 1e-6);
    assert_float_equal(hit.v, 0.25, 1e-6);
    assert_int_equal(hit.primitive, 0);
    assert_int_equal(hit.instance, instance);
    assert_int_equal(hit.customIndex, instance == UINT32_MAX ? 0 : 100 + instance);
    assert_true(hit.isOpaque);
    assert_false(hit.isAabb);
}

static void expect_scene(VkAccelerationStructureKHR tlas, float t)
{
    expect_hit(tlas, 0.25f, t, 0);
    expect_hit(tlas, 2.25f, t, 1);
    assert_false(stage_trace(&stage, tlas, 1.5f, 0.25f).isHit);
}

static void test_build_and_trace(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, 0);
    expect_scene(scene.tlas.handle, 1);
    AssayHit hit = stage_trace(&stage, scene.blas.handle, 0.25f, 0.25f);
    assert_true(hit.isHit);
    assert_int_equal(hit.instance, 0);
    assert_int_equal(hit.customIndex, 0);
    close_scene(&scene);
    expect_silence();
}

static void test_sizes(void **state)
{
    (void)state;
    struct stage_build build;
    stage_triangles(&build, 1000, 0);
    VkAccelerationStructureBuildSizesInfoKHR sizes = stage_sizes(&stage, &build), other = sizes;
    assert_true(sizes.accelerationStructureSize > 1000 * 48);
    assert_true(sizes.buildScratchSize > sizes.updateScratchSize);
    stage.vk.GetAccelerationStructureBuildSizesKHR(
        stage.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_OR_DEVICE_KHR, &build.info,
        &build.range.primitiveCount, &other);
    assert_memory_equal(&sizes, &other, sizeof(sizes));
    build.info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;
    VkDeviceSize fast = stage_sizes(&stage, &build).buildScratchSize;
    build.info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    assert_true(stage_sizes(&stage, &build).buildScratchSize > fast);

    const VkAccelerationStructureGeometryKHR *pointer = &build.geometry;
    build.info.pGeometries = NULL;
    build.info.ppGeometries = &pointer;
    assert_int_equal(stage_sizes(&stage, &build).accelerationStructureSize,
                     sizes.accelerationStructureSize);
    build.info.geometryCount = 0;
    assert_true(stage_sizes(&stage, &build).accelerationStructureSize > 0);
    stage_free(&build);
    expect_silence();
}

/* In place, and into another structure, which leaves the source as it was. */
static void test_update(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, UPDATABLE);
    struct stage_structure other =
        stage_create(&stage, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene.blas.size);
    stage_move(&scene.triangles, 2, 0, 0);
    expect(stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, other.handle, scene.blas.handle));
    assert_float_equal(stage_trace(&stage, other.handle, 0.25f, 0.25f).t, 3, 0);
    expect_scene(scene.tlas.handle, 1);
    expect(stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, scene.blas.handle,
                       scene.blas.handle));
    expect(stage_build(&stage, VK_NULL_HANDLE, &scene.instances, scene.tlas.handle,
                       scene.tlas.handle));
    expect_scene(scene.tlas.handle, 3);
    stage_destroy(&stage, &other);
    close_scene(&scene);
    expect_silence();
}

/* ---- copies */

static uint64_t property(VkAccelerationStructureKHR structure, VkQueryType type)
{
    uint64_t values[4] = {7, 7, 7, 7};
    const VkAccelerationStructureKHR both[] = {structure, structure};
    expect(stage.vk.WriteAccelerationStructuresPropertiesKHR(stage.device, 2, both, type,
                                                             sizeof(values), values, 16));
    assert_int_equal(values[0], values[2]);
    assert_int_equal(values[1], 7);
    assert_int_equal(values[3], 7);
    return values[0];
}

static VkResult copy(VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                     VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
        .src = src,
        .dst = dst,
        .mode = mode};
    return stage.vk.CopyAccelerationStructureKHR(stage.device, VK_NULL_HANDLE, &info);
}

static void test_copies(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 100, COMPACTABLE | UPDATABLE);
    uint64_t size =
        property(scene.blas.handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR);
    assert_true(size > 0 && size <= scene.blas.size);
    assert_int_equal(property(scene.blas.handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR),
                     scene.blas.size);
    struct stage_structure compact =
        stage_create(&stage, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, size);
    struct stage_structure clone =
        stage_create(&stage, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene.blas.size);
    expect(
        copy(scene.blas.handle, compact.handle, VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR));
    expect(copy(scene.blas.handle, clone.handle, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR));
    expect_silence();
    assert_int_equal(property(compact.handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR), size);
    stage_move(&scene.triangles, 2, 0, 0);
    expect(stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, compact.handle, compact.handle));
    assert_float_equal(stage_trace(&stage, compact.handle, 0.25f, 0.25f).t, 3, 0);
    assert_float_equal(stage_trace(&stage, clone.handle, 0.25f, 0.25f).t, 1, 0);
    expect_silence();

    if (size < scene.blas.size)
        expect_mistake(
            copy(scene.blas.handle, compact.handle, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR));
    stage_destroy(&stage, &clone);
    expect_mistake(
        copy(scene.blas.handle, clone.handle, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR));
    expect_mistake(
        copy(clone.handle, compact.handle, VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR));
    stage_destroy(&stage, &compact);
    close_scene(&scene);
    forget_messages();
}

static void *serialize(VkAccelerationStructureKHR src, size_t *size)
{
    *size = property(src, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR);
    void *bytes = malloc(*size);
    const VkCopyAccelerationStructureToMemoryInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR,
        .src = src,
        .dst.hostAddress = bytes,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR};
    expect(stage.vk.CopyAccelerationStructureToMemoryKHR(stage.device, VK_NULL_HANDLE, &info));
    return bytes;
}

static VkResult deserialize(const void *bytes, VkAccelerationStructureKHR dst)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR,
        .src.hostAddress = bytes,
        .dst = dst,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR};
    return stage.vk.CopyMemoryToAccelerationStructureKHR(stage.device, VK_NULL_HANDLE, &info);
}

static VkAccelerationStructureCompatibilityKHR compatibility(const void *bytes)
{
    const VkAccelerationStructureVersionInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_VERSION_INFO_KHR, .pVersionData = bytes};
    VkAccelerationStructureCompatibilityKHR answer;
    stage.vk.GetDeviceAccelerationStructureCompatibilityKHR(stage.device, &info, &answer);
    return answer;
}

/* A scene written to memory, destroyed, and read back with other references. */
static void test_serialize_and_relocate(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 100, 0);
    size_t blas_size, tlas_size;
    uint64_t pointers =
        property(scene.tlas.handle,
                 VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR);
    assert_int_equal(pointers, 2);
    uint64_t *blas = serialize(scene.blas.handle, &blas_size);
    uint64_t *tlas = serialize(scene.tlas.handle, &tlas_size);
    assert_int_equal(blas[4], blas_size);
    assert_int_equal(tlas[4], tlas_size);
    assert_int_equal(tlas[6], 2);
    assert_int_equal(tlas[7], (uint64_t)scene.blas.handle);
    close_scene(&scene);

    struct stage_structure new_blas =
        stage_create(&stage, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, blas[5]);
    struct stage_structure new_tlas =
        stage_create(&stage, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, tlas[5]);
    assert_int_equal(compatibility(tlas), VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR);
    expect(deserialize(blas, new_blas.handle));
    expect(deserialize(tlas, new_tlas.handle));
    assert_false(stage_trace(&stage, new_tlas.handle, 0.25f, 0.25f).isHit); /* its BLAS is gone */
    const VkAccelerationStructureDeviceAddressInfoKHR address = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
        .accelerationStructure = new_blas.handle};
    tlas[7] = tlas[8] = stage.vk.GetAccelerationStructureDeviceAddressKHR(stage.device, &address);
    expect(deserialize(tlas, new_tlas.handle));
    expect_scene(new_tlas.handle, 1);
    expect_silence();

    tlas[4] -= 8;
    expect_mistake(deserialize(tlas, new_tlas.handle));
    tlas[4] = UINT64_MAX;
    expect_mistake(deserialize(tlas, new_tlas.handle));
    ((uint8_t *)tlas)[VK_UUID_SIZE] ^= 1;
    assert_int_equal(compatibility(tlas), VK_ACCELERATION_STRUCTURE_COMPATIBILITY_INCOMPATIBLE_KHR);
    expect_mistake(deserialize(tlas, new_tlas.handle));
    expect_mistake(deserialize(NULL, new_tlas.handle));
    expect_mistake(deserialize((void *)(uintptr_t)0x1000, new_tlas.handle));
    expect_scene(new_tlas.handle, 1);
    stage_destroy(&stage, &new_tlas);
    stage_destroy(&stage, &new_blas);
    free(blas);
    free(tlas);
    forget_messages();
}

/* ---- mistakes */

#define WILD ((VkAccelerationStructureKHR)0x1234567890)

static void test_wild_handles(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, UPDATABLE);
    expect_mistake(stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, WILD, VK_NULL_HANDLE));
    expect_mistake(stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, scene.blas.handle, WILD));
    expect_mistake(copy(WILD, scene.blas.handle, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR));
    uint64_t value = 1;
    const VkAccelerationStructureKHR wild = WILD;
    expect_mistake(stage.vk.WriteAccelerationStructuresPropertiesKHR(
        stage.device, 1, &wild, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR, 8, &value, 8));
    assert_int_equal(value, 0);
    expect_mistake(stage.vk.WriteAccelerationStructuresPropertiesKHR(
        stage.device, 1, &scene.blas.handle, VK_QUERY_TYPE_OCCLUSION, 8, &value, 8));
    const VkDeferredOperationKHR operation = (VkDeferredOperationKHR)0x42;
    expect_mistake(
        stage_build(&stage, operation, &scene.triangles, scene.blas.handle, VK_NULL_HANDLE));
    expect_mistake(stage.vk.DeferredOperationJoinKHR(stage.device, operation));
    expect_mistake(stage.vk.GetDeferredOperationResultKHR(stage.device, operation));
    assert_int_equal(stage.vk.GetDeferredOperationMaxConcurrencyKHR(stage.device, operation), 0);
    stage.vk.DestroyDeferredOperationKHR(stage.device, operation, NULL);
    stage.vk.DestroyDeferredOperationKHR(stage.device, VK_NULL_HANDLE, NULL);
    stage.vk.DestroyAccelerationStructureKHR(stage.device, VK_NULL_HANDLE, NULL);
    expect_scene(scene.tlas.handle, 1);
    close_scene(&scene);
    forget_messages();
}

/* An instance of what is destroyed, or not built, is as good as none. */
static void test_destroyed(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, UPDATABLE);
    expect_scene(scene.tlas.handle, 1);
    struct stage_structure empty =
        stage_create(&stage, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, scene.blas.size);
    VkAccelerationStructureInstanceKHR *instances = scene.instances.data;
    instances[1].accelerationStructureReference = (uint64_t)empty.handle;
    expect(
        stage_build(&stage, VK_NULL_HANDLE, &scene.instances, scene.tlas.handle, VK_NULL_HANDLE));
    expect_hit(scene.tlas.handle, 0.25f, 1, 0);
    assert_false(stage_trace(&stage, scene.tlas.handle, 2.25f, 0.25f).isHit);
    stage_destroy(&stage, &scene.blas);
    assert_false(stage_trace(&stage, scene.tlas.handle, 0.25f, 0.25f).isHit);
    stage_destroy(&stage, &empty);
    stage_destroy(&stage, &scene.tlas);
    AssayTraceInfo info = {.accelerationStructure = (uint64_t)scene.tlas.handle,
                           .raySize = sizeof(AssayRay),
                           .hitSize = sizeof(AssayHit)};
    expect_mistake(stage.trace_rays(stage.device, &info));
    stage_free(&scene.triangles);
    stage_free(&scene.instances);
    forget_messages();
}

static VkResult build_again(struct scene *scene)
{
    return stage_build(&stage, VK_NULL_HANDLE, &scene->triangles, scene->blas.handle,
                       VK_NULL_HANDLE);
}

/* Each leaves the structure as it was. */
static void test_bad_pointers(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, UPDATABLE);
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *hole = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    mprotect(hole + page, page, PROT_NONE);
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &scene.triangles.geometry.geometry.triangles;
    const VkAccelerationStructureGeometryTrianglesDataKHR valid = *triangles;

    triangles->vertexData.hostAddress = NULL;
    expect_mistake(build_again(&scene));
    triangles->vertexData.hostAddress = hole + page - 100; /* three triangles are 108 bytes */
    expect_mistake(build_again(&scene));
    triangles->vertexData.hostAddress = hole + page - 10 * 36;
    expect(build_again(&scene));
    *triangles = valid;
    triangles->vertexStride = UINT64_MAX;
    expect_mistake(build_again(&scene));
    *triangles = valid;
    triangles->indexType = VK_INDEX_TYPE_UINT32;
    triangles->indexData.hostAddress = hole + page - 119;
    expect_mistake(build_again(&scene));
    triangles->indexData.hostAddress = hole + page - 120;
    expect(build_again(&scene));
    memset(hole, 0xff, page); /* wild indices */
    expect_mistake(build_again(&scene));
    *triangles = valid;
    triangles->transformData.hostAddress = hole + page - 47;
    expect_mistake(build_again(&scene));
    *triangles = valid;
    triangles->vertexFormat = VK_FORMAT_D32_SFLOAT;
    expect_mistake(build_again(&scene));
    *triangles = valid;

    scene.triangles.info.scratchData.hostAddress = hole + page; /* the backend has its own */
    expect(build_again(&scene));
    scene.triangles.info.scratchData.hostAddress = scene.triangles.scratch;
    scene.triangles.info.pGeometries = (const void *)(hole + page - 8);
    expect_mistake(build_again(&scene));
    scene.triangles.info.pGeometries = &scene.triangles.geometry;
    scene.instances.geometry.geometry.instances.arrayOfPointers = VK_TRUE;
    expect_mistake(
        stage_build(&stage, VK_NULL_HANDLE, &scene.instances, scene.tlas.handle, VK_NULL_HANDLE));
    expect_mistake(stage.vk.WriteAccelerationStructuresPropertiesKHR(
        stage.device, 1, &scene.blas.handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR, 8,
        hole + page, 8));
    expect(build_again(&scene));
    expect_scene(scene.tlas.handle, 1);
    munmap(hole, 2 * page);
    close_scene(&scene);
    forget_messages();
}

/* A shape that the source hasn't, and a structure that is too small. */
static void test_bad_builds(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, UPDATABLE);
    scene.triangles.range.primitiveCount = 9;
    expect_mistake(stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, scene.blas.handle,
                               scene.blas.handle));
    scene.triangles.range.primitiveCount = 10;
    struct stage_structure small =
        stage_create(&stage, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, 256);
    expect_mistake(
        stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, small.handle, VK_NULL_HANDLE));
    expect_mistake(
        stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, scene.blas.handle, small.handle));
    stage_destroy(&stage, &small);
    expect_scene(scene.tlas.handle, 1);
    close_scene(&scene);
    forget_messages();
}

/* ---- names */

static void test_names(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, 0);
    VkDebugUtilsObjectNameInfoEXT name = {.sType =
                                              VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                          .objectType = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                          .objectHandle = (uint64_t)scene.blas.handle,
                                          .pObjectName = "bunny"};
    expect(stage.vk.SetDebugUtilsObjectNameEXT(stage.device, &name));
    const VkDebugUtilsObjectTagInfoEXT tag = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_TAG_INFO_EXT,
        .objectType = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
        .objectHandle = (uint64_t)scene.blas.handle,
        .tagSize = 4,
        .pTag = "tag"};
    expect(stage.vk.SetDebugUtilsObjectTagEXT(stage.device, &tag));
    name.objectType = VK_OBJECT_TYPE_BUFFER; /* the driver's own */
    name.objectHandle = (uint64_t)scene.blas.buffer;
    expect(stage.vk.SetDebugUtilsObjectNameEXT(stage.device, &name));
    close_scene(&scene);
    expect_silence();
}

static void set_data(VkPrivateDataSlot slot, VkObjectType type, uint64_t object, uint64_t value)
{
    expect(stage.vk.SetPrivateData(stage.device, type, object, slot, value));
}

static uint64_t get_data(VkPrivateDataSlot slot, VkObjectType type, uint64_t object)
{
    uint64_t value = 99;
    stage.vk.GetPrivateData(stage.device, type, object, slot, &value);
    return value;
}

static void test_private_data(void **state)
{
    (void)state;
    if (!stage.vk.SetPrivateData)
        skip();
    const VkPrivateDataSlotCreateInfo info = {.sType =
                                                  VK_STRUCTURE_TYPE_PRIVATE_DATA_SLOT_CREATE_INFO};
    struct scene scene;
    open_scene(&scene, 10, 0);
    const uint64_t blas = (uint64_t)scene.blas.handle, tlas = (uint64_t)scene.tlas.handle;
    const VkObjectType type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    const uint64_t buffer = (uint64_t)scene.blas.buffer;
    VkPrivateDataSlot slots[2];
    for (int i = 0; i < 2; i++)
        expect(stage.vk.CreatePrivateDataSlot(stage.device, &info, NULL, &slots[i]));
    set_data(slots[0], type, blas, 1);
    set_data(slots[1], type, blas, 2);
    set_data(slots[0], type, tlas, 3);
    set_data(slots[0], VK_OBJECT_TYPE_BUFFER, buffer, 4);
    set_data(slots[0], type, blas, 5);
    assert_int_equal(get_data(slots[0], type, blas), 5);
    assert_int_equal(get_data(slots[1], type, blas), 2);
    assert_int_equal(get_data(slots[0], type, tlas), 3);
    assert_int_equal(get_data(slots[1], type, tlas), 0);
    assert_int_equal(get_data(slots[0], VK_OBJECT_TYPE_BUFFER, buffer), 4);
    stage.vk.DestroyPrivateDataSlot(stage.device, slots[0], NULL);
    expect(stage.vk.CreatePrivateDataSlot(stage.device, &info, NULL, &slots[0]));
    assert_int_equal(get_data(slots[0], type, tlas), 0);
    assert_int_equal(get_data(slots[1], type, blas), 2);
    set_data(slots[0], type, blas, 6);
    close_scene(&scene);
    assert_int_equal(get_data(slots[0], type, blas), 0);
    for (int i = 0; i < 2; i++)
        stage.vk.DestroyPrivateDataSlot(stage.device, slots[i], NULL);
    expect_silence();
}

/* ---- counters: paired scenes, one thing apart */

static AssayCounters minus(AssayCounters after, AssayCounters before)
{
    uint64_t *values = (uint64_t *)&after;
    for (size_t i = 0; i < sizeof(after) / sizeof(*values); i++)
        values[i] -= ((const uint64_t *)&before)[i];
    return after;
}

static void test_counters(void **state)
{
    (void)state;
    AssayCounters start = stage_counters(&stage);
    struct scene scene;
    open_scene(&scene, 10, UPDATABLE);
    AssayCounters did = minus(stage_counters(&stage), start);
    AssayCounters expected = {
        .builds = 2, .primitives = 12, .bytesBuilt = scene.blas.size + scene.tlas.size};
    assert_memory_equal(&did, &expected, sizeof(did));

    start = stage_counters(&stage);
    stage_build(&stage, VK_NULL_HANDLE, &scene.triangles, scene.blas.handle, scene.blas.handle);
    did = minus(stage_counters(&stage), start);
    expected = (AssayCounters){.updates = 1, .primitives = 10, .bytesBuilt = scene.blas.size};
    assert_memory_equal(&did, &expected, sizeof(did));

    /* Beside the triangles nothing is tested; within one, without need of exactness; through an
     * edge with. */
    start = stage_counters(&stage);
    stage_trace(&stage, scene.blas.handle, 5, 5);
    did = minus(stage_counters(&stage), start);
    assert_int_equal(did.rays, 1);
    assert_int_equal(did.primitivesTested, 0);
    stage_trace(&stage, scene.blas.handle, 0.25f, 0.25f);
    did = minus(stage_counters(&stage), start);
    assert_true(did.primitivesTested > 0);
    assert_int_equal(did.exactCalls, 0);
    stage_trace(&stage, scene.blas.handle, 0.5f, 0.5f);
    did = minus(stage_counters(&stage), start);
    assert_true(did.exactCalls > 0);
    assert_int_equal(did.builds + did.updates + did.copies + did.instancesEntered, 0);

    char part[12];
    memset(part, 0x55, sizeof(part));
    stage.get_counters(stage.device, 8, (AssayCounters *)(void *)part);
    uint64_t builds;
    memcpy(&builds, part, 8);
    assert_int_equal(builds, stage_counters(&stage).builds);
    assert_int_equal(part[8], 0x55);
    close_scene(&scene);
    expect_silence();
}

/* ---- trace arguments */

static void test_trace_arguments(void **state)
{
    (void)state;
    struct scene scene;
    open_scene(&scene, 10, 0);
    AssayRay rays[2] = {0};
    AssayHit hits[2];
    const AssayTraceInfo valid = {.accelerationStructure = (uint64_t)scene.tlas.handle,
                                  .accuracy = ASSAY_ACCURACY_FAST,
                                  .rayCount = 2,
                                  .raySize = sizeof(rays[0]),
                                  .hitSize = sizeof(hits[0]),
                                  .rays = rays,
                                  .hits = hits};
    AssayTraceInfo info = valid;
    expect(stage.trace_rays(stage.device, &info));
    assert_false(hits[0].isHit || hits[1].isHit); /* no direction */
    info.raySize--;
    expect_mistake(stage.trace_rays(stage.device, &info));
    info = valid;
    info.hitSize++;
    expect_mistake(stage.trace_rays(stage.device, &info));
    info = valid;
    info.accuracy = (AssayAccuracy)3;
    expect_mistake(stage.trace_rays(stage.device, &info));
    info = valid;
    info.rays = NULL;
    expect_mistake(stage.trace_rays(stage.device, &info));
    info = valid;
    info.hits = (AssayHit *)(uintptr_t)0x1000;
    expect_mistake(stage.trace_rays(stage.device, &info));
    info = valid;
    info.accelerationStructure++;
    expect_mistake(stage.trace_rays(stage.device, &info));
    info.rayCount = 0;
    info = valid;
    expect(stage.trace_rays(stage.device, &info));
    expect_mistake(stage.trace_rays(stage.device, NULL));
    close_scene(&scene);
    expect_silence();
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_build_and_trace),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_update),
        cmocka_unit_test(test_copies),
        cmocka_unit_test(test_serialize_and_relocate),
        cmocka_unit_test(test_wild_handles),
        cmocka_unit_test(test_destroyed),
        cmocka_unit_test(test_bad_pointers),
        cmocka_unit_test(test_bad_builds),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_private_data),
        cmocka_unit_test(test_counters),
        cmocka_unit_test(test_trace_arguments),
    };
    const char *reason = argc == 2 ? stage_open(&stage, argv[1]) : "a platform is to be named";
    if (reason) {
        printf("skipped: %s\n", reason);
        return 77;
    }
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stage_close(&stage);
    return failed;
}
